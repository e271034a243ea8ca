"""Primal-dual interior-point method for one large zone.

In scaled variables (SPEC 5): minimise 1/2 |z|^2 subject to C z - w = s, w >= 0. Each
iteration solves (I + C^T D C) dz = r with D = l / w by a sparse factorisation, twice
(predictor and corrector). Redundant rows, which make the dual singular and stop
active-set methods, do not matter here: the matrix is never less than I.

Source: S. Mehrotra, On the implementation of a primal-dual interior point method (1992);
Nocedal & Wright 2006, algorithm 16.4.
"""

import numpy as np

# Fraction of the way to the boundary that is taken.
TO_BOUNDARY = 0.995
MAX_ITERATIONS = 100
# s has the largest entry 1. Multipliers l prove that every feasible z has
# |z| >= l . s / |C^T l|; beyond this the zone counts as infeasible.
FARTHEST = 1e6


def scaled_matrix(nodes, coefficients, normals, n_unknowns):
    """C as a sparse matrix; nodes < 0 are pinned and have coefficient 0."""
    from scipy.sparse import csr_array

    columns = 3 * np.maximum(nodes, 0)[:, :, None] + np.arange(3)
    values = coefficients[:, :, None] * normals[:, None, :]
    starts = np.arange(0, 12 * len(nodes) + 1, 12)
    shape = (len(nodes), 3 * n_unknowns)
    return csr_array((values.ravel(), columns.ravel(), starts), shape=shape)


def interior_point(matrix, rhs, gap_tolerance, violation_tolerance):
    """Solve one zone.

    Args:
        matrix: (m, n) sparse, C, rows of unit length.
        rhs: (m,) f8, s; at least one entry is positive.
        gap_tolerance: relative duality gap to reach; it is undercut as far as rounding
            lets it.
        violation_tolerance: largest s - C z to reach, in the unit of rhs.

    Returns:
        z (n,), multipliers (m,), iterations, and False if nothing satisfies the rows.
    """
    from scipy.sparse import diags_array, eye_array
    from scipy.sparse.linalg import splu

    scale = np.abs(rhs).max()
    s = rhs / scale
    c = matrix
    ct = c.T.tocsr()
    identity = eye_array(c.shape[1])
    z = np.zeros(c.shape[1])
    slack = np.maximum(-s, 0.0) + 1.0
    multipliers = np.ones(len(s))
    best = (np.inf, z, multipliers, 0)
    for iteration in range(MAX_ITERATIONS):
        cz, pull = c @ z, ct @ multipliers
        dual = z - pull
        primal = cz - slack - s
        violation = float(np.max(s - cz))
        objective = 0.5 * z @ z
        gap = 0.5 * dual @ dual + multipliers @ np.abs(cz - s)
        # both tolerances as one number; 1e-3 below them the rest is rounding
        error = max(
            gap / max(objective, 1e-300) / gap_tolerance,
            violation * scale / violation_tolerance,
        )
        if error < best[0]:
            best = (error, z, multipliers, iteration)
        if error < 1e-3 or iteration > best[3] + 5:
            break
        if multipliers @ s > FARTHEST * np.linalg.norm(pull):
            return z * scale, multipliers * scale, iteration, False
        weights = multipliers / slack
        hessian = (identity + ct @ (diags_array(weights) @ c)).tocsc()
        factor = splu(
            hessian,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        mean = slack @ multipliers / len(s)

        def direction(products, *, factor=factor, dual=dual, primal=primal, state=(slack, multipliers)):
            w, u = state
            dz = factor.solve(-dual - ct @ ((products + u * primal) / w))
            dw = c @ dz + primal
            return dz, dw, -(products + u * dw) / w

        dz, dw, du = direction(slack * multipliers)
        length = min(_to_boundary(slack, dw), _to_boundary(multipliers, du), 1.0)
        predicted = (slack + length * dw) @ (multipliers + length * du) / len(s)
        target = mean * (predicted / mean) ** 3
        dz, dw, du = direction(slack * multipliers + dw * du - target)
        length = TO_BOUNDARY * min(_to_boundary(slack, dw), _to_boundary(multipliers, du))
        length = min(length, 1.0)
        z = z + length * dz
        slack = slack + length * dw
        multipliers = multipliers + length * du
    return best[1] * scale, best[2] * scale, iteration, True


def _to_boundary(values, step):
    """Largest multiple of a step that keeps positive values positive."""
    shrinking = step < 0.0
    return float(np.min(-values[shrinking] / step[shrinking], initial=np.inf))
