"""One large zone: from its last solution by pivoting; else by sweeps or the interior point.

Impacts between vertices that have little to do with each other are solved in some hundred
sweeps, while factors fill up: a random zone of 4096 impacts takes 0.14 s by sweeps and 10 s by
factorisations. Layers in contact are the other way round: 5 ms by factorisations and 0.2 s by
sweeps for a zone of 1374 impacts of stack-6k.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.solvers.cpu import zones as kernels
from izo_ref.solvers.interior_point import interior_point
from izo_ref.solvers.pivoting import pivot_from
from izo_ref.solvers.serial.constraints import products, pull

# Sweeps before the interior point, for its start, and at most where they do it all.
FIRST_SWEEPS, MORE_SWEEPS = 16, 2000
# Width of the band around the diagonal, over the vertices: 0.41 for random zones of any size,
# 0.001 to 0.08 for chains, piles, and all zones of real steps from 1374 to 43,036 impacts.
ENTANGLED = 0.2
# Of the tolerances, so that rounding elsewhere does not lift the residuals over them.
TOLERANCE_SHARE = 0.5


class LargeZone(NamedTuple):
    """The rows of one zone."""

    nodes: np.ndarray  # (m, 4) i4, into the zone's vertices; -1 for pinned ones
    coefficients: np.ndarray  # (m, 4) f8; with the normals, unit rows
    normals: np.ndarray  # (m, 3) f8
    rhs: np.ndarray  # (m,) f8 [m kg^1/2], s; at least one entry is positive
    lengths: np.ndarray  # (m,) f8 [kg^-1/2], of the rows before scaling
    n_vertices: int  # that are not pinned

    def times(self, z):
        """C z, (m,), for z (3 n_vertices,)."""
        out = np.empty(len(self.rhs))
        products(0, self.nodes, self.coefficients, self.normals, z, out)
        return out

    def pull(self, multipliers):
        """C^T u, (3 n_vertices,), for u (m,)."""
        out = np.empty(3 * self.n_vertices)
        pull(0, self.nodes, self.coefficients, self.normals, multipliers, out)
        return out


def solve_large_zone(zone: LargeZone, start, gap_tolerance, violation_tolerance, interior_only):
    """Solve one zone.

    Args:
        zone: `LargeZone`.
        start: (m,) f8, multipliers of the last solution, of unit rows; zeros if there is none.
        gap_tolerance: relative duality gap.
        violation_tolerance: [m].
        interior_only: whether the interior point has to end it.

    Returns:
        z (n,), multipliers (m,), the method that ended it, its steps, and whether the rows are
        satisfied.
    """
    tolerances = TOLERANCE_SHARE * gap_tolerance, TOLERANCE_SHARE * violation_tolerance
    of_unit_rows = violation_tolerance / zone.lengths.max()
    if start.any() and not interior_only:
        solution = pivot_from(zone, start, gap_tolerance, of_unit_rows)
        if solution is not None:
            return *solution[:2], "pivoting", solution[2], True
    u, z = np.zeros(len(zone.rhs)), np.zeros((zone.n_vertices, 3))
    sweeps_may_do = not interior_only and is_entangled(zone)
    most = MORE_SWEEPS if sweeps_may_do else FIRST_SWEEPS
    steps = _sweep(zone, most, *tolerances, u, z)
    if sweeps_may_do and steps < most:
        return z.ravel(), u, "apgs", steps, True
    solution = interior_point(zone, (z.ravel(), u), gap_tolerance, of_unit_rows)
    return *solution[:2], "interior-point", *solution[2:]


def _sweep(zone, count, gap_tolerance, violation_tolerance, u, z):
    """Go on from u by at most so many sweeps; returns how many."""
    steps = np.zeros(1, np.int32)
    kernels.solve_sweeps.alone(
        np.array([0, len(u)]),
        np.array([0, len(z)]),
        zone.nodes,
        zone.coefficients,
        zone.normals,
        zone.rhs,
        zone.lengths,
        True,
        count,
        gap_tolerance,
        violation_tolerance,
        u,
        z.ravel(),
        steps,
        np.empty((1, 0, 2)),
    )
    return int(steps[0])


def is_entangled(zone):
    """Whether no order of the vertices keeps the vertices of each impact close together."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    n = zone.n_vertices
    free = zone.nodes >= 0
    lowest = np.where(free, zone.nodes, n).min(axis=1)
    if np.mean((zone.nodes.max(axis=1) - lowest) ** 2.0) <= (ENTANGLED * n) ** 2:
        return False  # the order that is there does it, as the one along a curve mostly
    starts = np.concatenate(([0], np.cumsum(free.sum(axis=1))))
    ones = np.ones(starts[-1], np.int32)
    rows = csr_array((ones, zone.nodes[free], starts), shape=(len(zone.nodes), n))
    graph = (rows.T @ rows).tocsr()
    place = np.argsort(reverse_cuthill_mckee(graph, symmetric_mode=True))
    lowest = place.copy()
    np.minimum.at(lowest, np.repeat(np.arange(n), np.diff(graph.indptr)), place[graph.indices])
    return float(np.sqrt(np.mean((place - lowest) ** 2.0))) > ENTANGLED * n
