"""Solve with a Cholesky factor in its envelope (`envelope.py`), by one team of a thread group.

Tile columns follow each other: a team solves with the tile on the diagonal, and takes the products
of the other tiles of the column from the rest of the right-hand side.
"""

from izo_ref.base.arrays import AnyInt, Floats
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup
from izo_ref.base.serial.views import ONE, place
from izo_ref.solvers.serial.envelope import SHIFT, SIDE, Envelope, is_last_team, tile_at


@compiled
def solve(group: ThreadGroup, envelope: Envelope, a: Floats, scales: Floats, x: Floats) -> None:
    """Solve L L^T x' = x in place; all threads have to see x before, and see x' afterwards.

    One team solves: there is little to do in a tile column, and the threads of a team wait for each
    other in less time than all threads do. Not measured on a GPU yet.

    Args:
        group: The threads.
        envelope: Where the tiles are.
        a: L, as `factorize` left it.
        scales: What `factorize` wrote.
        x: (>= SIDE envelope.n,) f8.
    """
    if is_last_team(group):
        for k in range(envelope.n):
            _solve_tile(group, a, tile_at(envelope, k, k), scales, k, x)
            _take_below(group, envelope, k, a, x)
        for k in range(envelope.n - 1, -1, -1):
            _solve_tile_back(group, a, tile_at(envelope, k, k), scales, k, x)
            _take_left(group, envelope, k, a, x)
    group.wait()


@compiled
def _solve_tile(
    group: ThreadGroup, a: Floats, at: AnyInt, scales: Floats, k: AnyInt, x: Floats
) -> None:
    """Solve with tile k on the diagonal, by the threads of a team, which see x afterwards."""
    rank, size, own = group.team.rank(), group.team.size(), SIDE * k
    for c in range(SIDE):
        value, r = x[place(own + c)] * scales[place(own + c)], rank
        while r < SIDE:
            if r > c:
                x[place(own + r)] -= value * a[place(at + c * SIDE + r)]
            r += size
        group.team.wait()
    _scale(group, own, scales, x)


@compiled
def _solve_tile_back(
    group: ThreadGroup, a: Floats, at: AnyInt, scales: Floats, k: AnyInt, x: Floats
) -> None:
    """Solve with tile k on the diagonal, transposed, by the threads of a team, which see x."""
    rank, size, own = group.team.rank(), group.team.size(), SIDE * k
    for c in range(SIDE - 1, -1, -1):
        value, r = x[place(own + c)] * scales[place(own + c)], rank
        while r < c:
            x[place(own + r)] -= value * a[place(at + r * SIDE + c)]
            r += size
        group.team.wait()
    _scale(group, own, scales, x)


@compiled
def _scale(group: ThreadGroup, own: AnyInt, scales: Floats, x: Floats) -> None:
    """Multiply the unknowns of a tile by the reciprocals of the diagonal of L."""
    r, size = group.team.rank(), group.team.size()
    while r < SIDE:
        x[place(own + r)] *= scales[place(own + r)]
        r += size
    group.team.wait()


@compiled
def _take_below(group: ThreadGroup, envelope: Envelope, k: AnyInt, a: Floats, x: Floats) -> None:
    """Take the products of tile column k with its unknowns from x below, by a team."""
    row, end, own = group.team.rank() + SIDE * (k + 1), SIDE * (envelope.lasts[k] + 1), SIDE * k
    while row < end:
        at, total = place(tile_at(envelope, row >> SHIFT, k) + (row & (SIDE - 1))), 0.0
        for c in range(SIDE):
            total += a[at] * x[place(own + c)]
            at = place(at + SIDE)
        x[place(row)] -= total
        row += group.team.size()
    group.team.wait()


@compiled
def _take_left(group: ThreadGroup, envelope: Envelope, k: AnyInt, a: Floats, x: Floats) -> None:
    """Take the products of tile row k, transposed, with its unknowns from x above, by a team."""
    column, own = group.team.rank() + SIDE * envelope.firsts[k], SIDE * k
    row_at = tile_at(envelope, k, 0)
    while column < own:
        at, total = place(row_at + SIDE * column), 0.0
        for r in range(SIDE):
            total += a[at] * x[place(own + r)]
            at = place(at + ONE)
        x[place(column)] -= total
        column += group.team.size()
    group.team.wait()
