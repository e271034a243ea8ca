"""Multifrontal Cholesky factorisation of a sparse symmetric matrix of square blocks.

The supernodes (`solvers/serial/elimination.py`) are factored one after the other, from the leaves
of the elimination tree upwards. Each has a *front*, a small dense matrix of its pivots and of the
rows below them:

    1. The front takes the matrix's own entries, and adds what the fronts below it left over.
    2. Its pivots are eliminated, and their rows go to the factor.
    3. What is left of the front waits on a stack, until the front above takes it.

Source: J. W. H. Liu, The multifrontal method for sparse matrix solution: theory and practice
(1992).
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyInt, Flags, Floats, Indices, Ints, Offsets
from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.dense import copy, stoppable_cholesky, work_of_cholesky


class Fronts(NamedTuple):
    """The shape of a factorisation; blocks and fronts are in the order of elimination."""

    size: int  # rows of a block
    firsts: Ints  # (n_fronts + 1,) i4, first pivot of each front, in blocks
    above: Ints  # (n_fronts,) i4, the front that takes what is left; -1 if nothing is left
    starts: Offsets  # (n_fronts + 1,) i8, where the rows and places of each front begin
    rows: Ints  # i4, rows of each front below its pivots, in blocks
    places: Ints  # i4, the places of these rows in the front above, in blocks
    factor_starts: Offsets  # (n_fronts + 1,) i8, where the factor's numbers of each front begin
    entry_starts: Offsets  # (n_fronts + 1,) i8, where the entries of each front begin
    entries: Ints  # (n_entries, 3) i4, number of the value, and row and column in the front
    child_starts: Offsets  # (n_fronts + 1,) i8, where the children of each front begin
    children: Ints  # i4, fronts whose rest each front takes, ascending
    kept: Offsets  # (n_fronts,) i8, where the rest begins among the kept numbers; -1: on the stack
    n_kept: int  # kept numbers: what the threads leave for the last run
    largest: int  # rows of the largest front, in numbers
    deepest: int  # largest number of numbers on a stack


@compiled
def _add_entries(fronts: Fronts, values: Floats, begin: AnyInt, end: AnyInt, front: Floats) -> None:
    """Add the matrix's entries begin..end to their front."""
    b = fronts.size
    for e in range(begin, end):
        number, row, column = fronts.entries[e, 0], fronts.entries[e, 1], fronts.entries[e, 2]
        for i in range(b):
            for j in range(b):
                front[b * row + i, b * column + j] += values[number, i, j]


@compiled
def _add(source: Floats, target: Floats) -> None:
    """Add the numbers of a vector to one of the same length."""
    for j in range(target.shape[0]):  # from 0: otherwise the compiler does not vectorise it
        target[j] += source[j]


@compiled
def _add_rest(b: int, places: Ints, rest: Floats, ends: Indices, front: Floats) -> None:
    """Add to a front what a front below it left over.

    Both are upper triangles. Places that follow each other directly form a run, which is added in
    one loop. `ends` is work space for the ends of the runs.
    """
    n = places.shape[0]
    for q in range(n - 1, -1, -1):
        goes_on = q + 1 < n and places[q + 1] == places[q] + 1
        ends[q] = ends[q + 1] if goes_on else q + 1
    for p in range(n):
        for i in range(b):
            source, target = rest[b * p + i], front[b * places[p] + i]
            q = p
            while q < n:
                at, width = b * places[q], b * (ends[q] - q)
                _add(source[b * q : b * q + width], target[at : at + width])
                q = ends[q]


@compiled
def _take_rests(
    fronts: Fronts,
    s: AnyInt,
    top: AnyInt,
    stack: Floats,
    kept: Floats,
    ends: Indices,
    front: Floats,
) -> AnyInt:
    """Add to front s what its children left over, and return the new top of the stack."""
    b = fronts.size
    for c in range(fronts.child_starts[s + 1] - 1, fronts.child_starts[s] - 1, -1):
        child = fronts.children[c]
        places = fronts.places[fronts.starts[child] : fronts.starts[child + 1]]
        left = b * places.shape[0]
        at = fronts.kept[child]
        if at >= 0:
            rest = kept[at : at + left * left]
        else:
            top -= left * left
            rest = stack[top : top + left * left]
        _add_rest(b, places, rest.reshape((left, left)), ends, front)
    return top


