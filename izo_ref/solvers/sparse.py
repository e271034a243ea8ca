"""Factorisations of a sparse matrix of symmetric blocks, again and again with new values."""

import numba
import numpy as np

from izo_ref.base.ranges import ranges
from izo_ref.solvers.cpu import sparse as kernels
from izo_ref.solvers.serial import elimination
from izo_ref.solvers.serial.fronts import Fronts
from izo_ref.solvers.serial.minimum_degree import minimum_degree

# Operations from which a second thread pays; waking it takes some 10 us.
PARALLEL = 2e6


class SparseCholesky:
    """Cholesky factors of matrices of one pattern.

    Args:
        entries: (n_entries, 2) ints, the block row and column of each value; of (i, j) and
            (j, i) one is there and stands for both, and every (i, i) has to be there.
        n_blocks: rows of the matrix, in blocks.
        size: of a block.

    The order of elimination is that of minimum degree, see solvers/serial/minimum_degree.py.
    """

    def __init__(self, entries, n_blocks, size):
        self._order = _order_of(entries, n_blocks)
        position = np.empty(n_blocks, np.int32)
        position[self._order] = np.arange(n_blocks, dtype=np.int32)
        threads = numba.get_num_threads()
        pattern = np.sort(position[entries], axis=1)
        self._fronts, self._run_starts, self._runs = _fronts_of(pattern, n_blocks, size, threads)
        self._factor = np.empty(self._fronts.factor_starts[-1])
        self._kept = np.empty(self._fronts.n_kept)
        self._rests = np.empty(size * self._fronts.starts[-1])

    @property
    def flops(self) -> float:
        """Multiplications and additions of one factorisation."""
        f = self._fronts
        return float(_work(f.size * np.diff(f.firsts), f.size * np.diff(f.starts)).sum())

    def factorize(self, values, smallest=0.0):
        """Factor the matrix with these values, (n_entries, size, size) f8, or (n_entries,).

        Pivots of `smallest` or less are left out: solutions are 0 there.
        """
        blocks = values.reshape(len(values), self._fronts.size, self._fronts.size)
        kernel = kernels.factorize if len(self._run_starts) > 2 else kernels.factorize.alone
        shape = self._fronts, self._run_starts, self._runs
        kernel(*shape, blocks, smallest, self._kept, self._factor)

    def solve(self, right):
        """(n,) f8, the solution for one right-hand side."""
        size = self._fronts.size
        x = right.reshape(-1, size)[self._order].ravel()
        shape = self._fronts, self._run_starts, self._runs
        kernel = kernels.solve if len(self._run_starts) > 2 else kernels.solve.alone
        kernel(*shape, self._factor, x, self._rests)
        solution = np.empty((len(self._order), size))
        solution[self._order] = x.reshape(-1, size)
        return solution.ravel()


def _order_of(entries, n):
    """(n,) i4, the block to eliminate first, second, ..."""
    order = minimum_degree(*elimination.graph_of(entries, n))
    # the same order again, but for a parent that follows all of its children at once
    position = np.argsort(order)
    parent = elimination.elimination_tree(*elimination.graph_of(position[entries], n))
    return order[elimination.postorder(parent)]


def _fronts_of(entries, n, size, threads):
    """`Fronts` of a pattern in the order of elimination, and runs; i <= j in each entry."""
    graph = elimination.graph_of(entries, n)
    parent = elimination.elimination_tree(*graph)
    column_starts, column_rows = elimination.factor_structure(*graph, parent)
    firsts = elimination.supernodes(parent, np.diff(column_starts))
    own = np.diff(firsts)
    node_of = np.repeat(np.arange(len(own), dtype=np.int32), own)
    last = firsts[1:] - 1
    counts = np.diff(column_starts)[last]
    starts = np.concatenate(([0], np.cumsum(counts)))
    index = ranges(column_starts[last], counts)
    above, places = np.empty(len(own), np.int32), np.empty(starts[-1], np.int32)
    elimination.relative_rows(
        firsts, column_starts, column_rows, node_of, above, places, starts[:-1]
    )
    found = np.empty((len(entries), 3), np.int32)
    elimination.places_of_entries(entries, firsts, column_starts, column_rows, node_of, found)
    by_front = np.argsort(found[:, 0], kind="stable")
    entry_starts = np.searchsorted(found[by_front, 0], np.arange(len(own) + 1))
    rows_of_front = size * (own + counts)
    work = _work(size * own, size * counts)
    run_starts, runs, roots = _runs_of(above, work, threads if work.sum() > PARALLEL else 1)
    left = (size * counts) ** 2
    kept = np.full(len(own), -1)
    kept[roots] = np.cumsum(left[roots]) - left[roots]
    children = np.argsort(above, kind="stable")[np.count_nonzero(above < 0) :]
    shape = Fronts(
        size,
        firsts,
        above,
        starts,
        column_rows[index],
        places,
        np.concatenate(([0], np.cumsum(size * own * rows_of_front))),
        entry_starts,
        np.column_stack((by_front, found[by_front, 1:])).astype(np.int32),
        np.searchsorted(above[children], np.arange(len(own) + 1)),
        children.astype(np.int32),
        kept,
        int(left[roots].sum()),
        int(rows_of_front.max(initial=0)),
        _deepest(above, left),
    )
    return shape, run_starts, runs


def _work(pivots, rows):
    """Operations of fronts: those of the whole less those of what is left."""
    return ((pivots + rows).astype(float) ** 3 - rows.astype(float) ** 3) / 3.0


def _runs_of(above, work, threads):
    """Fronts by the thread that takes them, and last those that wait for all others.

    Returns:
        (n_runs + 1,) i8 starts, (n_fronts,) i4 fronts, and the roots of the subtrees.
    """
    n = len(above)
    if threads == 1:
        return np.array([0, n]), np.arange(n, dtype=np.int32), np.empty(0, np.int64)
    whole, first = work.copy(), np.arange(n)
    for s in range(n):  # of the subtree: its work, and its first front
        if above[s] >= 0:
            whole[above[s]] += whole[s]
            first[above[s]] = min(first[above[s]], first[s])
    # the largest that do not leave a thread idle: what waits for all others is one thread's
    heavy = whole > work.sum() / threads
    roots = np.flatnonzero(~heavy & np.where(above >= 0, heavy[above], True))
    loads, thread_of = np.zeros(threads), np.full(n, threads)
    for root in roots[np.argsort(-whole[roots], kind="stable")]:
        thread = int(np.argmin(loads))
        loads[thread] += whole[root]
        thread_of[first[root] : root + 1] = thread
    starts = np.searchsorted(np.sort(thread_of), np.arange(threads + 2))
    return starts, np.argsort(thread_of, kind="stable").astype(np.int32), roots


def _deepest(above, left):
    """The most numbers that wait on the stack at a time."""
    taken = np.zeros(len(above))  # by each front, from those below it
    np.add.at(taken, above[above >= 0], left[above >= 0])
    return int((left - taken).cumsum().max(initial=0))
