"""Cholesky factorisations of sparse matrices of symmetric blocks that share one pattern.

`SparseCholesky` analyses the pattern once. After that it factors the matrix again and again with
new values.
"""

from typing import NamedTuple

import numba
import numpy as np

from izo_ref.base.arrays import AnyInts, Flags, Floats, Indices, Ints, Offsets
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.ranges import ranges
from izo_ref.solvers.cpu import sparse as kernels
from izo_ref.solvers.serial import elimination
from izo_ref.solvers.serial.fronts import Fronts
from izo_ref.solvers.serial.minimum_degree import minimum_degree
from izo_ref.solvers.serial.restriction import Supernodes, restrict

# Floating-point operations from which on a second thread pays off. Waking it takes some 10 us.
PARALLEL = 2e6


class SparseCholesky:
    """Cholesky factors of matrices that share one pattern.

    The order of elimination is that of minimum degree, see `solvers/serial/minimum_degree.py`.

    Args:
        entries: (n_entries, 2) ints, the block row and block column of each value. One of (i, j)
            and (j, i) stands for both. Every (i, i) has to be there.
        n_blocks: Rows of the matrix, in blocks.
        size: Rows of a block.
        deadline: When factorisations have to end.
    """

    def __init__(
        self, entries: AnyInts, n_blocks: int, size: int, deadline: Deadline = UNLIMITED
    ) -> None:
        """Choose the order of elimination and lay out the factor."""
        self._deadline = deadline
        self._order = self._whole_order = _order_of(entries, n_blocks)
        deadline.check()
        rows, columns = _places(self._order)[entries.T]
        pattern = np.column_stack((np.minimum(rows, columns), np.maximum(rows, columns)))
        self._supernodes = _supernodes_of(pattern, n_blocks)
        # A restriction keeps the division: its fronts are the same ones, with fewer rows.
        self._division = _divide(self._supernodes, size, numba.get_num_threads())
        last = len(self._division.starts) - 2
        self._first_runs, self._last_run = range(last), range(last, last + 1)
        self._lay_out(self._supernodes, size)

    def restrict(self, chosen: Flags) -> None:
        """From now on, factor the matrix of some rows and columns of the whole matrix.

        Args:
            chosen: (n_blocks,) b1, the rows that stay. Values keep their numbers; those of other
                rows and columns are not read. Right-hand sides and solutions have the chosen rows
                alone.
        """
        in_order = chosen[self._whole_order]
        self._order = (np.cumsum(chosen) - 1)[self._whole_order[in_order]]
        self._lay_out(restrict(self._supernodes, in_order), self._fronts.size)

    def _lay_out(self, supernodes: Supernodes, size: int) -> None:
        """Lay out the factor."""
        self._fronts = _lay_out_fronts(supernodes, size, self._division.roots)
        self._factor = np.empty(self._fronts.factor_starts[-1])
        self._kept = np.empty(self._fronts.n_kept)
        self._rests = np.empty(size * self._fronts.starts[-1])

    @property
    def flops(self) -> float:
        """Return the number of multiplications and additions of one factorisation."""
        f = self._fronts
        return float(_work(f.size * np.diff(f.firsts), f.size * np.diff(f.starts)).sum())

    def factorize(self, values: Floats, smallest: float = 0.0) -> None:
        """Factor the matrix with new values.

        Args:
            values: (n_entries, size, size) f8, or (n_entries,) f8 for blocks of size 1.
            smallest: Pivots of this or less are left out; the solution is 0 there.

        Raises:
            OutOfTimeError: The deadline has passed.
        """
        blocks = values.reshape(len(values), self._fronts.size, self._fronts.size)
        shape = self._fronts, self._division.starts, self._division.runs
        stop = self._deadline.stop
        for runs in self._first_runs, self._last_run:
            kernels.factorize(runs, *shape, blocks, smallest, stop, self._kept, self._factor)
        self._deadline.check()

    def solve(self, right: Floats) -> Floats:
        """Return the solution for one right-hand side, both (n_blocks * size,) f8."""
        size = self._fronts.size
        x = right.reshape(-1, size)[self._order].ravel()
        shape = self._fronts, self._division.starts, self._division.runs
        for runs, upwards in (
            (self._first_runs, True),
            (self._last_run, True),
            (self._last_run, False),
            (self._first_runs, False),
        ):
            kernels.solve(runs, upwards, *shape, self._factor, x, self._rests)
        solution = np.empty((len(self._order), size))
        solution[self._order] = x.reshape(-1, size)
        return solution.ravel()


def _order_of(entries: AnyInts, n: int) -> Ints:
    """Return the order of elimination: (n,) i4, the first block, the second, ..."""
    entries = np.ascontiguousarray(entries, np.int32)  # one type, so that nothing is compiled twice
    order = minimum_degree(*elimination.graph_of(entries, n))
    # Rearrange it so that each parent follows directly after the subtrees of all its children.
    graph = elimination.graph_of(_places(order)[entries], n)
    return order[elimination.postorder(elimination.elimination_tree(*graph))]


