"""Block pivoting for one large zone that was solved before with fewer impacts, and polishing.

In scaled variables (docs/method section 5) the multipliers minimise 1/2 |C^T u|^2 - s . u over
u >= 0. Let F be the set of active constraints, those with a positive multiplier. The last solution
nearly says what F is. Given F, one factorisation gives all multipliers:

    (C_F C_F^T + rho) u_F = s_F + rho v_F,    u = 0 elsewhere.

rho makes the matrix regular if constraints are redundant. v is an earlier u: the start, and later
the u of the last solve whose F was right. If v = u, then the terms with rho cancel, so v follows u
once F is right. This is the proximal-point method, which converges for any rho.

After each solve, constraints of F with u < 0 are on the wrong side, and so are other constraints
with C z < s. At first all of them change sides at once. Where constraints depend on each other,
this overshoots: of several violated constraints at the same vertices, one alone would do, and so
with several that have u < 0. Let n be the smallest number of constraints on the wrong side so far.
If a solve leaves more than FALLS n of them, only those change sides that are farther on the wrong
side than all others that share a vertex with them. This can repeat for ever, too. So after PATIENCE
solves without a new minimum, those with the highest numbers at their vertices change sides instead.
The method is given up after MAX_STEPS solves, and the interior point takes over.

Source: L. F. Portugal, J. J. Judice, L. N. Vicente, A comparison of block pivoting and
interior-point algorithms for linear least squares problems with nonnegative variables (1994);
R. T. Rockafellar, Monotone operators and the proximal point algorithm (1976).
"""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Multipliers
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.solvers.scaled_constraints import LargeZone
from izo_ref.solvers.serial.exchange_rules import (
    FALLS,
    MAX_STEPS,
    PATIENCE,
    RHO,
    STALLED_SLOP,
    TOLERATED_SLOP,
)
from izo_ref.solvers.serial.gram import gram_products
from izo_ref.solvers.serial.interior import residuals
from izo_ref.solvers.serial.settings import LEAST_TOLERANCE
from izo_ref.solvers.sparse import SparseCholesky

# rho of a polished answer. On random zones and stacks of 300 to 1500 impacts with mass ratios of 1
# and 1e12, the active constraints were found in 1 to 4 factorisations, and in up to 8 with 1e-12 or
# less. With 1e-8 some corrections stopped early.
POLISH_RHO = 1e-10
POLISHES = 4  # factorisations of a polished answer
CORRECTIONS = 12  # of one factorisation, most of which end after 2 to 5


def pivot_from(
    zone: LargeZone,
    start: Multipliers,
    gap_tolerance: float,
    violation_tolerance: float,
    deadline: Deadline = UNLIMITED,
) -> tuple[Floats, Multipliers, int] | None:
    """Solve a zone if the start is near enough to the solution.

    Args:
        zone: The zone.
        start: (m,) f8 [m kg^1/2], multipliers of the constraints of unit length, >= 0; 0 for
            inactive impacts.
        gap_tolerance: Largest relative duality gap.
        violation_tolerance: Largest s - C z, in the unit of rhs.
        deadline: When the solves have to end.

    Returns:
        z, (3 n_vertices,) f8, the multipliers, (m,) f8, and the number of solves; None if the
        method gave up.
    """
    scale = zone.rhs.max()
    s, v = zone.rhs / scale, start / scale
    # Constraints that are violated by no more than this do not enter: rounding could make them
    # enter and leave for ever.
    gap_tolerance = max(gap_tolerance, LEAST_TOLERANCE)
    violation_tolerance = max(violation_tolerance, LEAST_TOLERANCE)
    slop = TOLERATED_SLOP * violation_tolerance / scale
    dual, primal, no_slack = np.empty(3 * zone.n_vertices), np.empty(len(s)), np.zeros(len(s))
    products = zone.times(zone.pull(v))
    active = (v > 0.0) | (products < s)
    matrix = _Matrix(zone, deadline=deadline)
    fewest, since, last_off = np.inf, 0, np.inf
    for step in deadline.checked(range(1, MAX_STEPS + 1)):
        u = matrix.solve(active, s + RHO * v)
        z = zone.pull(u)
        products = zone.times(z)
        wrong = np.where(active, u < 0.0, products - RHO * v < s - slop)
        count = np.count_nonzero(wrong)
        if count:
            since = 0 if count < fewest else since + 1
            if count >= FALLS * fewest:
                by = np.where(active, -u, s - products) if since <= PATIENCE else None
                wrong = first_of_neighbours(zone, wrong, by)
            active = active ^ wrong
            fewest = min(count, fewest)
            continue
        violation, objective, gap, _ = residuals(z, z, products, s, no_slack, u, dual, primal)
        relative_gap = gap / objective if objective > 0.0 else np.inf
        off = max(relative_gap / gap_tolerance, violation * scale / violation_tolerance)
        if off < TOLERATED_SLOP or 0.5 * last_off < off < STALLED_SLOP:
            return z * scale, u * scale, step
        v, fewest, since, last_off = u, np.inf, 0, off
    return None


