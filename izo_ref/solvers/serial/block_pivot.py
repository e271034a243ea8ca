"""Block principal pivoting for one zone: the fast way, for rows that are far from dependent.

In scaled variables (SPEC 5) the multipliers of a zone solve: u >= 0, K u >= s, complementary,
with K = C C^T and rows of unit length. A few sweeps of Gauss-Seidel guess which rows are
active; then K_FF u_F = s_F is solved for the guess F, rows whose multiplier is negative leave
it, rows that are violated enter it, all at once, until none is left. That takes two to four
factorisations where adding row by row takes one step for each active row.

What it gives up for that: it may cycle, and the Gram matrix K squares how nearly dependent
rows are. So it answers only if every row holds to rounding with pivots far from zero, and
says NOT_CONVERGED otherwise: solvers/serial/active_set.py minds neither.

Source: J. J. Judice, F. M. Pires, A block principal pivoting algorithm for large-scale
strictly monotone linear complementarity problems (1994); the guess: SPEC section 3's dual,
row by row.
"""

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.base.serial.views import matrix_of
from izo_ref.solvers.serial.constraints import (
    NOT_CONVERGED,
    ROUNDING,
    SOLVED,
    add_constraint,
    constraint_size,
    pull,
    violations,
)
from izo_ref.solvers.serial.dense import cholesky_solve, partial_cholesky, work_of_cholesky

# Square of the distance of a row from the span of those before it, below which it is left
# out. Rounding of K moves it by some 1e-15, so what passes is right to 1e-9 before, and to
# the square of that after the correction.
SMALLEST_PIVOT = 1e-6
# A sweep costs n^2, a factorisation a sixth of the cube of the active rows: up to the size
# given, sets are exchanged rather than swept for.
SWEEPS, FEW_SWEEPS, FEW_ROWS = 8, 3, 24
# Violation over the sizes of a row's terms that no correction could make less.
LAST_DIGIT = 4e-16
# Exchanges in a row that change no fewer rows than one before did: it cycles, or is about to.
PATIENCE = 3


@compiled
def _gram(first, nodes, coefficients, normals, head, chain, gram):
    """K = C C^T, from lists of the rows at each unknown."""
    n = nodes.shape[0]
    for i in range(head.shape[0]):
        head[i] = -1
    for i in range(n):
        row = gram[i]
        for j in range(n):
            row[j] = 0.0
    for i in range(n):
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        for k in range(4):
            if nodes[i, k] < 0:
                continue
            at, own = nodes[i, k] - first, coefficients[i, k]
            entry = head[at]
            while entry >= 0:
                j = entry >> 2
                cosine = x * normals[j, 0] + y * normals[j, 1] + z * normals[j, 2]
                gram[i, j] += own * coefficients[j, entry & 3] * cosine
                entry = chain[entry]
            gram[i, i] += own * own * (x * x + y * y + z * z)
            chain[4 * i + k] = head[at]
            head[at] = 4 * i + k
    for i in range(n):
        for j in range(i):
            gram[j, i] = gram[i, j]


@compiled
def _sweep(gram, u, w):
    """One sweep of Gauss-Seidel over u >= 0; w = s - K u is kept."""
    for i in range(u.shape[0]):
        row = gram[i]
        if row[i] > 0.0:
            step = max(w[i] / row[i], -u[i])
            if step != 0.0:
                u[i] += step
                for j in range(w.shape[0]):
                    w[j] -= step * row[j]


@compiled
def _factor_of(gram, free, q, factor, tiles):
    for a in range(q):
        row, out = gram[free[a]], factor[a]
        for b in range(a, q):
            out[b] = row[free[b]]
    partial_cholesky(factor, q, q, SMALLEST_PIVOT, tiles)


@compiled
def _exchange(u, w, scale, is_free):
    """Rows with a negative multiplier leave, violated ones enter; returns how many did."""
    changed = 0
    for j in range(u.shape[0]):
        if is_free[j]:
            if u[j] < 0.0:
                is_free[j] = False
                changed += 1
        elif w[j] > scale:
            is_free[j] = True
            changed += 1
    return changed


