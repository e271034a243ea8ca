"""Cholesky factors of dense symmetric matrices.

A = R^T R with R upper triangular, which takes the place of the upper triangle of A. Loops run over
contiguous rows, so that the compiler vectorises them. How many pivots at a time update the rows
below depends on the size of the matrix:

    up to SMALL rows      all pivots above an entry, by a sum down two columns
    more                  WIDTH pivots
    from LARGE rows on    PANEL pivots, on tiles of four rows by CHUNK columns

Source: N. J. Higham, Accuracy and Stability of Numerical Algorithms (2002), chapter 10.
"""

import math

from izo_ref.base.arrays import AnyInt, Flags, Floats
from izo_ref.base.compile import compiled

# Up to this many rows, sums down the columns are faster than loops made for vectors: 0.2 us against
# 1.5 us for 8 rows.
SMALL = 12
# Pivots at a time. Each update of a row then does 8 operations for one load and one store, and runs
# at 10 GFlop/s. With one pivot at a time, the cache limits the speed.
WIDTH = 4
# From LARGE rows on, PANEL pivots update tiles of four rows by CHUNK columns, which are copied side
# by side: 32 operations for 8 loads and 4 stores. This runs at 12 GFlop/s for 100 rows and at 20
# for 300. Panels of 32 or chunks of 256 were no better.
LARGE, PANEL, CHUNK = 80, 16, 512


@compiled
def work_of_cholesky(n: int) -> int:
    """Return how many f8 numbers of work space a matrix of n rows takes."""
    return (PANEL + 4) * CHUNK + 16 if n >= LARGE else 0


@compiled
def partial_cholesky(a: Floats, n: AnyInt, n_pivots: AnyInt, smallest: float, work: Floats) -> None:
    """Factor the first pivots of a symmetric matrix, and update the rest.

    Let A = [[B, D], [D^T, E]], where B has `n_pivots` rows and B = R^T R. Then B becomes R, D
    becomes R^-T D, and E becomes E - D^T B^-1 D. The diagonal of R is stored as reciprocals.

    A pivot of `smallest` or less becomes 0, and so does its row. That unknown is left out: solves
    set it to 0.

    Args:
        a: f8, the matrix is a[:n, :n]; only its upper triangle is read and written.
        n: Number of rows.
        n_pivots: Number of rows of B.
        smallest: Largest pivot that is left out.
        work: (>= work_of_cholesky(n),) f8, work space, of any content.
    """
    if n <= SMALL:
        _small_cholesky(a, n, n_pivots, smallest)
        return
    in_panel = PANEL if n >= LARGE else WIDTH
    for begin in range(0, n_pivots, in_panel):
        _factor_panel(a, begin, min(begin + in_panel, n_pivots), n, smallest, work)


@compiled
def stoppable_cholesky(
    a: Floats, n: AnyInt, n_pivots: AnyInt, smallest: float, work: Floats, stop: Flags
) -> None:
    """Do what `partial_cholesky` does, but return at the next panel once `stop[0]` is set.

    A panel of a matrix of 10,000 rows takes 0.1 s. What is in `a` after a stop is of no use.
    """
    if n < LARGE:
        partial_cholesky(a, n, n_pivots, smallest, work)
        return
    for begin in range(0, n_pivots, PANEL):
        if stop[0]:
            return
        _factor_panel(a, begin, min(begin + PANEL, n_pivots), n, smallest, work)


@compiled
def _factor_panel(
    a: Floats, begin: AnyInt, end: AnyInt, n: AnyInt, smallest: float, work: Floats
) -> None:
    """Factor the rows begin..end, at most PANEL, and update all rows behind them."""
    for k in range(begin, end, WIDTH):
        last = min(k + WIDTH, end)
        _factor_rows(a, k, last, n, smallest)
        _update_rows(a, k, last, last, end, n)
    if end - begin == PANEL:
        _update_tiles(a, begin, n, work)
    else:
        for k in range(begin, end, WIDTH):
            _update_rows(a, k, min(k + WIDTH, end), end, n, n)


@compiled
def _factor_rows(a: Floats, begin: AnyInt, end: AnyInt, n: AnyInt, smallest: float) -> None:
    """Compute rows begin..end of the factor, at most WIDTH; all pivots before have updated them."""
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
def _update_rows(
    a: Floats, begin: AnyInt, end: AnyInt, first: AnyInt, last: AnyInt, n: AnyInt
) -> None:
    """Subtract R^T R of the factor's rows begin..end, at most WIDTH, from rows first..last."""
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
def copy(source: Floats, target: Floats) -> None:
    """Copy the numbers of a vector into one of the same length."""
    for j in range(target.shape[0]):  # from 0: otherwise the compiler does not vectorise it
        target[j] = source[j]


@compiled
def _update_tiles(a: Floats, begin: AnyInt, n: AnyInt, work: Floats) -> None:
    """Subtract R^T R of the factor's PANEL rows from begin on from all rows behind them."""
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
def _update_tile(
    a: Floats,
    begin: AnyInt,
    i: AnyInt,
    rows: AnyInt,
    panel: Floats,
    width: AnyInt,
    by: Floats,
    tile: Floats,
) -> None:
    """Subtract R^T R of the factor's PANEL rows from begin on from a tile of rows i..i + rows.

    `panel` holds the columns of these rows, and `by` is work space for 16 numbers.
    """
    # the distances between what is read and what is written are constants, so the compiler need not
    # check whether they overlap
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
def _small_cholesky(a: Floats, n: AnyInt, n_pivots: AnyInt, smallest: float) -> None:
    """Do what `partial_cholesky` does, by sums down the columns."""
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
def cholesky_solve(a: Floats, n: AnyInt, x: Floats) -> None:
    """Solve R^T R x' = x in place, with R in the upper triangle of a[:n, :n].

    R is as `partial_cholesky` left it, with reciprocals on its diagonal.
    """
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
