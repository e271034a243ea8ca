"""Cholesky factors of dense matrices, in loops over contiguous rows that vectorise."""

import math

from izo_ref._jit import compiled

# Pivots at a time. Each update of the trailing rows then does 8 operations for a load and a
# store: 8.5 GFlop/s from 128 rows on, where one pivot at a time is bound by the cache.
WIDTH = 4


# Below this many rows, sums down the columns are faster than loops made for vectors:
# 0.2 us against 1.5 us for 8 rows.
SMALL = 12


@compiled
def partial_cholesky(a, n, n_pivots, smallest):
    """Factor the first pivots of a symmetric matrix, and update the rest.

    With A = [[B, D], [D^T, E]] and B of `n_pivots` rows: B = R^T R, D becomes R^-T D, and E
    becomes E - D^T B^-1 D. Only the upper triangle of a[:n, :n] is read and written. Of R's
    diagonal the reciprocals are kept.

    A pivot of `smallest` or less becomes 0 and its row too: that unknown is left out, and
    solves give it 0.
    """
    if n <= SMALL:
        _small_cholesky(a, n, n_pivots, smallest)
        return
    for k in range(0, n_pivots, WIDTH):
        width = min(WIDTH, n_pivots - k)
        for p in range(k, k + width):
            row = a[p]
            for q in range(k, p):
                above = a[q]
                factor = above[p]
                for j in range(p, n):
                    row[j] -= factor * above[j]
            pivot = row[p]
            scale = 1.0 / math.sqrt(pivot) if pivot > smallest else 0.0
            row[p] = scale
            for j in range(p + 1, n):
                row[j] *= scale
        if width == WIDTH:
            p, q, r, s = a[k], a[k + 1], a[k + 2], a[k + 3]
            for i in range(k + WIDTH, n):
                row = a[i]
                by_p, by_q, by_r, by_s = p[i], q[i], r[i], s[i]
                for j in range(i, n):
                    row[j] -= by_p * p[j] + by_q * q[j] + by_r * r[j] + by_s * s[j]
        else:
            for q in range(k, k + width):
                above = a[q]
                for i in range(k + width, n):
                    row = a[i]
                    factor = above[i]
                    for j in range(i, n):
                        row[j] -= factor * above[j]


@compiled
def _small_cholesky(a, n, n_pivots, smallest):
    for i in range(n):
        pivots = min(i, n_pivots)
        for j in range(i, n):
            value = a[i, j]
            for k in range(pivots):
                value -= a[k, i] * a[k, j]
            a[i, j] = value
        if i < n_pivots:
            scale = 1.0 / math.sqrt(a[i, i]) if a[i, i] > smallest else 0.0
            a[i, i] = scale
            for j in range(i + 1, n):
                a[i, j] *= scale


@compiled
def cholesky_solve(a, n, x):
    """x <- (R^T R)^-1 x, with R in the upper triangle of a[:n, :n]."""
    if n <= SMALL:
        for k in range(n):
            value = x[k]
            for j in range(k):
                value -= a[j, k] * x[j]
            x[k] = value * a[k, k]
    else:
        for k in range(n):
            row = a[k]
            value = x[k] * row[k]
            x[k] = value
            for j in range(k + 1, n):
                x[j] -= value * row[j]
    for k in range(n - 1, -1, -1):
        row = a[k]
        value = x[k]
        for j in range(k + 1, n):
            value -= row[j] * x[j]
        x[k] = value * row[k]
