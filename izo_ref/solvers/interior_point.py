"""Primal-dual interior-point method for one large zone.

In scaled variables (docs/method section 5): minimise 1/2 |z|^2 subject to C z - w = s, w >= 0, with
multipliers l >= 0 and z = C^T l. Each iteration takes a predictor and a corrector step with one
sparse factorisation. It factors the smaller of two matrices:

    of the multipliers   (C C^T + diag(w / l)) dl = ...     as many unknowns as impacts
    of the positions     (I + C^T diag(l / w) C) dz = ...   three unknowns for each vertex

Zones whose impacts were selected have fewer impacts than unknowns, and the first matrix fills up
little. With all impacts in the zones it is the other way round. Redundant constraints, which make
C C^T singular and stop active-set methods, do no harm here.

Source: S. Mehrotra, On the implementation of a primal-dual interior point method (1992);
Nocedal & Wright 2006, algorithm 16.4.
"""

from typing import Protocol

import numpy as np

from izo_ref.base.arrays import Floats, Multipliers
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.solvers.cpu.sparse import weighted_gram
from izo_ref.solvers.scaled_constraints import LargeZone
from izo_ref.solvers.serial.gram import gram_products
from izo_ref.solvers.serial.interior import dot, residuals, to_boundary
from izo_ref.solvers.serial.settings import LEAST_TOLERANCE
from izo_ref.solvers.sparse import SparseCholesky

# Least fraction of the way to the boundary that a step takes. It takes 1 - relative gap if that is
# more, so that the last steps gain more each. That saves one iteration of 18 on a zone of 24,000
# impacts.
TO_BOUNDARY = 0.995
MAX_ITERATIONS = 100
# Fraction of the tolerances to reach. The last iteration gains two or three digits, and the root of
# the gap bounds the distance to the optimum.
CONVERGED_ERROR = 1e-2
# The start is moved inside to this fraction of the mean slack and of the mean multiplier of some
# sweeps. The sweeps save four of 22 iterations on a zone of 24,000 impacts.
INSIDE = 0.5
# A zone counts as infeasible if every feasible z has |z| above this. The unit is how far the most
# violated constraint alone would move z, because the largest entry of s is scaled to 1. Multipliers
# l prove |z| >= l . s / |C^T l| for every feasible z. A solution that is so far off is useless.
FARTHEST = 1e4


class _NewtonEquations(Protocol):
    """Newton's equations of a zone, reduced to some of their unknowns.

    `primal` is C z - w - s and `dual` is z - C^T l; both are zero at the solution.
    """

    zone: LargeZone

    def start(self, multipliers: Multipliers) -> Floats:
        """Return z, (n,) f8, at the start."""
        ...

    def factorize(self, slack: Floats, multipliers: Multipliers) -> None:
        """Factor the matrix at slacks w and multipliers l, (m,) f8."""
        ...

    def direction(
        self,
        products: Floats,
        slack: Floats,
        multipliers: Multipliers,
        primal: Floats,
        dual: Floats,
    ) -> tuple[Floats, Floats, Floats]:
        """Return the step of z, w and l.

        Args:
            products: (m,) f8, what the step has to subtract from the products w l.
            slack: (m,) f8, w.
            multipliers: (m,) f8, l.
            primal: (m,) f8.
            dual: (n,) f8.
        """
        ...


class _MultiplierEquations:
    """Newton's equations reduced to the multipliers; see `_NewtonEquations`."""

    def __init__(self, zone: LargeZone, deadline: Deadline) -> None:
        """Compute C C^T and its pattern."""
        self.zone = zone
        rows = zone.nodes, zone.coefficients, zone.normals
        entries, self.values = gram_products(*rows, zone.n_vertices)
        self.diagonal = np.flatnonzero(entries[:, 0] == entries[:, 1])
        self.factors = SparseCholesky(entries, len(zone.rhs), 1, deadline)

    def start(self, multipliers: Multipliers) -> Floats:
        """Return C^T l: each step then keeps z = C^T l to rounding, whatever was factored."""
        return self.zone.pull(multipliers)

    def factorize(self, slack: Floats, multipliers: Multipliers) -> None:
        """Factor C C^T + diag(w / l)."""
        values = self.values.copy()
        values[self.diagonal] += slack / multipliers
        self.factors.factorize(values)

    def direction(
        self,
        products: Floats,
        slack: Floats,
        multipliers: Multipliers,
        primal: Floats,
        dual: Floats,
    ) -> tuple[Floats, Floats, Floats]:
        """Return the step of z, w and l."""
        du = self.factors.solve(self.zone.times(dual) - primal - products / multipliers)
        dz = self.zone.pull(du) - dual
        return dz, -(products + slack * du) / multipliers, du


