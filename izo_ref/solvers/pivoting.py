"""Block pivoting for one large zone that was solved before with fewer impacts.

In scaled variables (SPEC 5) the multipliers minimise 1/2 |C^T u|^2 - s . u over u >= 0. The last
solution says nearly which of them are positive, F, and then one factorisation gives them all:

    (C_F C_F^T + rho) u_F = s_F + rho v_F,    u = 0 elsewhere.

rho takes redundant rows, and v is where u came from: with v = u what rho adds is gone, so
v follows u once F is right (the proximal-point method, which converges for any rho). Rows of F
with u < 0 leave it and others with C z < s enter: all at once, or, where they do not get fewer,
the last of them alone until they do. That ends, but may take very long, so it is given up after
some factorisations, for the interior point to take over.

Source: L. F. Portugal, J. J. Judice, L. N. Vicente, A comparison of block pivoting and
interior-point algorithms for linear least squares problems with nonnegative variables (1994);
R. T. Rockafellar, Monotone operators and the proximal point algorithm (1976).
"""

import numpy as np

from izo_ref.solvers.serial.gram import gram_products
from izo_ref.solvers.serial.interior import residuals
from izo_ref.solvers.sparse import SparseCholesky

# Rows have unit length. Of those that hold in fifteen zones of cloth-ball-clean and
# armadillo-rollers, squares of singular values are below 1e-14 (redundant) or above 1e-3.
# In between is where rho belongs: u gains five digits each time v follows, and where redundant
# rows disagree one leaves at once.
# With 1e-6 some zones crept toward that for more than 30 solves.
RHO = 1e-8
# Of the tolerances: a digit more is one more solve.
TOLERATED_SLOP = 1e-2
# Of the zones of cloth-ball-clean that it ends at all, it ends 90 % in 14 steps.
MAX_STEPS = 24
# Times that the rows on the wrong side may fail to get fewer.
PATIENCE = 3
# Rows that nearly hold come into the pattern too, half as many as hold: else some enter later,
# and a new pattern takes as long as five factorisations.
NEARLY = 0.5


def pivot_from(zone, start, gap_tolerance, violation_tolerance):
    """Solve a zone, if the start is near enough.

    Args:
        zone: `LargeZone`.
        start: (m,) f8, multipliers of unit rows, >= 0; 0 for rows that do not hold.
        gap_tolerance: relative duality gap to reach.
        violation_tolerance: largest s - C z to reach, in the unit of rhs.

    Returns:
        z (n,), multipliers (m,), and solves; or None.
    """
    scale = zone.rhs.max()
    s, v = zone.rhs / scale, start / scale
    # rows this little below s are left: to rounding they could enter and leave for ever
    slop = TOLERATED_SLOP * violation_tolerance / scale
    dual, primal, no_slack = np.empty(3 * zone.n_vertices), np.empty(len(s)), np.zeros(len(s))
    rows = zone.times(zone.pull(v))
    inside = (v > 0.0) | (rows < s)
    pattern, fewest, waited = None, np.inf, 0
    for step in range(1, MAX_STEPS + 1):
        if pattern is None or not pattern.has(inside):
            pattern = _Pattern(zone, inside | _nearly(inside, rows - s))
        u = pattern.solve(inside, s + RHO * v)
        z = zone.pull(u)
        rows = zone.times(z)
        wrong = np.where(inside, u < 0.0, rows - RHO * v < s - slop)
        count = np.count_nonzero(wrong)
        if count:
            waited = 0 if count < fewest else waited + 1
            fewest = min(count, fewest)
            if waited >= PATIENCE:
                wrong[: np.flatnonzero(wrong)[-1]] = False
            inside = inside ^ wrong
            continue
        violation, objective, gap, _ = residuals(z, z, rows, s, no_slack, u, dual, primal)
        off = max(gap / objective / gap_tolerance, violation * scale / violation_tolerance)
        if off < TOLERATED_SLOP:
            return z * scale, u * scale, step
        v, fewest, waited = u, np.inf, 0
    return None


def _nearly(inside, slack):
    """(m,) b1, of the rows outside those with least slack."""
    outside = np.flatnonzero(~inside)
    order = np.argsort(slack[outside], kind="stable")
    chosen = np.zeros(len(inside), bool)
    chosen[outside[order[: int(NEARLY * np.count_nonzero(inside))]]] = True
    return chosen


class _Pattern:
    """C_F C_F^T + rho for all subsets F of some rows, (m,) b1."""

    def __init__(self, zone, rows):
        self._has, self._rows = rows, np.flatnonzero(rows)
        entries, self._values = gram_products(
            zone.nodes[rows], zone.coefficients[rows], zone.normals[rows], zone.n_vertices
        )
        self._first, self._second = entries.T
        self._is_diagonal = self._first == self._second
        self._values[self._is_diagonal] += RHO
        self._factors = SparseCholesky(entries, len(self._rows), 1)
        self._factored = None

    def has(self, inside):
        return self._has[inside].all()

    def solve(self, inside, right):
        """(m,) f8, u; 0 for rows that are not inside."""
        chosen = inside[self._rows]
        if self._factored is None or (chosen != self._factored).any():
            kept = chosen[self._first] & chosen[self._second]
            # the identity for the others
            self._factors.factorize(np.where(kept, self._values, self._is_diagonal))
            self._factored = chosen
        u = np.zeros(len(right))
        u[self._rows] = self._factors.solve(np.where(chosen, right[self._rows], 0.0))
        return u
