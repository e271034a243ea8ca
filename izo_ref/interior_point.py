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

# Fraction of the way to the boundary that is taken.
TO_BOUNDARY = 0.995
MAX_ITERATIONS = 100
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

    def __init__(self, matrix):
        self.c = matrix
        self.ct = matrix.T.tocsr()
        self.gram = (self.c @ self.ct).tocsc()
        self.gram.setdiag(self.gram.diagonal())  # so that every diagonal entry is stored
        self.gram.sort_indices()
        columns = np.repeat(np.arange(len(self.gram.indptr) - 1), np.diff(self.gram.indptr))
        self.diagonal = np.flatnonzero(self.gram.indices == columns)

    def start(self, multipliers):
        # z = C^T l at the start is z = C^T l to rounding at the end, whatever was factored
        return self.ct @ multipliers

    def factorize(self, slack, multipliers):
        system = self.gram.copy()
        system.data[self.diagonal] += slack / multipliers
        self.solve = _factor(system)

    def direction(self, products, slack, multipliers, primal, dual):
        du = self.solve(self.c @ dual - primal - products / multipliers)
        dz = self.ct @ du - dual
        return dz, -(products + slack * du) / multipliers, du


class _Columns:
    """Newton's equations reduced to the unknowns."""

    def __init__(self, matrix):
        from scipy.sparse import eye_array

        self.c = matrix
        self.ct = matrix.T.tocsr()
        self.identity = eye_array(matrix.shape[1])

    def start(self, multipliers):
        return np.zeros(self.c.shape[1])

    def factorize(self, slack, multipliers):
        from scipy.sparse import diags_array

        weighted = diags_array(multipliers / slack) @ self.c
        self.solve = _factor((self.identity + self.ct @ weighted).tocsc())

    def direction(self, products, slack, multipliers, primal, dual):
        dz = self.solve(-dual - self.ct @ ((products + multipliers * primal) / slack))
        dw = self.c @ dz + primal
        return dz, dw, -(products + multipliers * dw) / slack


def _factor(system):
    from scipy.sparse.linalg import splu

    return splu(
        system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    ).solve


def interior_point(matrix, rhs, gap_tolerance, violation_tolerance):
    """Solve one zone.

    Args:
        matrix: (m, n) sparse, C, rows of unit length.
        rhs: (m,) f8, s; at least one entry is positive.
        gap_tolerance: relative duality gap to reach; it is undercut as far as rounding
            lets it.
        violation_tolerance: largest s - C z to reach, in the unit of rhs.

    Returns:
        z (n,), multipliers (m,), iterations, and False if the rows were not satisfied:
        nothing does, or nothing near.
    """
    scale = rhs.max()
    s = rhs / scale
    newton = (_Rows if matrix.shape[0] < matrix.shape[1] else _Columns)(matrix)
    c, ct = newton.c, newton.ct
    multipliers = np.ones(len(s))
    z = newton.start(multipliers)
    slack = np.maximum(c @ z - s, 0.0) + 1.0
    best = (np.inf, z, multipliers, 0)
    for iteration in range(MAX_ITERATIONS):
        cz, pull = c @ z, ct @ multipliers
        dual = z - pull
        primal = cz - slack - s
        violation = float(np.max(s - cz))
        objective = 0.5 * z @ z
        gap = 0.5 * dual @ dual + multipliers @ np.abs(cz - s)
        # both tolerances as one number; 1e-3 below them the rest is rounding
        relative_gap = gap / objective if objective > 0.0 else np.inf
        error = max(relative_gap / gap_tolerance, violation * scale / violation_tolerance)
        if error < best[0]:
            best = (error, z, multipliers, iteration)
        if error < 1e-3 or iteration > best[3] + 5:
            break
        if multipliers @ s > FARTHEST * np.linalg.norm(pull):
            return z * scale, multipliers * scale, iteration, False
        try:
            newton.factorize(slack, multipliers)
        except RuntimeError:  # it says "singular": weights beyond all bounds, as far as it goes
            break
        mean = slack @ multipliers / len(s)
        products = slack * multipliers
        dz, dw, du = newton.direction(products, slack, multipliers, primal, dual)
        length = min(_to_boundary(slack, dw), _to_boundary(multipliers, du), 1.0)
        predicted = (slack + length * dw) @ (multipliers + length * du) / len(s)
        products += dw * du - mean * (predicted / mean) ** 3
        dz, dw, du = newton.direction(products, slack, multipliers, primal, dual)
        length = TO_BOUNDARY * min(_to_boundary(slack, dw), _to_boundary(multipliers, du))
        length = min(length, 1.0)
        z = z + length * dz
        slack = slack + length * dw
        multipliers = multipliers + length * du
    violation = float(np.max(rhs - c @ (best[1] * scale)))
    return best[1] * scale, best[2] * scale, iteration, violation <= violation_tolerance


def _to_boundary(values, step):
    """Largest multiple of a step that keeps positive values positive."""
    shrinking = step < 0.0
    return float(np.min(-values[shrinking] / step[shrinking], initial=np.inf))