class _PositionEquations:
    """Newton's equations reduced to z, three unknowns a vertex; see `_NewtonEquations`."""

    def __init__(self, zone: LargeZone, deadline: Deadline) -> None:
        """Find which blocks of I + C^T diag(l / w) C are not zero, and where each impact adds."""
        self.zone, n = zone, zone.n_vertices
        first, second = np.triu_indices(4, 1)
        low = np.minimum(zone.nodes[:, first], zone.nodes[:, second])
        high = np.maximum(zone.nodes[:, first], zone.nodes[:, second])
        found, slots = np.unique(low.astype(np.int64) * n + high, return_inverse=True)
        pinned = np.searchsorted(found, 0)  # pairs with a pinned vertex, whose low is -1
        pairs = np.column_stack(np.divmod(found[pinned:], n))
        self.diagonal = len(pairs) + np.arange(n)
        self.entries = np.concatenate((pairs, np.column_stack((np.arange(n), np.arange(n)))))
        self.slots = np.full((len(zone.nodes), 4, 4), -1, np.int32)
        self.slots[:, first, second] = np.maximum(slots - pinned, -1).reshape(low.shape)
        itself = np.where(zone.nodes >= 0, len(pairs) + zone.nodes, -1)
        self.slots[:, np.arange(4), np.arange(4)] = itself
        self.factors = SparseCholesky(self.entries, n, 3, deadline)

    def start(self, multipliers: Multipliers) -> Floats:
        """Return zeros."""
        return np.zeros(3 * self.zone.n_vertices)

    def factorize(self, slack: Floats, multipliers: Multipliers) -> None:
        """Factor I + C^T diag(l / w) C."""
        values = np.zeros((len(self.entries), 3, 3))
        values[self.diagonal] = np.eye(3)
        weights = multipliers / slack
        weighted_gram(self.slots, self.zone.coefficients, self.zone.normals, weights, values)
        self.factors.factorize(values)

    def direction(
        self,
        products: Floats,
        slack: Floats,
        multipliers: Multipliers,
        primal: Floats,
        dual: Floats,
    ) -> tuple[Floats, Floats, Floats]:
        """Return the step of z, w and l."""
        pushes = (products + multipliers * primal) / slack
        dz = self.factors.solve(-dual - self.zone.pull(pushes))
        dw = self.zone.times(dz) + primal
        return dz, dw, -(products + multipliers * dw) / slack


