"""Multifrontal Cholesky factorisation of a sparse matrix of square blocks.

One supernode after the other, from the leaves of the elimination tree up: its front, a dense
matrix, takes the matrix's own entries and what the fronts below left over; its pivots are
eliminated, the rows go to the factor, and the rest waits on a stack for the front above.

Source: J. W. H. Liu, The multifrontal method for sparse matrix solution: theory and practice
(1992).
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.dense import copy, partial_cholesky, work_of_cholesky


class Fronts(NamedTuple):
    """The shape of a factorisation; all of the order of elimination, in blocks."""

    size: int  # of a block
    firsts: np.ndarray  # (n_fronts + 1,) i4, first pivot of each front
    above: np.ndarray  # (n_fronts,) i4, the front that takes what is left; -1: nothing is
    starts: np.ndarray  # (n_fronts + 1,) i8, into rows and places
    rows: np.ndarray  # i4, rows of each front below its pivots
    places: np.ndarray  # i4, of these rows in the front above
    factor_starts: np.ndarray  # (n_fronts + 1,) i8, into the factor's numbers
    entry_starts: np.ndarray  # (n_fronts + 1,) i8, into entries
    entries: np.ndarray  # (n_entries, 3) i4, the value's number, row and column in the front
    child_starts: np.ndarray  # (n_fronts + 1,) i8, into children
    children: np.ndarray  # i4, fronts whose rest each front takes, ascending
    kept: np.ndarray  # (n_fronts,) i8, where among the numbers kept its rest is; -1: on a stack
    n_kept: int  # numbers kept: what one thread leaves for the last
    largest: int  # rows of the largest front
    deepest: int  # numbers on a stack at most


@compiled
def _add_entries(fronts, values, begin, end, front):
    b = fronts.size
    for e in range(begin, end):
        number, row, column = fronts.entries[e, 0], fronts.entries[e, 1], fronts.entries[e, 2]
        for i in range(b):
            for j in range(b):
                front[b * row + i, b * column + j] += values[number, i, j]


@compiled
def _add(source, target):
    for j in range(target.shape[0]):  # from 0, or it does not vectorise
        target[j] += source[j]


@compiled
def _add_rest(b, places, rest, ends, front):
    """What a front below left over; upper triangles, in runs of places side by side."""
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
def _take_rest(fronts, s, top, stack, kept, ends, front):
    """Add what the children of a front left over; returns the new top of the stack."""
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
def eliminate(fronts, chosen, values, smallest, kept_out, factor_out):
    """Factor some fronts, one after the other.

    Args:
        fronts: `Fronts`.
        chosen: (n,) i4, fronts in ascending order; all below them are among them, or have
            been eliminated before and kept.
        values: (n_values, size, size) f8, blocks of the upper triangle. Blocks off the
            diagonal are taken for symmetric, so that their side does not matter.
        smallest: pivots of this or less are left out, see `partial_cholesky`.
        kept_out: (n_kept,) f8, what fronts above that are not among the chosen will take.
        factor_out: (factor_starts[-1],) f8, for each front the rows of its pivots.
    """
    b = fronts.size
    work, stack = np.empty(fronts.largest**2), np.empty(fronts.deepest)
    top = np.int64(0)  # with a plain 0, numba compiles the callee for the literal 0 too
    ends = np.empty(fronts.largest, np.int64)
    tiles = np.empty(work_of_cholesky(fronts.largest))
    for c in range(chosen.shape[0]):
        s = chosen[c]
        pivots = b * (fronts.firsts[s + 1] - fronts.firsts[s])
        n = pivots + b * (fronts.starts[s + 1] - fronts.starts[s])
        front = work[: n * n].reshape((n, n))
        work[: n * n] = 0.0
        _add_entries(fronts, values, fronts.entry_starts[s], fronts.entry_starts[s + 1], front)
        top = _take_rest(fronts, s, top, stack, kept_out, ends, front)
        partial_cholesky(front, n, pivots, smallest, tiles)
        at = fronts.factor_starts[s]
        factor_out[at : at + pivots * n] = work[: pivots * n]
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
def solve_upwards(fronts, chosen, factor, x, rests):
    """x <- R^-T x for the pivots of some fronts, one after the other.

    Args:
        fronts, chosen: as of `eliminate`.
        factor: (factor_starts[-1],) f8, R.
        x: (n_blocks * size,) f8, in the order of elimination.
        rests: (size * starts[-1],) f8: for each front, what its rows take from those above.
    """
    b = fronts.size
    part = np.empty(fronts.largest)
    for c in range(chosen.shape[0]):
        s = chosen[c]
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
        x[first : first + pivots] = part[:pivots]
        rests[begin:end] = part[pivots:n]


@compiled
def solve_downwards(fronts, chosen, factor, x):
    """x <- R^-1 x for the pivots of some fronts, the last of them first."""
    b = fronts.size
    part = np.empty(fronts.largest)
    for c in range(chosen.shape[0] - 1, -1, -1):
        s = chosen[c]
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
            # four sums: one would wait for each addition
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
        x[first : first + pivots] = part[:pivots]
