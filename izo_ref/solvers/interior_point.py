"""Primal-dual interior-point method for one large zone.

In scaled variables (SPEC 5): minimise 1/2 |z|^2 subject to C z - w = s, w >= 0, with
multipliers l >= 0 and z = C^T l. Each iteration takes a predictor and a corrector step
from one sparse factorisation, of whichever is smaller:

    rows      (C C^T + diag(w / l)) dl = ...     as many unknowns as impacts
    columns   (I + C^T diag(l / w) C) dz = ...   three for each vertex

Zones whose impacts were selected have fewer impacts than unknowns, and the first form
has little fill; with all impacts it is the other way round. Redundant rows, which make
C C^T singular and stop active-set methods, do not matter here.

Source: S. Mehrotra, On the implementation of a primal-dual interior point method (1992);
Nocedal & Wright 2006, algorithm 16.4.
"""

import numpy as np

from izo_ref.solvers.cpu.sparse import weighted_gram
from izo_ref.solvers.serial.gram import gram_products
from izo_ref.solvers.serial.interior import dot, residuals, to_boundary
from izo_ref.solvers.sparse import SparseCholesky

# Fraction of the way to the boundary that is taken, at least. All but the relative gap is, if
# that is more, so that the last steps gain more each: one iteration of 18 on a zone of 24,000.
TO_BOUNDARY = 0.995
MAX_ITERATIONS = 100
# Of the tolerances: the last iteration gains two digits or three, and bounds the distance by
# their root.
CONVERGED_ERROR = 1e-2
# How far inside it begins, of the mean slack and multiplier of some sweeps, which save four of
# 22 iterations on a zone of 24,000 impacts.
INSIDE = 0.5
# The largest entry of s is 1: what the most violated row alone would move. Multipliers l
# prove that every feasible z has |z| >= l . s / |C^T l|; beyond this the zone counts as
# infeasible, for a solution that far off is of no use to anybody.
FARTHEST = 1e4


class _Rows:
    """Newton's equations reduced to the multipliers."""

    def __init__(self, zone):
        self.zone = zone
        rows = zone.nodes, zone.coefficients, zone.normals
        entries, self.values = gram_products(*rows, zone.n_vertices)
        self.diagonal = np.flatnonzero(entries[:, 0] == entries[:, 1])
        self.factors = SparseCholesky(entries, len(zone.rhs), 1)

    def start(self, multipliers):
        # z = C^T l at the start is z = C^T l to rounding at the end, whatever was factored
        return self.zone.pull(multipliers)

    def factorize(self, slack, multipliers):
        values = self.values.copy()
        values[self.diagonal] += slack / multipliers
        self.factors.factorize(values)

    def direction(self, products, slack, multipliers, primal, dual):
        du = self.factors.solve(self.zone.times(dual) - primal - products / multipliers)
        dz = self.zone.pull(du) - dual
        return dz, -(products + slack * du) / multipliers, du


class _Columns:
    """Newton's equations reduced to the unknowns, in blocks of three for each vertex."""

    def __init__(self, zone):
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
        self.factors = SparseCholesky(self.entries, n, 3)

    def start(self, multipliers):
        return np.zeros(3 * self.zone.n_vertices)

    def factorize(self, slack, multipliers):
        values = np.zeros((len(self.entries), 3, 3))
        values[self.diagonal] = np.eye(3)
        weights = multipliers / slack
        weighted_gram(self.slots, self.zone.coefficients, self.zone.normals, weights, values)
        self.factors.factorize(values)

    def direction(self, products, slack, multipliers, primal, dual):
        pushes = (products + multipliers * primal) / slack
        dz = self.factors.solve(-dual - self.zone.pull(pushes))
        dw = self.zone.times(dz) + primal
        return dz, dw, -(products + multipliers * dw) / slack


def interior_point(zone, start, gap_tolerance, violation_tolerance):
    """Solve one zone.

    Args:
        zone: `LargeZone`.
        start: z (n,) and multipliers (m,) of some sweeps.
        gap_tolerance: relative duality gap to reach; it is undercut as far as rounding
            lets it.
        violation_tolerance: largest s - C z to reach, in the unit of rhs.

    Returns:
        z (n,), multipliers (m,), iterations, and False if the rows were not satisfied:
        nothing does, or nothing near.
    """
    rhs = zone.rhs
    scale = rhs.max()
    s = rhs / scale
    newton = (_Rows if len(rhs) < 3 * zone.n_vertices else _Columns)(zone)
    z, slack, multipliers = _inside(s, newton, start[0] / scale, start[1] / scale)
    best = (np.inf, z, multipliers, 0)
    for iteration in range(MAX_ITERATIONS):
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
        if norm > FARTHEST:
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


def _inside(s, newton, z, multipliers):
    """z, slacks and multipliers of a start, moved inside."""
    slack = newton.zone.times(z) - s
    slack = np.maximum(slack, INSIDE * np.mean(np.abs(slack)))
    multipliers = np.maximum(multipliers, INSIDE * np.mean(multipliers[multipliers > 0.0]))
    return newton.start(multipliers), slack, multipliers


def _direction(newton, slack, multipliers, primal, dual):
    """A predictor and a corrector step.

    Gondzio's further corrections were tried: two iterations fewer of 22, and as much time.
    """
    products = slack * multipliers
    mean = dot(slack, multipliers) / len(slack)
    _, dw, du = newton.direction(products, slack, multipliers, primal, dual)
    length = min(to_boundary(slack, multipliers, dw, du), 1.0)
    predicted = dot(slack + length * dw, multipliers + length * du) / len(slack)
    products = products + dw * du - mean * (predicted / mean) ** 3
    return newton.direction(products, slack, multipliers, primal, dual)
