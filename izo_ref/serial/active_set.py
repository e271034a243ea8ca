"""Dual active-set method for one small zone, on the Gram matrix of its unit rows.

In scaled variables (SPEC 5) a zone is: minimise 1/2 |z|^2 subject to C z >= s, with rows
of unit length. With K = C C^T the multipliers u of the active rows W solve K_WW u = s_W,
and z = C^T u. Starting from no active row, the most violated row is added; rows whose
multiplier would become negative on the way leave. A row that depends on the active ones
is never added: it either takes the place of one of them, or shows that nothing satisfies
all rows. So redundant and duplicated rows do no harm, and every step increases the dual
objective.

Source: D. Goldfarb, A. Idnani, A numerically stable dual method for solving strictly
convex quadratic programs (1983), section 3, with the Cholesky factor of K_WW in place of
their QR factors.
"""

import math

import numpy as np

from izo_ref._jit import compiled

SOLVED = 0
INFEASIBLE = 1
NOT_CONVERGED = 2

# Squared distance of a unit row from the span of the active ones. Rounding leaves some
# 1e-15 where it is zero; below the threshold a row counts as dependent.
DEPENDENT_SQ = 1e-13
# Violation that counts as none, over the largest of |s| and u: K u has that rounding.
ROUNDING = 4e-15


@compiled
def gram_matrix(nodes, coefficients, normals, gram_out):
    """K_ij = sum over common nodes of c_ik c_jm, times N_i . N_j; nodes < 0 are pinned."""
    n = nodes.shape[0]
    for i in range(n):
        for j in range(i + 1):
            common = 0.0
            for k in range(4):
                for m in range(4):
                    if nodes[i, k] >= 0 and nodes[i, k] == nodes[j, m]:
                        common += coefficients[i, k] * coefficients[j, m]
            if common != 0.0:
                common *= (
                    normals[i, 0] * normals[j, 0]
                    + normals[i, 1] * normals[j, 1]
                    + normals[i, 2] * normals[j, 2]
                )
            gram_out[i, j] = common
            gram_out[j, i] = common


@compiled
def _solve_lower(factor, q, x):
    for i in range(q):
        value = x[i]
        for k in range(i):
            value -= factor[i, k] * x[k]
        x[i] = value / factor[i, i]


@compiled
def _solve_upper(factor, q, x):
    for i in range(q - 1, -1, -1):
        value = x[i]
        for k in range(i + 1, q):
            value -= factor[k, i] * x[k]
        x[i] = value / factor[i, i]


@compiled
def _drop_row(factor, q, row):
    """Cholesky factor after a row and column left: rotate what stands over the diagonal."""
    for i in range(row, q - 1):
        for k in range(i + 2):
            factor[i, k] = factor[i + 1, k]
    for i in range(row, q - 1):
        a = factor[i, i]
        b = factor[i, i + 1]
        length = math.sqrt(a * a + b * b)
        c = a / length
        s = b / length
        for k in range(i, q - 1):
            a = factor[k, i]
            b = factor[k, i + 1]
            factor[k, i] = c * a + s * b
            factor[k, i + 1] = c * b - s * a


@compiled
def _residuals(gram, rhs, active, q, u, violation):
    """violation = s - K u, summed in the order of the active rows."""
    for j in range(rhs.shape[0]):
        value = rhs[j]
        for k in range(q):
            value -= gram[j, active[k]] * u[active[k]]
        violation[j] = value


@compiled
def _most_violated(violation, is_active):
    worst = -1
    for j in range(violation.shape[0]):
        if not is_active[j] and (worst < 0 or violation[j] > violation[worst]):
            worst = j
    return worst


@compiled
def _blocking(active, q, u, r):
    """The active row whose multiplier reaches zero first along -r, and the step there."""
    step = np.inf
    place = -1
    for k in range(q):
        if r[k] > 0.0 and u[active[k]] / r[k] < step:
            step = u[active[k]] / r[k]
            place = k
    return step, place


@compiled
def _refine(gram, rhs, factor, active, q, u, violation, r):
    """One step of iterative refinement of K_WW u = s_W; kept only if u stays positive."""
    _residuals(gram, rhs, active, q, u, violation)
    for k in range(q):
        r[k] = violation[active[k]]
    _solve_lower(factor, q, r)
    _solve_upper(factor, q, r)
    for k in range(q):
        if u[active[k]] + r[k] < 0.0:
            return
    for k in range(q):
        u[active[k]] += r[k]


@compiled
def active_set(begin, end, nodes, coefficients, normals, rhs, multipliers_out):
    """Solve the zone of impacts begin..end.

    Args:
        nodes: (n_impacts, 4) i4, of all zones; < 0 for pinned.
        coefficients: (n_impacts, 4) f8; with the normals, unit rows.
        normals: (n_impacts, 3) f8.
        rhs: (n_impacts,) f8, s.
        multipliers_out: (n_impacts,) f8, u; begin..end are written.

    Returns:
        SOLVED, INFEASIBLE or NOT_CONVERGED, and the number of rows added or dropped.
    """
    n = end - begin
    max_steps = 100 + 20 * n
    gram = np.empty((n, n))
    gram_matrix(nodes[begin:end], coefficients[begin:end], normals[begin:end], gram)
    s = rhs[begin:end]
    u = multipliers_out[begin:end]
    factor = np.zeros((n + 1, n + 1))
    active = np.empty(n, np.int64)
    is_active = np.zeros(n, np.bool_)
    violation = s.copy()
    r = np.empty(n)
    largest_s = 0.0
    for j in range(n):
        u[j] = 0.0
        largest_s = max(largest_s, abs(s[j]))
    q = np.int64(0)  # typed: a literal 0 would be compiled for a second time
    steps = 0
    while True:
        largest = largest_s
        for k in range(q):
            largest = max(largest, u[active[k]])
        p = _most_violated(violation, is_active)
        if p < 0 or violation[p] <= ROUNDING * largest:
            for _ in range(2):
                _refine(gram, s, factor, active, q, u, violation, r)
            return SOLVED, steps
        added = False
        while not added:
            steps += 1
            if steps > max_steps:
                return NOT_CONVERGED, steps
            distance_sq = gram[p, p]
            for k in range(q):
                r[k] = gram[active[k], p]
            _solve_lower(factor, q, r)
            for k in range(q):
                factor[q, k] = r[k]
                distance_sq -= r[k] * r[k]
            _solve_upper(factor, q, r)
            full = violation[p] / distance_sq if distance_sq > DEPENDENT_SQ else np.inf
            step, place = _blocking(active, q, u, r)
            if full == np.inf and place < 0:
                return INFEASIBLE, steps
            step = min(step, full)
            for k in range(q):
                u[active[k]] -= step * r[k]
            u[p] += step
            if step == full:
                factor[q, q] = math.sqrt(distance_sq)
                active[q] = p
                is_active[p] = True
                q += 1
                added = True
                _residuals(gram, s, active, q, u, violation)
            else:
                u[active[place]] = 0.0
                is_active[active[place]] = False
                _drop_row(factor, q, place)
                for k in range(place, q - 1):
                    active[k] = active[k + 1]
                q -= 1
                _residuals(gram, s, active, q, u, violation)
                for j in range(n):
                    violation[j] -= gram[j, p] * u[p]