@compiled
def _holds(rounding, first, nodes, coefficients, rhs, z, violation, is_free):
    """Whether every row is satisfied to rounding, and with equality if it is active."""
    for j in range(rhs.shape[0]):
        off = abs(violation[j]) if is_free[j] else violation[j]
        if off <= rounding * abs(rhs[j]):  # no need for the exact size
            continue
        if off > rounding * constraint_size(j, first, nodes, coefficients, rhs, z):
            return False
    return True


@compiled
def work_of_block_pivot(n, n_vertices):
    """How many numbers and indices of work space a zone of n impacts takes."""
    return 2 * n * n + 2 * n + work_of_cholesky(n), 6 * n + n_vertices


@compiled
def block_pivot(
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
        numbers, indices: f8 and i4, work space of `work_of_block_pivot`.
        multipliers_out: (n_impacts,) f8, u; begin..end are written.
        z_out: (3 n_unknowns,) f8; those of first..last are written.

    Returns:
        SOLVED or NOT_CONVERGED, and the number of factorisations. If not converged, positive
        multipliers are a guess of what is active, and z is of no use.
    """
    n = end - begin
    nodes, coefficients = all_nodes[begin:end], all_coefficients[begin:end]
    normals, s = all_normals[begin:end], rhs[begin:end]
    u, z = multipliers_out[begin:end], z_out[3 * first : 3 * last]
    gram, factor = matrix_of(numbers, n, n), matrix_of(numbers[n * n :], n, n)
    w, step = numbers[2 * n * n : 2 * n * n + n], numbers[2 * n * n + n : 2 * n * n + 2 * n]
    tiles = numbers[2 * n * n + 2 * n :]
    chain, free, is_free = indices[: 4 * n], indices[4 * n : 5 * n], indices[5 * n : 6 * n]
    _gram(first, nodes, coefficients, normals, indices[6 * n : 6 * n + last - first], chain, gram)
    largest = 0.0
    for j in range(n):
        u[j] = 0.0
        w[j] = s[j]
        largest = max(largest, abs(s[j]))
    for _ in range(SWEEPS if n > FEW_ROWS else FEW_SWEEPS):
        _sweep(gram, u, w)
    for j in range(n):
        is_free[j] = u[j] > 0.0
    fewest, patience, factorizations = n + 1, PATIENCE, 0
    while True:
        q = np.int64(0)  # typed: for a constant all below would be compiled once more
        for j in range(n):
            if is_free[j]:
                free[q] = j
                step[q] = s[j]
                q += 1
        factorizations += 1
        _factor_of(gram, free, q, factor, tiles)
        cholesky_solve(factor, q, step)
        for j in range(n):
            u[j] = 0.0
            w[j] = s[j]
        for a in range(q):
            # left out: active no longer, so it may have slack, and enters again if violated
            is_free[free[a]] = factor[a, a] > 0.0
            row, value = gram[free[a]], step[a]
            u[free[a]] = value
            for j in range(n):
                w[j] -= value * row[j]
        changed = _exchange(u, w, ROUNDING * largest, is_free)
        if changed == 0:
            break
        patience = PATIENCE if changed < fewest else patience - 1
        fewest = min(fewest, changed)
        if patience < 0:
            return NOT_CONVERGED, factorizations
    pull(first, nodes, coefficients, normals, u, z)
    violations(first, nodes, coefficients, normals, s, z, w)
    if _holds(LAST_DIGIT, first, nodes, coefficients, s, z, w, is_free):
        return SOLVED, factorizations
    # K's rounding is in u; that of s - C z is not, and z need not be C^T u
    for a in range(q):
        step[a] = w[free[a]]
    cholesky_solve(factor, q, step)
    for a in range(q):
        u[free[a]] = max(u[free[a]] + step[a], 0.0)
        add_constraint(step[a], np.int64(free[a]), first, nodes, coefficients, normals, z)
    violations(first, nodes, coefficients, normals, s, z, w)
    holds = _holds(ROUNDING, first, nodes, coefficients, s, z, w, is_free)
    return (SOLVED if holds else NOT_CONVERGED), factorizations
