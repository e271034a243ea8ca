"""Dual active-set method for one small zone, on an orthonormal basis of its active rows.

In scaled variables (SPEC 5) a zone is: minimise 1/2 |z|^2 subject to C z >= s, with rows
of unit length. With the active rows C_W = L Q, L lower triangular and Q orthonormal, their
multipliers u solve L L^T u = s_W, and z = C_W^T u. Starting from no active row, the most
violated row is added; rows whose multiplier would become negative on the way leave. A row
that depends on the active ones is never added: it either takes the place of one of them,
or shows that nothing satisfies all rows. So redundant and duplicated rows do no harm, and
every step increases the dual objective.

The basis is what makes nearly parallel rows safe: the distance of a row from the span of
the others is right to a few u. The Gram matrix alone would give its square to a few u,
and rows less than 1e-7 apart could not be told from one.

Source: D. Goldfarb, A. Idnani, A numerically stable dual method for solving strictly
convex quadratic programs (1983), section 3; B. N. Parlett, The Symmetric Eigenvalue Problem
(1998), 6.9, for projecting twice.
"""

import math

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.base.serial.views import matrix_of
from izo_ref.solvers.serial.constraints import (
    INFEASIBLE,
    NOT_CONVERGED,
    ROUNDING,
    SOLVED,
    add_constraint,
    constraint_dot,
    constraint_size,
    pull,
    violations,
)

# Distance of a unit row from the span of the active ones, below which it counts as in it.
# Rounding leaves some 1e-15 where it is zero.
DEPENDENT = 1e-13
# Of rows that are guessed to be active: nearly dependent ones wait for their turn, since
# multipliers of both signs on them would throw the guess away.
GUESSED_DEPENDENT = 1e-6


@compiled
def _project(row, first, nodes, coefficients, normals, basis, q, r, rest):
    """r = Q c, rest = c - Q^T r for a row c; returns the length of the rest.

    Once more if little is left: then rounding of the first projection counts.
    """
    for i in range(rest.shape[0]):
        rest[i] = 0.0
    add_constraint(1.0, row, first, nodes, coefficients, normals, rest)
    for k in range(q):
        r[k] = constraint_dot(row, first, nodes, coefficients, normals, basis[k])
    for k in range(q):
        for i in range(rest.shape[0]):
            rest[i] -= r[k] * basis[k, i]
    length = math.sqrt(_dot(rest, rest))
    if length > 0.5:
        return length
    for k in range(q):
        more = _dot(basis[k], rest)
        r[k] += more
        for i in range(rest.shape[0]):
            rest[i] -= more * basis[k, i]
    return math.sqrt(_dot(rest, rest))


@compiled
def _dot(a, b):
    value = 0.0
    for i in range(a.shape[0]):
        value += a[i] * b[i]
    return value


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
def _drop_row(factor, basis, q, row):
    """L and Q after a row left: rotate what then stands over the diagonal."""
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
        for k in range(basis.shape[1]):
            a = basis[i, k]
            b = basis[i + 1, k]
            basis[i, k] = c * a + s * b
            basis[i + 1, k] = c * b - s * a


@compiled
def _most_violated(first, nodes, coefficients, rhs, z, violation, is_active):
    """The row that is violated most, by more than its rounding; -1 if none is."""
    worst = -1
    for j in range(violation.shape[0]):
        if is_active[j] or not violation[j] > 0.0:
            continue
        if worst >= 0 and not violation[j] > violation[worst]:
            continue
        if violation[j] > ROUNDING * constraint_size(j, first, nodes, coefficients, rhs, z):
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
def _refine(factor, active, q, u, violation, r):
    """A step of iterative refinement of L L^T u = s_W; none if u would not stay positive."""
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
def _onto_rows(factor, basis, active, q, violation, r, z):
    """The shortest step that brings z onto the active rows: z += Q^T L^-1 (s_W - C_W z).

    C^T u has the rounding of u, which is large where rows are nearly opposed or parallel;
    this leaves that of z.
    """
    for k in range(q):
        r[k] = violation[active[k]]
    _solve_lower(factor, q, r)
    for k in range(q):
        for i in range(z.shape[0]):
            z[i] += r[k] * basis[k, i]


@compiled
def _start(first, nodes, coefficients, normals, rhs, u, active, is_active, factor, basis, rest, r):
    """Make the rows with u > 0 active, as far as multipliers stay positive; returns how many.

    Any set whose multipliers are positive will do to go on from.
    """
    q = np.int64(0)
    for j in range(u.shape[0]):
        if u[j] > 0.0 and q < basis.shape[0] - 1:
            distance = _project(j, first, nodes, coefficients, normals, basis, q, r, rest)
            if distance > GUESSED_DEPENDENT:
                q = _append(j, distance, q, active, is_active, factor, basis, rest, r)
    worst = np.int64(0)  # typed, as below: else what it goes to would be compiled twice
    while q > 0 and worst >= 0:
        for k in range(q):
            r[k] = rhs[active[k]]
        _solve_lower(factor, q, r)
        _solve_upper(factor, q, r)
        worst = np.int64(-1)
        for k in range(q):
            if r[k] <= 0.0 and (worst < 0 or r[k] < r[worst]):
                worst = k
        if worst >= 0:
            q = _remove(worst, q, active, is_active, factor, basis)
    u[:] = 0.0
    for k in range(q):
        u[active[k]] = r[k]
    return q


