"""Cholesky factors of a sparse symmetric matrix in its envelope, computed by a thread group.

A = L L^T, and L takes the place of A. The envelope of a row reaches from its first entry that is
not zero to the diagonal, and L has no entry outside of it. So if rows are numbered along the length
of a zone, L is narrow: a row has entries for its neighbours, and not for all rows before it.

The envelope is kept in tiles of SIDE x SIDE numbers. Tile row i has the tiles from `firsts[i]` to
i, one after the other, and each of them column by column. No row begins before the row above it,
so that the tile rows with an entry in a tile column are neighbours, too.

For each tile column, the threads wait twice. They compute its tiles below the diagonal, wait, and
take the products of these tiles from the tiles to the right. Meanwhile, one team takes them from
the next tile on the diagonal, and factors it. So it is there when all threads have waited again.

Source: A. George and J. W. Liu, Computer Solution of Large Sparse Positive Definite Systems (1981),
chapter 4; the tiles are those of A. Buttari et al., A class of parallel tiled linear algebra
algorithms for multicore architectures (2009).
"""

import math
from typing import NamedTuple

from izo_ref.base.arrays import AnyInt, Floats, Ints
from izo_ref.base.compile import compiled, inlined
from izo_ref.base.serial.thread_group import ThreadGroup
from izo_ref.base.serial.views import place

# Rows of a tile. With more, fewer tile columns wait for each other, and the team that factors a
# tile on the diagonal takes longer. Not measured on a GPU yet.
SIDE, SHIFT = 16, 4
AREA = SIDE * SIDE
# Most tiles of a matrix: `place` has indices below 2^32, and an i4 counts the tiles.
MOST_TILES = 1 << 24


class Envelope(NamedTuple):
    """Where the tiles of a matrix are; all arrays have room for more tile rows."""

    n_rows: AnyInt  # rows of the matrix
    n: AnyInt  # tile rows
    firsts: Ints  # (n,) i4, the first tile of each tile row; ascending
    lasts: Ints  # (n,) i4, the last tile of each tile column; ascending
    starts: Ints  # (n + 1,) i4, how many tiles come before each tile row, MOST_TILES + 1 at most


@inlined
def count_tiles(n: AnyInt) -> int:
    """Return how many tile rows n rows take."""
    return (n + SIDE - 1) >> SHIFT


@inlined
def dense_tiles(n: AnyInt) -> int:
    """Return how many tiles n rows have, if every row begins at column 0."""
    tiles = count_tiles(n)
    return (tiles * (tiles + 1)) >> 1


@compiled
def complete(envelope: Envelope) -> None:
    """Complete an envelope; one thread calls this.

    Args:
        envelope: `firsts` has the first tile that is needed in each tile row, and becomes
            ascending; the other arrays are written.
    """
    n, firsts, lasts, starts = envelope[1:]
    least = int(n)
    for i in range(n - 1, -1, -1):
        least = min(least, firsts[i])
        firsts[i] = least
    n_before, last = 0, 0
    for i in range(n):
        starts[i] = n_before
        n_before = min(n_before + i - firsts[i] + 1, MOST_TILES + 1)
        while last + 1 < n and firsts[last + 1] <= i:
            last += 1
        lasts[i] = last
    starts[n] = n_before


@inlined
def size_of(envelope: Envelope) -> int:
    """Return how many numbers the tiles have."""
    return AREA * int(envelope.starts[envelope.n])


@inlined
def fits(envelope: Envelope, a: Floats) -> bool:
    """Return whether the tiles have room in memory, and indices that `place` can return."""
    return envelope.starts[envelope.n] <= MOST_TILES and size_of(envelope) <= a.shape[0]


@inlined
def tile_at(envelope: Envelope, i: AnyInt, j: AnyInt) -> int:
    """Return where the numbers of tile (i, j) begin."""
    return AREA * (envelope.starts[i] - envelope.firsts[i] + j)


@compiled
def factorize(group: ThreadGroup, envelope: Envelope, a: Floats, scales_out: Floats) -> None:
    """Factor a matrix; all threads have to see it before, and see L afterwards.

    A pivot that is not positive makes its column zero, and solves set its unknown to 0. So rows
    that fill the last tile may be zero.

    Args:
        group: The threads.
        envelope: Where the tiles are.
        a: f8, the tiles, which become those of L below the diagonal. On the diagonal they have the
            pivots, the squares of the diagonal of L.
        scales_out: (>= SIDE envelope.n,) f8, the reciprocals of the diagonal of L.
    """
    if envelope.n == 0:
        return
    if is_last_team(group):
        _factor_tile(group, a, tile_at(envelope, 0, 0), 0, scales_out)
    group.wait()
    for k in range(envelope.n - 1):
        _scale_below(group, envelope, k, a, scales_out)
        group.wait()
        if is_last_team(group):
            _take_diagonal(group, envelope, k, a)
            _factor_tile(group, a, tile_at(envelope, k + 1, k + 1), k + 1, scales_out)
        _take_products(group, envelope, k, a)
        group.wait()


