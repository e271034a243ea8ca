"""A zone of the porting kit as the compiled functions of the augmented Lagrangian take it."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyFloats, Floats, Indices
from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.serial.lagrangian import N_STATES, Zone, renew_constraints
from izo_ref.zones.problem import ZoneProblem


class ZoneArrays(NamedTuple):
    """A zone at some positions, and which rows of its x belong to which vertices.

    Attributes:
        zone: In metres, with the curvatures 2 m / sum m.
        unpinned: The vertices of the rows of x, all but the last row, which pinned ones share.
        n_vertices: Number of vertices.
    """

    zone: Zone
    unpinned: Indices
    n_vertices: int

    def by_vertex(self, rows: AnyFloats) -> Floats:
        """Return rows of x for all vertices, flat; 0 at pinned ones."""
        everywhere = np.zeros((self.n_vertices, 3))
        everywhere[self.unpinned] = rows.reshape(-1, 3)[:-1]
        return everywhere.ravel()

    def rows_of(self, vectors: AnyFloats) -> AnyFloats:
        """Return vectors of all vertices, flat, as rows of x."""
        kept = vectors.reshape(-1, 3)[self.unpinned]
        return np.append(kept.ravel(), np.zeros(3)).astype(self.zone.x.dtype)


def rounded(numbers: Any, kind: type[Any]) -> Floats:
    """Return numbers as a port reads them: rounded to its type; here they are float64 again."""
    return np.asarray(numbers, kind).astype(np.float64)


def problem_of(inputs: Mapping[str, Any], kind: type[Any] = np.float64) -> ZoneProblem:
    """Return the zone problem of the inputs of a stage; pinned vertices get an infinite mass."""
    names = ("weights", "normals", "proposed", "masses")
    numbers = {name: rounded(inputs[name], kind) for name in names}
    return ZoneProblem(
        np.array(inputs["nodes"], np.int32).reshape(-1, 4),
        numbers["weights"].reshape(-1, 4),
        numbers["normals"].reshape(-1, 3),
        numbers["proposed"].reshape(-1, 3),
        np.where(np.array(inputs["pinned"], bool), np.inf, numbers["masses"]),
        float(rounded(inputs["thickness"], kind)),
    )


def zone_arrays(problem: ZoneProblem, inputs: Mapping[str, Any], kind: type[Any]) -> ZoneArrays:
    """Return the zone of a case at its positions.

    Args:
        problem: The zone problem.
        inputs: `positions`, and `multipliers` if there are any, flat.
        kind: Type of the floats, float64 or float32.
    """
    n_impacts = len(problem.nodes)
    unpinned = np.flatnonzero(np.isfinite(problem.masses))
    row = np.full(len(problem.masses), len(unpinned))
    row[unpinned] = np.arange(len(unpinned))
    nodes, masses = row[problem.nodes], problem.masses[unpinned]
    coefficients = np.where(nodes == len(unpinned), 0.0, problem.weights)
    order = np.argsort(nodes, axis=None, kind="stable")
    entries = order[nodes.ravel()[order] < len(unpinned)]
    arms = coefficients.ravel()[entries, None] * problem.normals[entries // 4]
    counts = np.bincount(nodes.ravel()[entries], minlength=len(unpinned) + 1)
    moved = (rounded(inputs["positions"], kind).reshape(-1, 3) - problem.proposed)[unpinned]
    n = 3 * len(unpinned) + 3
    zone = Zone(
        nodes=(3 * nodes).astype(np.uint32),
        coefficients=coefficients.astype(kind),
        entries=(entries // 4).astype(np.uint32),
        arms=arms.astype(kind),
        entry_starts=np.concatenate(([0], np.cumsum(counts))).astype(np.uint64),
        normals=problem.normals.astype(kind),
        starts=(-problem.gaps(problem.proposed)).astype(kind),
        metres=np.ones(n_impacts, kind),
        curvatures=np.append(np.repeat(2.0 * masses / masses.sum(), 3), np.ones(3)).astype(kind),
        x=np.append(moved.ravel(), np.zeros(3)).astype(kind),
        multipliers=np.asarray(inputs.get("multipliers", np.zeros(n_impacts)), kind).copy(),
        gradient=np.zeros(n, kind),
        direction=np.zeros(n, kind),
        diagonal=np.zeros(n, kind),
        previous=np.zeros(n, kind),
        constraints=np.zeros(n_impacts, kind),
        pushed=np.zeros(n_impacts, kind),
        along=np.zeros(n_impacts, kind),
        memory=np.zeros(0, kind),
        state=np.zeros(N_STATES),
        group=ALONE,
        stop=np.zeros(1, bool),
    )
    renew_constraints(zone)
    return ZoneArrays(zone, unpinned, len(problem.masses))
