"""Solve one large zone.

If the zone has a last solution, and fewer impacts than unknowns, block pivoting starts from it.
Otherwise, and if block pivoting gives up, the zone is solved by sweeps or by the interior point:

* Sweeps are fast if most impacts have little to do with each other. A random zone of 4096 impacts
  takes some hundred sweeps, 0.14 s. Its factors fill up, and factorisations take 10 s.
* Layers in contact are the other way round. A zone of 1374 impacts of stack-6k takes 5 ms by
  factorisations and 0.2 s by sweeps.

The interior point ends some 1e-9 to 1e-6 from the optimum, which is the root of its gap. Its answer
is then moved onto its active constraints.

The tolerance of a violation is a fraction of the thickness. Floats may not reach it: if impacts are
100 m deep, C z has a rounding of some 1e-13 m, which is the tolerance at a thickness of 1e-4 m. A
method then aims beyond the thickness, by more than what it may miss. It hits the tolerance that was
asked for, and the aim is so near that it changes the objective by less than the gap's tolerance.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Multipliers
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.solvers.cpu import zones as kernels
from izo_ref.solvers.interior_point import FARTHEST, interior_point
from izo_ref.solvers.pivoting import pivot_from, polish
from izo_ref.solvers.scaled_constraints import LargeZone
from izo_ref.solvers.serial.constraints import ROUNDING

# Sweeps that give the interior point its start.
FIRST_SWEEPS = 16
# Least and largest number of sweeps if sweeps alone are to solve a zone of m impacts, and m^2 over
# the number between them. Sweeps should end when they have taken as long as the interior point
# would. Their time grows with m, and that of the interior point with m^3 where factors fill up. On
# random zones it takes as long as some m^2 / 500 sweeps. With 2000 sweeps for all sizes, those with
# redundant impacts took 34, 55 and 95 ms for 257, 400 and 600 impacts, instead of 9, 20 and 46 ms.
LEAST_SWEEPS, MOST_SWEEPS, SWEEPS_DIVISOR = 100, 2000, 500
# Width of the band around the diagonal as a fraction of the number of vertices, from which on a
# zone is entangled. The width is 0.41 for random zones of any size, and 0.001 to 0.08 for chains,
# piles, and all zones of real steps from 1374 to 43,036 impacts.
ENTANGLED = 0.2
# Fraction of the tolerances that sweeps have to reach, so that rounding elsewhere does not lift
# the residuals over the tolerances.
TOLERANCE_SHARE = 0.5
# A zone is solved again if it was missed by at most this many times the tolerance. With the default
# tolerance of 1e-9, the new aim is then within 1e-6 of the thickness, so that the impacts that push
# still count as tight (`detection/serial/tight.py`).
LARGEST_MISS = 500.0
# A method that aims beyond the thickness may miss its aim by this share of the distance.
MISSED_SHARE = 0.5
# Ill-conditioned zones of a sheet whose vertices are thrown at random, of some 500 impacts, were
# missed by 3 and by 330 times the tolerance. A second aim was enough for them.
MOST_AIMS = 3


class LargeSolution(NamedTuple):
    """The solution of one large zone, in scaled variables."""

    z: Floats  # (3 n_vertices,) f8 [m kg^1/2]
    multipliers: Multipliers  # (m,) f8 [m kg^1/2], of the constraints of unit length
    method: str  # the method that ended it
    steps: int  # of this method
    solved: bool


def solve_large_zone(
    zone: LargeZone,
    start: Multipliers,
    gap_tolerance: float,
    violation_tolerance: float,
    interior_only: bool,
    farthest: float = FARTHEST,
    deadline: Deadline = UNLIMITED,
) -> LargeSolution:
    """Solve one zone.

    Args:
        zone: The zone.
        start: (m,) f8 [m kg^1/2], multipliers of the last solution, of the constraints of unit
            length; zeros if there is no last solution.
        gap_tolerance: Largest relative duality gap.
        violation_tolerance: Largest violation [m].
        interior_only: Whether to allow no other method than the interior point.
        farthest: Largest |z| of a solution, over the largest rhs.
        deadline: When the methods have to end.

    Returns:
        The solution.
    """
    missed = _rounding_m(zone)
    if missed <= TOLERANCE_SHARE * violation_tolerance:
        missed = 0.0
    n_aims = 0
    while True:
        beyond = missed / (1.0 - MISSED_SHARE)
        solution = _solve(
            zone._replace(rhs=zone.rhs + beyond / zone.lengths) if beyond else zone,
            start,
            gap_tolerance,
            violation_tolerance + MISSED_SHARE * beyond,
            interior_only,
            farthest,
            deadline,
        )
        n_aims += 1
        if solution.solved:
            return solution
        off = float(np.max((zone.rhs - zone.times(solution.z)) * zone.lengths))
        if missed > 0.0 and off <= violation_tolerance:  # the aim alone was missed
            return solution._replace(solved=True)
        missed += off
        if n_aims == MOST_AIMS or not 0.0 < missed <= LARGEST_MISS * violation_tolerance:
            return solution


def _rounding_m(zone: LargeZone) -> float:
    """Return how far rounding may keep a constraint of a zone from its right-hand side [m].

    The terms of a constraint are as long as its right-hand side and two displacements. No
    displacement is much longer than the deepest impact.
    """
    return 3.0 * ROUNDING * float(np.max(zone.rhs * zone.lengths))


def _solve(
    zone: LargeZone,
    start: Multipliers,
    gap_tolerance: float,
    violation_tolerance: float,
    interior_only: bool,
    farthest: float,
    deadline: Deadline,
) -> LargeSolution:
    """Solve one zone; the arguments are those of `solve_large_zone`."""
    tolerances = TOLERANCE_SHARE * gap_tolerance, TOLERANCE_SHARE * violation_tolerance
    scaled_tolerance = violation_tolerance / zone.lengths.max()
    # No more constraints can be independent than there are unknowns. In a deep step with 1,080
    # unknowns and up to 2,100 impacts, pivoting gave up on 12 of 15 such zones, after 3.2 s in all,
    # where the interior point took 1.4 s for all of them.
    is_redundant = len(zone.rhs) >= 3 * zone.n_vertices
    if start.any() and not interior_only and not is_redundant:
        solution = pivot_from(zone, start, gap_tolerance, scaled_tolerance, deadline)
        if solution is not None:
            return LargeSolution(*solution[:2], "pivoting", solution[2], True)
    u, z = np.zeros(len(zone.rhs)), np.zeros(3 * zone.n_vertices)
    sweeps_may_solve = not interior_only and is_entangled(zone)
    most = _most_sweeps(len(u)) if sweeps_may_solve else FIRST_SWEEPS
    steps = _sweep(zone, most, *tolerances, deadline.stop, u, z)
    deadline.check()
    if sweeps_may_solve and steps < most:
        return LargeSolution(z, u, "apgs", steps, True)
    z, u, steps, solved = interior_point(
        zone, (z, u), gap_tolerance, scaled_tolerance, farthest, deadline
    )
    if solved and not interior_only and not is_redundant:
        z, u = polish(zone, z, u, scaled_tolerance, deadline)
    return LargeSolution(z, u, "interior-point", steps, solved)


def _most_sweeps(n_impacts: int) -> int:
    """Return the largest number of sweeps if sweeps alone are to solve a zone."""
    return min(max(n_impacts**2 // SWEEPS_DIVISOR, LEAST_SWEEPS), MOST_SWEEPS)


def _sweep(
    zone: LargeZone,
    count: int,
    gap_tolerance: float,
    violation_tolerance: float,
    stop: Flags,
    u: Multipliers,
    z: Floats,
) -> int:
    """Sweep at most `count` times from the multipliers u on, in place; return how many times."""
    steps = np.zeros(1, np.int32)
    kernels.solve_sweeps.alone(
        range(1),
        np.array([0, len(u)]),
        np.array([0, zone.n_vertices]),
        zone.nodes,
        zone.coefficients,
        zone.normals,
        zone.rhs,
        zone.lengths,
        True,
        count,
        gap_tolerance,
        violation_tolerance,
        stop,
        u,
        z,
        steps,
        np.empty((1, 0, 2)),
    )
    return int(steps[0])


def is_entangled(zone: LargeZone) -> bool:
    """Return whether no order of the vertices keeps the vertices of each impact close together."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    n = zone.n_vertices
    unpinned = zone.nodes >= 0
    lowest = np.where(unpinned, zone.nodes, n).min(axis=1)
    if np.mean((zone.nodes.max(axis=1) - lowest) ** 2.0) <= (ENTANGLED * n) ** 2:
        return False  # the present order does it; an order along a curve mostly does
    starts = np.concatenate(([0], np.cumsum(unpinned.sum(axis=1))))
    ones = np.ones(starts[-1], np.int32)
    incidence = csr_array((ones, zone.nodes[unpinned], starts), shape=(len(zone.nodes), n))
    graph = (incidence.T @ incidence).tocsr()
    place = np.argsort(reverse_cuthill_mckee(graph, symmetric_mode=True))
    lowest = place.copy()
    np.minimum.at(lowest, np.repeat(np.arange(n), np.diff(graph.indptr)), place[graph.indices])
    return float(np.sqrt(np.mean((place - lowest) ** 2.0))) > ENTANGLED * n
