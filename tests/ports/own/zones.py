"""Zones of the vectors as the compiled functions of the augmented Lagrangian take them."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.serial.lagrangian import Zone, renew_constraints
from izo_ref.zones.problem import ZoneProblem

Array = NDArray[Any]
DTYPES = {"f8": np.float64, "f4": np.float32}


def rounded(numbers: Any, dtype: str) -> Array:
    """Return numbers as a port reads them: rounded to its type; here they are float64 again."""
    return np.asarray(numbers, DTYPES[dtype]).astype(np.float64)


class OwnZone(NamedTuple):
    """A zone, and which rows of its x belong to which vertices."""

    zone: Zone
    unpinned: Array  # the vertices of the rows of x, all but the last one
    n_vertices: int

    def spread(self, rows: Array) -> list[float]:
        """Return rows of x for all vertices, flat; 0 at pinned ones."""
        everywhere = np.zeros((self.n_vertices, 3))
        everywhere[self.unpinned] = rows.reshape(-1, 3)[:-1]
        return everywhere.ravel().tolist()

    def gather(self, vectors: Array) -> Array:
        """Return vectors of all vertices, flat, as rows of x."""
        kept = vectors.reshape(-1, 3)[self.unpinned]
        return np.append(kept.ravel(), np.zeros(3)).astype(self.zone.x.dtype)


def own_problem(inputs: dict[str, Any], dtype: str) -> ZoneProblem:
    """Return the zone problem of a case, in which pinned vertices have an infinite mass."""
    numbers = {name: rounded(inputs[name], dtype) for name in ("weights", "normals", "proposed")}
    pinned = np.array(inputs["pinned"], bool)
    return ZoneProblem(
        np.reshape(inputs["nodes"], (-1, 4)),
        numbers["weights"].reshape(-1, 4),
        numbers["normals"].reshape(-1, 3),
        numbers["proposed"].reshape(-1, 3),
        np.where(pinned, np.inf, rounded(inputs["masses"], dtype)),
        float(rounded(inputs["thickness"], dtype)),
    )


def own_zone(problem: ZoneProblem, inputs: dict[str, Any], dtype: str) -> OwnZone:
    """Return the zone of a case at its positions, in metres, with the curvatures 2 m / sum m."""
    kind, n_impacts = DTYPES[dtype], len(problem.nodes)
    unpinned = np.flatnonzero(np.isfinite(problem.masses))
    row = np.full(len(problem.masses), len(unpinned))  # pinned vertices share the last row
    row[unpinned] = np.arange(len(unpinned))
    nodes, masses = row[problem.nodes], problem.masses[unpinned]
    coefficients = np.where(nodes == len(unpinned), 0.0, problem.weights)
    order = np.argsort(nodes, axis=None, kind="stable")
    entries = order[nodes.ravel()[order] < len(unpinned)]
    arms = coefficients.ravel()[entries, None] * problem.normals[entries // 4]
    counts = np.bincount(nodes.ravel()[entries], minlength=len(unpinned) + 1)
    moved = (rounded(inputs["positions"], dtype).reshape(-1, 3) - problem.proposed)[unpinned]
    multipliers = rounded(inputs.get("multipliers", np.zeros(n_impacts)), dtype)
    n = 3 * len(unpinned) + 3
    zone = Zone(
        (3 * nodes).astype(np.uint32),
        coefficients.astype(kind),
        (entries // 4).astype(np.uint32),
        arms.astype(kind),
        np.concatenate(([0], np.cumsum(counts))).astype(np.uint64),
        problem.normals.astype(kind),
        (-problem.gaps(problem.proposed)).astype(kind),
        np.ones(n_impacts, kind),
        np.append(np.repeat(2.0 * masses / masses.sum(), 3), np.ones(3)).astype(kind),
        np.append(moved.ravel(), np.zeros(3)).astype(kind),
        multipliers.astype(kind),
        *(np.zeros(n, kind) for _ in range(4)),
        *(np.zeros(n_impacts, kind) for _ in range(3)),
        np.zeros(0, kind),
        np.zeros(9),
        ALONE,
        np.zeros(1, bool),
    )
    renew_constraints(zone)
    return OwnZone(zone, unpinned, len(problem.masses))
