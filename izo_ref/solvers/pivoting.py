"""Block pivoting for one large zone that was solved before with fewer impacts.

In scaled variables (docs/method section 5) the multipliers minimise 1/2 |C^T u|^2 - s . u over
u >= 0. Let F be the set of active constraints, those with a positive multiplier. The last solution
nearly says what F is. Given F, one factorisation gives all multipliers:

    (C_F C_F^T + rho) u_F = s_F + rho v_F,    u = 0 elsewhere.

rho makes the matrix regular if constraints are redundant. v is an earlier u: the start, and later
the u of the last solve whose F was right. If v = u, then the terms with rho cancel, so v follows u
once F is right. This is the proximal-point method, which converges for any rho.

After each solve, constraints of F with u < 0 leave F, and other constraints with C z < s enter it.
All of them change sides at once. Where few constraints depend on each other, this can repeat for
ever. So if the number of constraints on the wrong side sets no new minimum, they are taken in
groups that share vertices, and only the last constraint of each group changes sides. With one group
this method ends, but it may take very long. It is given up after MAX_STEPS solves, and the interior
point takes over.

One constraint of the whole zone at a time was tried. The repetitions are local, and a zone of 4,000
impacts has several at the same time: on cloth-ball-clean, pivoting then gave up on 37 of 191 zones,
where it gives up on 2 with groups.

Source: L. F. Portugal, J. J. Judice, L. N. Vicente, A comparison of block pivoting and
interior-point algorithms for linear least squares problems with nonnegative variables (1994);
R. T. Rockafellar, Monotone operators and the proximal point algorithm (1976).
"""

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Multipliers
from izo_ref.base.serial.components import impact_components
from izo_ref.solvers.scaled_constraints import LargeZone
from izo_ref.solvers.serial.gram import gram_products
from izo_ref.solvers.serial.interior import residuals
from izo_ref.solvers.sparse import SparseCholesky

# Rows of C have unit length. In fifteen zones of cloth-ball-clean and armadillo-rollers, the
# squared singular values of the active rows are below 1e-14 (redundant) or above 1e-3, and rho
# belongs in between. With this rho, the multipliers u gain five digits each time v, the earlier u,
# is set to them. If redundant constraints disagree, one of them gets u < 0 and leaves F in the next
# step. With 1e-6 some zones took more than 30 solves until such a constraint left.
RHO = 1e-8
# Fraction of the tolerances to reach: a digit more takes one more solve.
TOLERATED_SLOP = 1e-2
# Rounding can keep the residuals above TOLERATED_SLOP. Below this fraction of the tolerances, a
# zone counts as solved if the last solve did not at least halve them.
STALLED_SLOP = 0.5
# On cloth-ball-clean, half of the zones that this method solves take at most 8 steps, 90 % take at
# most 19, and all take at most 33.
MAX_STEPS = 40
# The pattern also takes in constraints outside F that nearly hold with equality; their number is at
# most this fraction of the number in F. Otherwise some of them enter F later, and a new pattern
# takes as long as five factorisations.
NEARLY = 0.5