@compiled
def _append(row, distance, q, active, is_active, factor, basis, rest, r):
    """A row becomes active: r and rest as `_project` left them; returns the new count."""
    for k in range(q):
        factor[q, k] = r[k]
    factor[q, q] = distance
    for i in range(rest.shape[0]):
        basis[q, i] = rest[i] / distance
    active[q] = row
    is_active[row] = True
    return q + 1


@compiled
def _remove(place, q, active, is_active, factor, basis):
    """The active row at a place leaves; returns the new count."""
    is_active[active[place]] = False
    _drop_row(factor, basis, q, place)
    for k in range(place, q - 1):
        active[k] = active[k + 1]
    return q - 1


@compiled
def work_of_active_set(n, n_vertices):
    """How many numbers and indices of work space a zone of n impacts takes."""
    size = 3 * n_vertices
    return (n + 1) ** 2 + (min(n, size) + 2) * size + 2 * n, 2 * n


@compiled
def active_set(
    begin,
    end,
    first,
    last,
    all_nodes,
    all_coefficients,
    all_normals,
    rhs,
    numbers,
    indices,
    multipliers_out,
    z_out,
):
    """Solve the zone of impacts begin..end and unknowns first..last.

    Args:
        all_nodes: (n_impacts, 4) i4, of all zones; < 0 for pinned.
        all_coefficients: (n_impacts, 4) f8; with the normals, unit rows.
        all_normals: (n_impacts, 3) f8.
        rhs: (n_impacts,) f8, s.
        numbers, indices: f8 and i4, work space of `work_of_active_set`.
        multipliers_out: (n_impacts,) f8, u; begin..end are written. On entry, positive ones
            are a guess of which rows are active.
        z_out: (3 n_unknowns,) f8; those of first..last are written.

    Returns:
        SOLVED, INFEASIBLE or NOT_CONVERGED, and the number of rows added or dropped.
    """
    n, size = end - begin, 3 * (last - first)
    max_steps = 100 + 20 * n
    nodes, coefficients = all_nodes[begin:end], all_coefficients[begin:end]
    normals, s = all_normals[begin:end], rhs[begin:end]
    u = multipliers_out[begin:end]
    at, most = (n + 1) ** 2, min(n, size) + 1
    factor = matrix_of(numbers, n + 1, n + 1)
    basis = matrix_of(numbers[at:], most, size)
    at += most * size
    rest, violation = numbers[at : at + size], numbers[at + size : at + size + n]
    r = numbers[at + size + n : at + size + 2 * n]
    active, is_active = indices[:n], indices[n : 2 * n]
    is_active[:] = 0
    z = z_out[3 * first : 3 * last]
    q = _start(first, nodes, coefficients, normals, s, u, active, is_active, factor, basis, rest, r)
    pull(first, nodes, coefficients, normals, u, z)
    violations(first, nodes, coefficients, normals, s, z, violation)
    _onto_rows(factor, basis, active, q, violation, r, z)
    violations(first, nodes, coefficients, normals, s, z, violation)
    steps = 0
    while True:
        p = _most_violated(first, nodes, coefficients, s, z, violation, is_active)
        if p < 0:
            for _ in range(2):
                pull(first, nodes, coefficients, normals, u, z)
                violations(first, nodes, coefficients, normals, s, z, violation)
                _refine(factor, active, q, u, violation, r)
            for _ in range(2):
                _onto_rows(factor, basis, active, q, violation, r, z)
                violations(first, nodes, coefficients, normals, s, z, violation)
            return SOLVED, steps
        added = False
        while not added:
            steps += 1
            if steps > max_steps:
                return NOT_CONVERGED, steps
            distance = _project(p, first, nodes, coefficients, normals, basis, q, r, rest)
            for k in range(q):
                factor[q, k] = r[k]
            _solve_upper(factor, q, r)
            full = violation[p] / (distance * distance) if distance > DEPENDENT else np.inf
            step, place = _blocking(active, q, u, r)
            if full == np.inf and place < 0:
                return INFEASIBLE, steps
            step = min(step, full)
            for k in range(q):
                u[active[k]] -= step * r[k]
            u[p] += step
            if step == full:
                # r is solved for by now, and the factor's new row is in place
                for k in range(q):
                    r[k] = factor[q, k]
                q = _append(p, distance, q, active, is_active, factor, basis, rest, r)
                added = True
            else:
                u[active[place]] = 0.0
                q = _remove(place, q, active, is_active, factor, basis)
            pull(first, nodes, coefficients, normals, u, z)
            violations(first, nodes, coefficients, normals, s, z, violation)
            _onto_rows(factor, basis, active, q, violation, r, z)
            violations(first, nodes, coefficients, normals, s, z, violation)
