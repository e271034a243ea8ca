"""Cholesky factors of a dense symmetric matrix, computed by a thread group.

A = L L^T, and L takes the place of A. The lower triangle is packed row by row: entry (i, j), with
j <= i, is at i (i + 1) / 2 + j. So row i is contiguous, and L needs half of the memory of a square.

Each thread owns every row whose number is its rank plus a multiple of the group's size. In step k
it computes entry (i, k) of its rows i > k from the rows i and k, and takes the square of the entry
off its diagonal. So the pivot of step k + 1 is complete when the threads have waited once, and one
wait for each column is enough.

Loops over the rows of a thread are written with `while`: `range` with a step that is known when
the kernel runs alone takes a division for each column.

Source: N. J. Higham, Accuracy and Stability of Numerical Algorithms (2002), chapter 10.
"""

import math

from izo_ref.base.arrays import AnyInt, Floats
from izo_ref.base.compile import compiled, inlined
from izo_ref.base.serial.thread_group import ThreadGroup
from izo_ref.base.serial.views import FOUR, ONE, THREE, TWO, place


@inlined
def packed_size(n: AnyInt) -> int:
    """Return how many numbers the lower triangle of n rows has, which is where row n begins."""
    return (n * (n + 1)) >> 1


@compiled
def factorize(group: ThreadGroup, a: Floats, n: AnyInt, scales_out: Floats) -> None:
    """Factor a matrix; all threads have to see it before.

    A pivot that is not positive makes its column zero, and solves set its unknown to 0.

    Args:
        group: The threads.
        a: (>= n (n + 1) / 2,) f8, the packed matrix, which becomes L below the diagonal. Its
            diagonal becomes that of the pivots, the squares of the diagonal of L.
        n: Number of rows.
        scales_out: (>= n,) f8, the reciprocals of the diagonal of L.
    """
    size, begin = group.size(), group.rank()
    for k in range(n):
        at = packed_size(k)
        pivot = a[place(at + k)]
        scale = 1.0 / math.sqrt(pivot) if pivot > 0.0 else 0.0
        if begin == k:  # from here on, the rows of this thread begin below row k
            scales_out[place(k)] = scale
            begin += size
        i = begin
        while i < n:
            start = packed_size(i)
            value = scale * (a[place(start + k)] - _dot(a, at, start, k))
            a[place(start + k)] = value
            a[place(start + i)] -= value * value
            i += size
        group.wait()


@compiled
def _dot(a: Floats, x: AnyInt, y: AnyInt, n: AnyInt) -> float:
    """Return the scalar product of n numbers from x on and from y on, by four sums side by side.

    Each sum waits for its own last product alone.
    """
    p, q, r, s, i, j = 0.0, 0.0, 0.0, 0.0, place(x), place(y)
    for _ in range(n >> 2):
        p += a[i] * a[j]
        q += a[i + ONE] * a[j + ONE]
        r += a[i + TWO] * a[j + TWO]
        s += a[i + THREE] * a[j + THREE]
        i, j = i + FOUR, j + FOUR
    for _ in range(n & 3):
        p += a[i] * a[j]
        i, j = i + ONE, j + ONE
    return (p + q) + (r + s)


@compiled
def solve(
    group: ThreadGroup, a: Floats, n: AnyInt, scales: Floats, x: Floats, work: Floats
) -> None:
    """Solve L L^T x' = x in place; all threads have to see x before.

    Args:
        group: The threads.
        a: L, as `factorize` left it.
        n: Number of rows.
        scales: (>= n,) f8, what `factorize` wrote.
        x: (>= n,) f8.
        work: (>= n,) f8, work space.
    """
    size, rank = group.size(), group.rank()
    begin = rank
    for k in range(n):
        value = x[place(k)] * scales[place(k)]
        if begin == k:
            work[place(k)] = value
            begin += size
        i = begin
        while i < n:
            x[place(i)] -= value * a[place(packed_size(i) + k)]
            i += size
        group.wait()
    for k in range(n - 1, -1, -1):
        value, at = work[place(k)] * scales[place(k)], packed_size(k)
        if rank == 0:
            x[place(k)] = value
        i = rank
        while i < k:
            work[place(i)] -= value * a[place(at + i)]
            i += size
        group.wait()
