"""Cholesky factors of dense matrices, in loops over contiguous rows that vectorise."""

import math

from izo_ref.base.compile import compiled

# Below this many rows, sums down the columns are faster than loops made for vectors:
# 0.2 us against 1.5 us for 8 rows.
SMALL = 12
# Pivots at a time. Each update of a row then does 8 operations for a load and a store, and
# runs at 10 GFlop/s, where one pivot at a time is bound by the cache.
WIDTH = 4
# From so many rows on, PANEL pivots update tiles of four rows by CHUNK columns, copied side by
# side: 32 operations for 8 loads and 4 stores. 12 GFlop/s for 100 rows and 20 for 300; panels
# of 32 or chunks of 256 were no better.
LARGE, PANEL, CHUNK = 80, 16, 512


@compiled
def work_of_cholesky(n):
    """How many numbers of work space it takes."""
    return (PANEL + 4) * CHUNK + 16 if n >= LARGE else 0


@compiled
def partial_cholesky(a, n, n_pivots, smallest, work):
    """Factor the first pivots of a symmetric matrix, and update the rest.

    With A = [[B, D], [D^T, E]] and B of `n_pivots` rows: B = R^T R, D becomes R^-T D, and E
    becomes E - D^T B^-1 D. Only the upper triangle of a[:n, :n] is read and written. Of R's
    diagonal the reciprocals are kept.

    A pivot of `smallest` or less becomes 0 and its row too: that unknown is left out, and
    solves give it 0. `work`: (>= work_of_cholesky(n),) f8, of any content.
    """
    if n <= SMALL:
        _small_cholesky(a, n, n_pivots, smallest)
        return
    in_panel = PANEL if n >= LARGE else WIDTH
    for begin in range(0, n_pivots, in_panel):
        end = min(begin + in_panel, n_pivots)
        for k in range(begin, end, WIDTH):
            last = min(k + WIDTH, end)
            _take_pivots(a, k, last, n, smallest)
            _update(a, k, last, last, end, n)
        if end - begin == PANEL:
            _update_tiles(a, begin, n, work)
        else:
            for k in range(begin, end, WIDTH):
                _update(a, k, min(k + WIDTH, end), end, n, n)


@compiled
def _take_pivots(a, begin, end, n, smallest):
    """Rows begin..end of the factor, up to WIDTH."""
    for p in range(begin, end):
        row = a[p]
        for q in range(begin, p):
            above = a[q]
            factor = above[p]
            for j in range(p, n):
                row[j] -= factor * above[j]
        pivot = row[p]
        scale = 1.0 / math.sqrt(pivot) if pivot > smallest else 0.0
        row[p] = scale
        for j in range(p + 1, n):
            row[j] *= scale


@compiled
def _update(a, begin, end, first, last, n):
    """Rows first..last less their part in the factor's rows begin..end, up to WIDTH."""
    if end - begin == WIDTH:
        p, q, r, s = a[begin], a[begin + 1], a[begin + 2], a[begin + 3]
        for i in range(first, last):
            row = a[i]
            by_p, by_q, by_r, by_s = p[i], q[i], r[i], s[i]
            for j in range(i, n):
                row[j] -= by_p * p[j] + by_q * q[j] + by_r * r[j] + by_s * s[j]
        return
    for k in range(begin, end):
        above = a[k]
        for i in range(first, last):
            row = a[i]
            factor = above[i]
            for j in range(i, n):
                row[j] -= factor * above[j]


@compiled
def copy(source, target):
    for j in range(target.shape[0]):  # from 0, or it does not vectorise
        target[j] = source[j]


@compiled
def _update_tiles(a, begin, n, work):
    """What follows PANEL rows of the factor, from begin, less its part in them."""
    end, after = begin + PANEL, (PANEL + 4) * CHUNK
    panel, tile, by = work[: PANEL * CHUNK], work[PANEL * CHUNK : after], work[after:]
    for left in range(end, n, CHUNK):
        right = min(left + CHUNK, n)
        for k in range(PANEL):
            copy(a[begin + k, left:right], panel[k * CHUNK : k * CHUNK + right - left])
        for i in range(end, right, 4):
            rows = min(4, right - i)
            from_column = max(i, left)
            width = right - from_column
            for r in range(rows):
                copy(a[i + r, from_column:right], tile[r * CHUNK : r * CHUNK + width])
            _update_tile(a, begin, i, rows, panel[from_column - left :], width, by, tile)
            for r in range(rows):
                skip = max(i + r - from_column, 0)
                source = tile[r * CHUNK + skip : r * CHUNK + width]
                copy(source, a[i + r, from_column + skip : right])


@compiled
def _update_tile(a, begin, i, rows, panel, width, by, tile):
    # distances of what is read and written are constants: the compiler need not ask
    # whether they overlap
    for k in range(0, PANEL, 4):
        for r in range(rows):
            for q in range(4):
                by[4 * r + q] = a[begin + k + q, i + r]
        at = k * CHUNK
        a0, a1, a2, a3 = by[0], by[1], by[2], by[3]
        b0, b1, b2, b3 = by[4], by[5], by[6], by[7]
        c0, c1, c2, c3 = by[8], by[9], by[10], by[11]
        d0, d1, d2, d3 = by[12], by[13], by[14], by[15]
        for j in range(width):
            p, q = panel[at + j], panel[at + CHUNK + j]
            r, s = panel[at + 2 * CHUNK + j], panel[at + 3 * CHUNK + j]
            tile[j] -= a0 * p + a1 * q + a2 * r + a3 * s
            tile[CHUNK + j] -= b0 * p + b1 * q + b2 * r + b3 * s
            tile[2 * CHUNK + j] -= c0 * p + c1 * q + c2 * r + c3 * s
            tile[3 * CHUNK + j] -= d0 * p + d1 * q + d2 * r + d3 * s


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
