"""Primal-dual interior-point method for one large zone.

In scaled variables (SPEC 5): minimise 1/2 |z|^2 subject to C z - w = s, w >= 0, with
multipliers l >= 0 and z = C^T l. Each iteration takes a predictor and corrector steps from
one sparse factorisation, of whichever is smaller:

    rows      (C C^T + diag(w / l)) dl = ...     as many unknowns as impacts
    columns   (I + C^T diag(l / w) C) dz = ...   three for each vertex

Zones whose impacts were selected have fewer impacts than unknowns, and the first form
has little fill; with all impacts it is the other way round. Redundant rows, which make
C C^T singular and stop active-set methods, do not matter here.

Source: S. Mehrotra, On the implementation of a primal-dual interior point method (1992);
Nocedal & Wright 2006, algorithm 16.4; J. Gondzio, Multiple centrality corrections in a
primal-dual method for linear programming (1996).
"""

import numpy as np

from izo_ref.cpu.sparse import weighted_gram
from izo_ref.serial.sweeps import sweeps
from izo_ref.sparse import SparseCholesky

# Fraction of the way to the boundary that is taken.
TO_BOUNDARY = 0.995
MAX_ITERATIONS = 100
# Of the tolerances: the last iteration gains two digits or three, and bounds the distance by
# their root.
ENOUGH = 1e-2
# Accelerated sweeps before it begins, and how far inside, of the mean: on zones of 24,000
# impacts 30 sweeps cost as much as one iteration and save five of twenty.
SWEEPS = 30
INSIDE = 0.3
# Gondzio's correction: of steps up to LONG, for one that is LONGER, of products that are off
# the mean by more than a factor of SPREAD. It costs a solve, an eighth of a factorisation.
LONG, LONGER, SPREAD = 0.95, 0.3, 10.0
NO_TRACE = np.empty((0, 2))
# The largest entry of s is 1: what the most violated row alone would move. Multipliers l
# prove that every feasible z has |z| >= l . s / |C^T l|; beyond this the zone counts as
# infeasible, for a solution that far off is of no use to anybody.
FARTHEST = 1e4


def scaled_matrix(nodes, coefficients, normals, n_unknowns):
    """C as a sparse matrix; nodes < 0 are pinned and have coefficient 0."""
    from scipy.sparse import csr_array

    columns = 3 * np.maximum(nodes, 0)[:, :, None] + np.arange(3)
    values = coefficients[:, :, None] * normals[:, None, :]
    starts = np.arange(0, 12 * len(nodes) + 1, 12)
    shape = (len(nodes), 3 * n_unknowns)
    return csr_array((values.ravel(), columns.ravel(), starts), shape=shape)


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
        first, second = zone.nodes[:, :, None], zone.nodes[:, None, :]
        low, high = np.minimum(first, second), np.maximum(first, second)
        keys = np.where(low >= 0, low.astype(np.int64) * n + high, -1)
        itself = np.arange(n, dtype=np.int64) * (n + 1)
        found, slots = np.unique(np.append(keys.ravel(), itself), return_inverse=True)
        pinned = int(found[0] < 0)
        self.slots = slots[: keys.size].reshape(keys.shape).astype(np.int32) - pinned
        self.diagonal = slots[keys.size :] - pinned
        self.entries = np.column_stack(np.divmod(found[pinned:], n))
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


class Zone:
    """The rows of one zone: as they are, and as a matrix.

    Args:
        nodes: (m, 4) i4, into the zone's vertices; -1 for pinned ones.
        coefficients: (m, 4) f8; with the normals, unit rows.
        normals: (m, 3) f8.
        rhs: (m,) f8, s; at least one entry is positive.
        n_vertices: that are not pinned.
    """

    def __init__(self, nodes, coefficients, normals, rhs, n_vertices):
        self.nodes, self.coefficients, self.normals, self.rhs = nodes, coefficients, normals, rhs
        self.n_vertices = n_vertices
        self.matrix = scaled_matrix(nodes, coefficients, normals, n_vertices)


def interior_point(zone, gap_tolerance, violation_tolerance):
    """Solve one zone.

    Args:
        zone: `Zone`.
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
    z, slack, multipliers = _start(zone, s, newton)
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


def _start(zone, s, newton):
    """z, slacks and multipliers of some sweeps, moved inside."""
    multipliers, z = np.zeros(len(s)), np.zeros((zone.n_vertices, 3))
    rows = zone.nodes, zone.coefficients, zone.normals, s, np.ones(len(s))
    sweeps(0, len(s), 0, zone.n_vertices, *rows, True, SWEEPS, 0.0, 0.0, multipliers, z, NO_TRACE)
    slack = newton.c @ z.ravel() - s
    slack = np.maximum(slack, INSIDE * np.mean(np.abs(slack)))
    multipliers = np.maximum(multipliers, INSIDE * np.mean(multipliers[multipliers > 0.0]))
    return newton.start(multipliers), slack, multipliers


def _direction(newton, slack, multipliers, primal, dual):
    """Predictor, corrector, and a correction of the products that keep the step short."""
    products = slack * multipliers
    mean = _dot(slack, multipliers) / len(slack)
    _, dw, du = newton.direction(products, slack, multipliers, primal, dual)
    length = min(_length(slack, multipliers, dw, du), 1.0)
    predicted = _dot(slack + length * dw, multipliers + length * du) / len(slack)
    aim = mean * (predicted / mean) ** 3
    products = products + dw * du - aim
    step = newton.direction(products, slack, multipliers, primal, dual)
    length = min(_length(slack, multipliers, *step[1:]), 1.0)
    if length > LONG:
        return step
    reach = min(length + LONGER, 1.0)
    found = (slack + reach * step[1]) * (multipliers + reach * step[2])
    low, high = aim / SPREAD, aim * SPREAD
    missing = np.where(found < low, low - found, np.maximum(np.minimum(high - found, 0.0), -high))
    corrected = newton.direction(products - missing, slack, multipliers, primal, dual)
    return corrected if _length(slack, multipliers, *corrected[1:]) > length else step


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