@compiled
def eliminate(
    fronts: Fronts,
    chosen: Ints,
    values: Floats,
    smallest: float,
    stop: Flags,
    kept_out: Floats,
    factor_out: Floats,
) -> None:
    """Factor some fronts, one after the other.

    Args:
        fronts: The shape of the factorisation.
        chosen: (n,) i4, the fronts, ascending. All fronts below them are among them, or have been
            eliminated before, and their rests were kept.
        values: (n_values, size, size) f8, blocks of the upper triangle. Blocks off the diagonal
            are taken for symmetric, so that it does not matter on which side they are.
        smallest: Pivots of this or less are left out, see `partial_cholesky`.
        stop: (1,) b1; once it is set, the rest is left out, and nothing in the outputs is valid.
        kept_out: (n_kept,) f8, the rests for fronts that are not among the chosen ones.
        factor_out: (factor_starts[-1],) f8, the rows of the pivots of each front.
    """
    b = fronts.size
    work, stack = np.empty(fronts.largest**2), np.empty(fronts.deepest)
    top = np.int64(0)  # with a plain 0, numba compiles the callee for the literal 0 too
    ends = np.empty(fronts.largest, np.int64)
    tiles = np.empty(work_of_cholesky(fronts.largest))
    for c in range(chosen.shape[0]):
        if stop[0]:
            return
        s: AnyInt = chosen[c]
        pivots = b * (fronts.firsts[s + 1] - fronts.firsts[s])
        n = pivots + b * (fronts.starts[s + 1] - fronts.starts[s])
        front = work[: n * n].reshape((n, n))
        work[: n * n] = 0.0
        _add_entries(fronts, values, fronts.entry_starts[s], fronts.entry_starts[s + 1], front)
        top = _take_rests(fronts, s, top, stack, kept_out, ends, front)
        stoppable_cholesky(front, n, pivots, smallest, tiles, stop)
        at = fronts.factor_starts[s]
        copy(work[: pivots * n], factor_out[at : at + pivots * n])
        left = n - pivots
        if fronts.kept[s] >= 0:
            rest = kept_out[fronts.kept[s] : fronts.kept[s] + left * left]
        else:
            rest = stack[top : top + left * left]
            top += left * left
        rest = rest.reshape((left, left))
        for i in range(left):
            copy(front[pivots + i, pivots + i :], rest[i, i:])


@compiled
def solve_upwards(fronts: Fronts, chosen: Ints, factor: Floats, x: Floats, rests: Floats) -> None:
    """Compute x <- R^-T x for the pivots of some fronts, one after the other.

    Args:
        fronts: The shape of the factorisation.
        chosen: (n,) i4, the fronts, as in `eliminate`.
        factor: (factor_starts[-1],) f8, R.
        x: (n_blocks * size,) f8, in the order of elimination.
        rests: (size * starts[-1],) f8, what each front adds to the numbers of x that belong to its
            rows, which are pivots of fronts above.
    """
    b = fronts.size
    part = np.empty(fronts.largest)
    for c in range(chosen.shape[0]):
        s: AnyInt = chosen[c]
        first, pivots = b * fronts.firsts[s], b * (fronts.firsts[s + 1] - fronts.firsts[s])
        begin, end = b * fronts.starts[s], b * fronts.starts[s + 1]
        n = pivots + end - begin
        for k in range(pivots):
            part[k] = x[first + k]
        part[pivots:n] = 0.0
        for e in range(fronts.child_starts[s], fronts.child_starts[s + 1]):
            child = fronts.children[e]
            for p in range(fronts.starts[child], fronts.starts[child + 1]):
                for i in range(b):
                    part[b * fronts.places[p] + i] += rests[b * p + i]
        at = fronts.factor_starts[s]
        for k in range(pivots):
            row = factor[at + k * n : at + (k + 1) * n]
            part[k] *= row[k]
            value = part[k]
            for j in range(k + 1, n):
                part[j] -= value * row[j]
        copy(part[:pivots], x[first : first + pivots])
        copy(part[pivots:n], rests[begin:end])


@compiled
def solve_downwards(fronts: Fronts, chosen: Ints, factor: Floats, x: Floats) -> None:
    """Compute x <- R^-1 x for the pivots of some fronts, the last of them first.

    The arguments are those of `solve_upwards`.
    """
    b = fronts.size
    part = np.empty(fronts.largest)
    for c in range(chosen.shape[0] - 1, -1, -1):
        s: AnyInt = chosen[c]
        first, pivots = b * fronts.firsts[s], b * (fronts.firsts[s + 1] - fronts.firsts[s])
        for k in range(pivots):
            part[k] = x[first + k]
        n = pivots
        for p in range(fronts.starts[s], fronts.starts[s + 1]):
            for i in range(b):
                part[n + i] = x[b * fronts.rows[p] + i]
            n += b
        at = fronts.factor_starts[s]
        for k in range(pivots - 1, -1, -1):
            row = factor[at + k * n : at + (k + 1) * n]
            value = part[k]
            # four sums, because a single one would wait for each addition
            by_1, by_2, by_3 = 0.0, 0.0, 0.0
            whole = k + 1 + (n - k - 1) // 4 * 4
            for j in range(k + 1, whole, 4):
                value -= row[j] * part[j]
                by_1 += row[j + 1] * part[j + 1]
                by_2 += row[j + 2] * part[j + 2]
                by_3 += row[j + 3] * part[j + 3]
            for j in range(whole, n):
                value -= row[j] * part[j]
            part[k] = (value - (by_1 + by_2 + by_3)) * row[k]
        copy(part[:pivots], x[first : first + pivots])