@compiled
def is_last_team(group: ThreadGroup) -> bool:
    """Return whether a thread is in the team that has a task of its own."""
    return group.team.number() == group.team.count() - 1


@compiled
def _count_others(group: ThreadGroup) -> int:
    """Return how many threads are not in the last team; all threads if there is one team."""
    return group.size() - (group.team.size() if group.team.count() > 1 else 0)


@compiled
def _factor_tile(group: ThreadGroup, a: Floats, at: AnyInt, k: AnyInt, scales_out: Floats) -> None:
    """Factor tile k on the diagonal, which begins at `at`, by the threads of a team.

    Each thread computes some rows. In step c it computes entry (r, c) of its rows r > c, and takes
    its square from the entry on the diagonal. So the next pivot is complete after one wait.
    """
    rank, size = group.team.rank(), group.team.size()
    group.team.wait()
    for c in range(SIDE):
        pivot = a[place(at + c * SIDE + c)]
        scale = 1.0 / math.sqrt(pivot) if pivot > 0.0 else 0.0
        if rank == 0:
            scales_out[place(k * SIDE + c)] = scale
        r = rank
        while r < SIDE:
            if r > c:
                value = a[place(at + c * SIDE + r)]
                for b in range(c):
                    value -= a[place(at + b * SIDE + r)] * a[place(at + b * SIDE + c)]
                value *= scale
                a[place(at + c * SIDE + r)] = value
                a[place(at + r * SIDE + r)] -= value * value
            r += size
        group.team.wait()


@compiled
def _scale_below(
    group: ThreadGroup, envelope: Envelope, k: AnyInt, a: Floats, scales: Floats
) -> None:
    """Compute the tiles of L below tile k on the diagonal, each thread some rows."""
    diagonal = tile_at(envelope, k, k)
    end = SIDE * (envelope.lasts[k] - k)
    row, size = group.rank(), group.size()
    while row < end:
        at = place(tile_at(envelope, k + 1 + (row >> SHIFT), k) + (row & (SIDE - 1)))
        for c in range(SIDE):
            value = a[place(at + c * SIDE)]
            for b in range(c):
                value -= a[place(at + b * SIDE)] * a[place(diagonal + b * SIDE + c)]
            a[place(at + c * SIDE)] = value * scales[place(k * SIDE + c)]
        row += size


@compiled
def _take_diagonal(group: ThreadGroup, envelope: Envelope, k: AnyInt, a: Floats) -> None:
    """Take the products of tile column k from the next tile on the diagonal, by a team."""
    if envelope.lasts[k] > k:
        own, left = tile_at(envelope, k + 1, k + 1), tile_at(envelope, k + 1, k)
        entry, size = group.team.rank(), group.team.size()
        while entry < AREA:
            if (entry & (SIDE - 1)) >= (entry >> SHIFT):  # on or below the diagonal
                _take_product(a, own, left, left, entry)
            entry += size


@compiled
def _take_products(group: ThreadGroup, envelope: Envelope, k: AnyInt, a: Floats) -> None:
    """Take the products of tile column k from all other tiles, by all but the last team."""
    n, others = envelope.lasts[k] - k, _count_others(group)
    if group.rank() >= others:
        return
    end, entry = AREA * ((n * (n + 1)) >> 1), AREA + group.rank()
    while entry < end:
        pair = entry >> (2 * SHIFT)
        # Pairs are numbered row by row of a triangle. The root of a square is exact.
        i = int((math.sqrt(8.0 * pair + 1.0) - 1.0) * 0.5)
        j = pair - ((i * (i + 1)) >> 1)
        row, column = k + 1 + i, k + 1 + j
        own = tile_at(envelope, row, column)
        left, above = tile_at(envelope, row, k), tile_at(envelope, column, k)
        _take_product(a, own, left, above, entry & (AREA - 1))
        entry += others


@inlined
def _take_product(a: Floats, own: AnyInt, left: AnyInt, above: AnyInt, entry: AnyInt) -> None:
    """Take one entry of the product of two tiles, the second one transposed, from a third tile."""
    total, x, y = 0.0, place(left + (entry & (SIDE - 1))), place(above + (entry >> SHIFT))
    for _ in range(SIDE):
        total += a[x] * a[y]
        x, y = place(x + SIDE), place(y + SIDE)
    a[place(own + entry)] -= total