def polish(
    zone: LargeZone,
    z: Floats,
    multipliers: Multipliers,
    violation_tolerance: float,
    deadline: Deadline = UNLIMITED,
) -> tuple[Floats, Multipliers]:
    """Move a solution onto its active constraints, which takes its error down to rounding.

    The distance of a solution to the optimum is as large as the root of its relative gap, some
    1e-6. A constraint is active if its multiplier is larger than its slack. With the right active
    constraints, the distance is some rounding over their smallest singular value. Those whose
    multiplier becomes negative leave, and violated ones enter. It takes an eighth to a third of the
    time of the interior point. What `pivot_from` returns is as near without it.

    Args:
        zone: The zone.
        z: (3 n_vertices,) f8 [m kg^1/2], near the solution.
        multipliers: (m,) f8 [m kg^1/2], u >= 0.
        violation_tolerance: Largest s - C z, in the unit of rhs.
        deadline: When each factorisation has to end.

    Returns:
        z and the multipliers; those that came in if no better ones were found.
    """
    active, u = multipliers > zone.times(z) - zone.rhs, multipliers
    matrix, before = _Matrix(zone, POLISH_RHO, deadline), _gap(zone, z, u)
    for _ in range(POLISHES):
        moved, u = _move_onto(zone, matrix, active, np.where(active, np.maximum(u, 0.0), 0.0))
        missing = zone.rhs - zone.times(moved)
        wrong = np.where(active, u < 0.0, missing > 0.5 * violation_tolerance)
        if not wrong.any():
            is_better = missing.max() <= violation_tolerance and _gap(zone, moved, u) < before
            return (moved, u) if is_better else (z, multipliers)
        active = active ^ wrong
    return z, multipliers


def _move_onto(
    zone: LargeZone, matrix: _Matrix, active: Flags, u: Multipliers
) -> tuple[Floats, Multipliers]:
    """Bring the slack of active constraints to zero, from z = C^T u; return z and u.

    z gets the corrections themselves and is not computed from u again. Where constraints are nearly
    opposed, u is large, and C^T u has its rounding.
    """
    z, last = zone.pull(u), np.inf
    for _ in range(CORRECTIONS):
        missing = np.where(active, zone.rhs - zone.times(z), 0.0)
        off = np.abs(missing).max()
        if not off <= 0.5 * last:
            break
        step, last = matrix.solve(active, missing), off
        z, u = z + zone.pull(step), u + step
    return z, u


def _gap(zone: LargeZone, z: Floats, u: Multipliers) -> float:
    """Return the duality gap of z and multipliers u >= 0, in the unit of rhs squared."""
    products, dual, primal = zone.times(z), np.empty_like(z), np.empty_like(u)
    return residuals(z, zone.pull(u), products, zone.rhs, np.zeros_like(u), u, dual, primal)[2]


def first_of_neighbours(zone: LargeZone, wrong: Flags, by: Floats | None) -> Flags:
    """Return the constraints that come first among all that share a vertex with them.

    Args:
        zone: The zone.
        wrong: (m,) b1, the constraints that are compared.
        by: (m,) f8, the largest one comes first, of equal ones the one with the highest number;
            None to go by numbers alone.

    Returns:
        (m,) b1, at least one of the constraints; no two of them share a vertex.
    """
    rows = np.flatnonzero(wrong)
    ranks = np.arange(len(rows))
    if by is not None:
        ranks[np.argsort(by[rows], kind="stable")] = np.arange(len(rows))
    nodes = zone.nodes[rows]
    at_vertex = np.full(zone.n_vertices + 1, -1)  # the highest rank at each vertex
    np.maximum.at(at_vertex, nodes, ranks[:, None])
    at_vertex[-1] = -1  # pinned vertices, whose number is -1, connect nothing
    first = np.zeros(len(wrong), bool)
    first[rows[(at_vertex[nodes] <= ranks[:, None]).all(axis=1)]] = True
    return first


class _Matrix:
    """The matrices C_F C_F^T + rho for all sets F of constraints of a zone.

    They share the order of elimination, which is found once for all constraints.

    Args:
        zone: The zone.
        rho: What is added to the diagonal.
        deadline: When each solve has to end.
    """

    def __init__(self, zone: LargeZone, rho: float = RHO, deadline: Deadline = UNLIMITED) -> None:
        """Compute the matrix of all constraints, and analyse its pattern."""
        entries, self._values = gram_products(
            zone.nodes, zone.coefficients, zone.normals, zone.n_vertices
        )
        self._values[entries[:, 0] == entries[:, 1]] += rho
        self._factors = SparseCholesky(entries, len(zone.rhs), 1, deadline)
        self._factored: Flags | None = None

    def solve(self, active: Flags, right: Floats) -> Multipliers:
        """Return u, (m,) f8, for F = active, (m,) b1; u is 0 for inactive constraints."""
        if self._factored is None or (active != self._factored).any():
            self._factors.restrict(active)
            self._factors.factorize(self._values)
            self._factored = active
        u = np.zeros(len(right))
        u[active] = self._factors.solve(right[active])
        return u