def interior_point(
    zone: LargeZone,
    start: tuple[Floats, Multipliers],
    gap_tolerance: float,
    violation_tolerance: float,
    farthest: float = FARTHEST,
    deadline: Deadline = UNLIMITED,
) -> tuple[Floats, Multipliers, int, bool]:
    """Solve one zone.

    Args:
        zone: The zone.
        start: z, (n,) f8, and multipliers, (m,) f8, after some sweeps; n is 3 n_vertices.
        gap_tolerance: Relative duality gap to reach. The method goes below it if rounding allows.
        violation_tolerance: Largest s - C z to reach, in the unit of rhs.
        farthest: Largest |z| of a solution, over the largest rhs.
        deadline: When the iterations have to end.

    Returns:
        z, (n,) f8, the multipliers, (m,) f8, the number of iterations, and whether the constraints
        are satisfied to tolerance. If they are not, there are two possible reasons. Either the
        multipliers prove that |z| is above `farthest` for every z that satisfies the constraints,
        if there is any. Or the iterations ended before the tolerance was reached.
    """
    rhs = zone.rhs
    gap_tolerance = max(gap_tolerance, LEAST_TOLERANCE)
    violation_tolerance = max(violation_tolerance, LEAST_TOLERANCE)
    scale = rhs.max()
    s = rhs / scale
    if _is_solved(zone, start, scale, gap_tolerance, violation_tolerance):
        return *start, 0, True
    newton = _choose_equations(zone, deadline)
    z, slack, multipliers = _move_inside(s, newton, start[0] / scale, start[1] / scale)
    best, iteration = (np.inf, z, multipliers, 0), 0
    for iteration in deadline.checked(range(MAX_ITERATIONS)):
        dual, primal = np.empty_like(z), np.empty_like(s)
        violation, objective, gap, norm = residuals(
            z, zone.pull(multipliers), zone.times(z), s, slack, multipliers, dual, primal
        )
        # both tolerances as one number
        relative_gap = gap / objective if objective > 0.0 else np.inf
        error = max(relative_gap / gap_tolerance, violation * scale / violation_tolerance)
        if error < best[0]:
            best = (error, z, multipliers, iteration)
        if error < CONVERGED_ERROR or iteration > best[3] + 5:
            break
        if min(slack.min(), multipliers.min()) <= 0.0:  # a step to the boundary was rounded onto it
            break
        if norm > farthest:
            return z * scale, multipliers * scale, iteration, False
        newton.factorize(slack, multipliers)
        dz, dw, du = _direction(newton, slack, multipliers, primal, dual)
        fraction = max(TO_BOUNDARY, 1.0 - relative_gap)
        length = min(fraction * to_boundary(slack, multipliers, dw, du), 1.0)
        z = z + length * dz
        slack = slack + length * dw
        multipliers = multipliers + length * du
    violation = float(np.max(rhs - zone.times(best[1] * scale)))
    return best[1] * scale, best[2] * scale, iteration, violation <= violation_tolerance


def _is_solved(
    zone: LargeZone,
    start: tuple[Floats, Multipliers],
    scale: float,
    gap_tolerance: float,
    violation_tolerance: float,
) -> bool:
    """Return whether a start is the solution already, to the accuracy that the iterations reach.

    If sweeps solved a zone to rounding, all slacks of active constraints are rounding, and so is
    their mean. `_move_inside` then leaves them there, and the iterations cannot begin. Zones of one
    impact many times over are such zones.
    """
    z, multipliers = start
    s, dual, primal = zone.rhs / scale, np.empty_like(z), np.empty_like(zone.rhs)
    violation, objective, gap, _ = residuals(
        z / scale,
        zone.pull(multipliers) / scale,
        zone.times(z) / scale,
        s,
        np.zeros_like(s),
        multipliers / scale,
        dual,
        primal,
    )
    off = max(gap / gap_tolerance, objective * violation * scale / violation_tolerance)
    return objective > 0.0 and off < CONVERGED_ERROR * objective


def _choose_equations(zone: LargeZone, deadline: Deadline) -> _NewtonEquations:
    """Return the equations with fewer unknowns."""
    if len(zone.rhs) < 3 * zone.n_vertices:
        return _MultiplierEquations(zone, deadline)
    return _PositionEquations(zone, deadline)


def _move_inside(
    s: Floats, newton: _NewtonEquations, z: Floats, multipliers: Multipliers
) -> tuple[Floats, Floats, Multipliers]:
    """Return z, slacks and multipliers of a start; slacks and multipliers become positive."""
    slack = newton.zone.times(z) - s
    slack = np.maximum(slack, INSIDE * np.mean(np.abs(slack)))
    multipliers = np.maximum(multipliers, INSIDE * np.mean(multipliers[multipliers > 0.0]))
    return newton.start(multipliers), slack, multipliers


def _direction(
    newton: _NewtonEquations,
    slack: Floats,
    multipliers: Multipliers,
    primal: Floats,
    dual: Floats,
) -> tuple[Floats, Floats, Floats]:
    """Return the step of z, w and l: a predictor with its corrector.

    Gondzio's further corrections were tried. They save two iterations of 22, but no time.
    """
    products = slack * multipliers
    mean = dot(slack, multipliers) / len(slack)
    _, dw, du = newton.direction(products, slack, multipliers, primal, dual)
    length = min(to_boundary(slack, multipliers, dw, du), 1.0)
    predicted = dot(slack + length * dw, multipliers + length * du) / len(slack)
    products = products + dw * du - mean * (predicted / mean) ** 3
    return newton.direction(products, slack, multipliers, primal, dual)
