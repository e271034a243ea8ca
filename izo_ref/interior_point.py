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

from izo_ref.cpu.sparse import weighted_gram
from izo_ref.sparse import SparseCholesky

# Fraction of the way to the boundary that is taken.
TO_BOUNDARY = 0.995
MAX_ITERATIONS = 100
# Of the tolerances: the last iteration gains two digits or three, and bounds the distance by
# their root.
ENOUGH = 1e-2
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
        from scipy.sparse import triu

        self.c, self.ct = zone.matrix, zone.matrix.T.tocsr()
        gram = triu(self.c @ self.ct).tocoo()
        self.values = gram.data
        self.diagonal = np.flatnonzero(gram.row == gram.col)
        self.row_of = gram.row[self.diagonal]
        self.factors = SparseCholesky(np.column_stack((gram.row, gram.col)), len(zone.rhs), 1)

    def start(self, multipliers):
        # z = C^T l at the start is z = C^T l to rounding at the end, whatever was factored
        return self.ct @ multipliers

    def factorize(self, slack, multipliers):
        values = self.values.copy()
        values[self.diagonal] += (slack / multipliers)[self.row_of]
        self.factors.factorize(values)

    def direction(self, products, slack, multipliers, primal, dual):
        du = self.factors.solve(self.c @ dual - primal - products / multipliers)
        dz = self.ct @ du - dual
        return dz, -(products + slack * du) / multipliers, du


class _Columns:
    """Newton's equations reduced to the unknowns, in blocks of three for each vertex."""

    def __init__(self, zone):
        self.zone, self.c, self.ct = zone, zone.matrix, zone.matrix.T.tocsr()
        n = zone.n_vertices
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
        return np.zeros(self.c.shape[1])

    def factorize(self, slack, multipliers):
        values = np.zeros((len(self.entries), 3, 3))
        values[self.diagonal] = np.eye(3)
        weights = multipliers / slack
        weighted_gram(self.slots, self.zone.coefficients, self.zone.normals, weights, values)
        self.factors.factorize(values)

    def direction(self, products, slack, multipliers, primal, dual):
        dz = self.factors.solve(-dual - self.ct @ ((products + multipliers * primal) / slack))
        dw = self.c @ dz + primal
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
    c, ct = newton.c, newton.ct
    z, slack, multipliers = _inside(s, newton, start[0] / scale, start[1] / scale)
    best = (np.inf, z, multipliers, 0)
    for iteration in range(MAX_ITERATIONS):
        cz, pull = c @ z, ct @ multipliers
        dual = z - pull
        primal = cz - slack - s
        violation = float(np.max(s - cz))
        objective = 0.5 * _dot(z, z)
        gap = 0.5 * _dot(dual, dual) + _dot(multipliers, np.abs(cz - s))
        # both tolerances as one number
        relative_gap = gap / objective if objective > 0.0 else np.inf
        error = max(relative_gap / gap_tolerance, violation * scale / violation_tolerance)
        if error < best[0]:
            best = (error, z, multipliers, iteration)
        if error < ENOUGH or iteration > best[3] + 5:
            break
        if _dot(multipliers, s) > FARTHEST * _dot(pull, pull) ** 0.5:
            return z * scale, multipliers * scale, iteration, False
        newton.factorize(slack, multipliers)
        dz, dw, du = _direction(newton, slack, multipliers, primal, dual)
        length = min(TO_BOUNDARY * _length(slack, multipliers, dw, du), 1.0)
        z = z + length * dz
        slack = slack + length * dw
        multipliers = multipliers + length * du
    violation = float(np.max(rhs - c @ (best[1] * scale)))
    return best[1] * scale, best[2] * scale, iteration, violation <= violation_tolerance


def _inside(s, newton, z, multipliers):
    """z, slacks and multipliers of a start, moved inside."""
    slack = newton.c @ z - s
    slack = np.maximum(slack, INSIDE * np.mean(np.abs(slack)))
    multipliers = np.maximum(multipliers, INSIDE * np.mean(multipliers[multipliers > 0.0]))
    return newton.start(multipliers), slack, multipliers


def _direction(newton, slack, multipliers, primal, dual):
    """A predictor and a corrector step.

    Gondzio's further corrections were tried: two iterations fewer of 22, and as much time.
    """
    products = slack * multipliers
    mean = _dot(slack, multipliers) / len(slack)
    _, dw, du = newton.direction(products, slack, multipliers, primal, dual)
    length = min(_length(slack, multipliers, dw, du), 1.0)
    predicted = _dot(slack + length * dw, multipliers + length * du) / len(slack)
    products = products + dw * du - mean * (predicted / mean) ** 3
    return newton.direction(products, slack, multipliers, primal, dual)


def _dot(a, b):
    """Not BLAS's, whose threads wait in a loop: on a busy machine the solve takes four times
    as long for these alone, and their number is in the last bits."""
    return float(np.einsum("i,i", a, b))


def _length(slack, multipliers, dw, du):
    """Largest multiple of a step that keeps both positive."""
    return min(_to_boundary(slack, dw), _to_boundary(multipliers, du))


def _to_boundary(values, step):
    shrinking = step < 0.0
    return float(np.min(-values[shrinking] / step[shrinking], initial=np.inf))