def pivot_from(
    zone: LargeZone, start: Multipliers, gap_tolerance: float, violation_tolerance: float
) -> tuple[Floats, Multipliers, int] | None:
    """Solve a zone if the start is near enough to the solution.

    Args:
        zone: The zone.
        start: (m,) f8 [m kg^1/2], multipliers of the constraints of unit length, >= 0; 0 for
            inactive impacts.
        gap_tolerance: Largest relative duality gap.
        violation_tolerance: Largest s - C z, in the unit of rhs.

    Returns:
        z, (3 n_vertices,) f8, the multipliers, (m,) f8, and the number of solves; None if the
        method gave up.
    """
    scale = zone.rhs.max()
    s, v = zone.rhs / scale, start / scale
    # Constraints that are violated by no more than this do not enter: rounding could make them
    # enter and leave for ever.
    slop = TOLERATED_SLOP * violation_tolerance / scale
    dual, primal, no_slack = np.empty(3 * zone.n_vertices), np.empty(len(s)), np.zeros(len(s))
    products = zone.times(zone.pull(v))
    active = (v > 0.0) | (products < s)
    pattern, fewest, last_off = None, np.inf, np.inf
    for step in range(1, MAX_STEPS + 1):
        if pattern is None or not pattern.covers(active):
            pattern = _Pattern(zone, active | _nearly_active(active, products - s))
        u = pattern.solve(active, s + RHO * v)
        z = zone.pull(u)
        products = zone.times(z)
        wrong = np.where(active, u < 0.0, products - RHO * v < s - slop)
        count = np.count_nonzero(wrong)
        if count:
            active = active ^ (wrong if count < fewest else last_of_groups(zone, wrong))
            fewest = min(count, fewest)
            continue
        violation, objective, gap, _ = residuals(z, z, products, s, no_slack, u, dual, primal)
        off = max(gap / objective / gap_tolerance, violation * scale / violation_tolerance)
        if off < TOLERATED_SLOP or 0.5 * last_off < off < STALLED_SLOP:
            return z * scale, u * scale, step
        v, fewest, last_off = u, np.inf, off
    return None


def last_of_groups(zone: LargeZone, wrong: Flags) -> Flags:
    """Return the last constraint of each group of constraints that are connected by vertices.

    Args:
        zone: The zone.
        wrong: (m,) b1, the constraints that are grouped; the others connect nothing.

    Returns:
        (m,) b1, the last constraint of each group.
    """
    rows = np.flatnonzero(wrong)
    n = zone.n_vertices
    nodes = np.where(zone.nodes[rows] < 0, n, zone.nodes[rows]).astype(np.int32)
    pinned, group = np.zeros(n + 1, bool), np.empty(len(rows), np.int64)
    pinned[n] = True  # stands for all pinned vertices, which connect nothing
    impact_components(nodes, pinned, np.empty(n + 1, np.int64), group)
    _, first_from_behind = np.unique(group[::-1], return_index=True)
    last = np.zeros(len(wrong), bool)
    last[rows[::-1][first_from_behind]] = True
    return last


def _nearly_active(active: Flags, slack: Floats) -> Flags:
    """Return (m,) b1: the inactive constraints with the least slack."""
    inactive = np.flatnonzero(~active)
    order = np.argsort(slack[inactive], kind="stable")
    chosen = np.zeros(len(active), bool)
    chosen[inactive[order[: int(NEARLY * np.count_nonzero(active))]]] = True
    return chosen


class _Pattern:
    """The matrices C_F C_F^T + rho for all sets F among some constraints of a zone.

    They share one sparsity pattern, so that the order of elimination is found once.

    Args:
        zone: The zone.
        members: (m,) b1, the constraints that F may contain.
    """

    def __init__(self, zone: LargeZone, members: Flags) -> None:
        """Compute the pattern and the values of the matrix of all members."""
        self._is_member, self._members = members, np.flatnonzero(members)
        entries, self._values = gram_products(
            zone.nodes[members], zone.coefficients[members], zone.normals[members], zone.n_vertices
        )
        self._first, self._second = entries.T
        self._is_diagonal = self._first == self._second
        self._values[self._is_diagonal] += RHO
        self._factors = SparseCholesky(entries, len(self._members), 1)
        self._factored: Flags | None = None

    def covers(self, active: Flags) -> bool:
        """Return whether every active constraint, (m,) b1, is a member."""
        return bool(self._is_member[active].all())

    def solve(self, active: Flags, right: Floats) -> Multipliers:
        """Return u, (m,) f8, for F = active, (m,) b1; u is 0 for inactive constraints."""
        chosen = active[self._members]
        if self._factored is None or (chosen != self._factored).any():
            both = chosen[self._first] & chosen[self._second]
            # the rows and columns of inactive members become those of the identity
            self._factors.factorize(np.where(both, self._values, self._is_diagonal))
            self._factored = chosen
        u = np.zeros(len(right))
        u[self._members] = self._factors.solve(np.where(chosen, right[self._members], 0.0))
        return u