def _places(order: Ints) -> Ints:
    """Return the place of each block in an order of elimination, (n,) i4."""
    places = np.empty(len(order), np.int32)
    places[order] = np.arange(len(order), dtype=np.int32)
    return places


def _supernodes_of(entries: Ints, n: int) -> Supernodes:
    """Return the supernodes of a pattern.

    Args:
        entries: (n_entries, 2) i4, block row i and block column j >= i of each value, in the
            order of elimination.
        n: Rows of the matrix, in blocks.
    """
    graph = elimination.graph_of(entries, n)
    parent = elimination.elimination_tree(*graph)
    column_starts, column_rows = elimination.factor_structure(*graph, parent)
    firsts = elimination.supernodes(parent, np.diff(column_starts))
    own = np.diff(firsts)
    node_of = np.repeat(np.arange(len(own), dtype=np.int32), own)
    # a front has the rows below the diagonal of its last column
    last = firsts[1:] - 1
    counts = np.diff(column_starts)[last]
    starts = np.concatenate(([0], np.cumsum(counts)))
    rows = column_rows[ranges(column_starts[last], counts)]
    above, places = np.empty(len(own), np.int32), np.empty(starts[-1], np.int32)
    elimination.relative_rows(
        firsts, column_starts, column_rows, node_of, above, places, starts[:-1]
    )
    by_front = elimination.entries_by_front(entries, firsts, column_starts, column_rows, node_of)
    return Supernodes(firsts, above, starts, rows, places, *by_front)


def _lay_out_fronts(supernodes: Supernodes, size: int, roots: Indices) -> Fronts:
    """Return the fronts of supernodes.

    Args:
        supernodes: The supernodes.
        size: Rows of a block.
        roots: Roots of the subtrees that threads take whole; what they leave is kept for the last
            run.
    """
    firsts, above, starts, rows, places, entry_starts, entries = supernodes
    own, counts = np.diff(firsts), np.diff(starts)
    rows_of_front = size * (own + counts)
    rest_sizes = (size * counts) ** 2
    kept = np.full(len(own), -1)
    kept[roots] = np.cumsum(rest_sizes[roots]) - rest_sizes[roots]
    children = np.argsort(above, kind="stable")[np.count_nonzero(above < 0) :]
    return Fronts(
        size,
        firsts,
        above,
        starts,
        rows,
        places,
        np.concatenate(([0], np.cumsum(size * own * rows_of_front))),
        entry_starts,
        entries,
        np.searchsorted(above[children], np.arange(len(own) + 1)),
        children.astype(np.int32),
        kept,
        int(rest_sizes[roots].sum()),
        int(rows_of_front.max(initial=0)),
        _largest_stack(above, rest_sizes),
    )


def _work(pivots: Indices, rows: Indices) -> Floats:
    """Return the operations of fronts: those of the whole matrix less those of what is left.

    Args:
        pivots: (n_fronts,) ints, rows that are eliminated.
        rows: (n_fronts,) ints, rows that are left.
    """
    return ((pivots + rows).astype(float) ** 3 - rows.astype(float) ** 3) / 3.0


class _Division(NamedTuple):
    """How the fronts are divided among threads: a run each, and a last run that waits for them."""

    starts: Offsets  # (n_runs + 1,) i8, where each run begins
    runs: Ints  # (n_fronts,) i4, the fronts of the runs
    roots: Indices  # i8, roots of the subtrees that threads take whole


def _divide(supernodes: Supernodes, size: int, threads: int) -> _Division:
    """Divide the fronts of supernodes, with blocks of `size` rows, among threads."""
    above = supernodes.above
    work = _work(size * np.diff(supernodes.firsts), size * np.diff(supernodes.starts))
    n = len(above)
    if threads == 1 or work.sum() <= PARALLEL:
        return _Division(np.array([0, n]), np.arange(n, dtype=np.int32), np.empty(0, np.int64))
    whole, first = work.copy(), np.arange(n)  # work and first front of the subtree of each front
    for s in range(n):
        if above[s] >= 0:
            whole[above[s]] += whole[s]
            first[above[s]] = min(first[above[s]], first[s])
    # A thread takes the largest subtrees that leave no thread idle. Fronts that wait for all
    # subtrees run on one thread.
    heavy = whole > work.sum() / threads
    roots = np.flatnonzero(~heavy & np.where(above >= 0, heavy[above], True))
    loads, thread_of = np.zeros(threads), np.full(n, threads)
    for root in roots[np.argsort(-whole[roots], kind="stable")]:
        thread = int(np.argmin(loads))
        loads[thread] += whole[root]
        thread_of[first[root] : root + 1] = thread
    starts = np.searchsorted(np.sort(thread_of), np.arange(threads + 2))
    return _Division(starts, np.argsort(thread_of, kind="stable").astype(np.int32), roots)


def _largest_stack(above: Ints, rest_sizes: Indices) -> int:
    """Return the most numbers that wait on the stack at a time."""
    taken = np.zeros(len(above))  # numbers that each front takes from those below it
    np.add.at(taken, above[above >= 0], rest_sizes[above >= 0])
    return int((rest_sizes - taken).cumsum().max(initial=0))
