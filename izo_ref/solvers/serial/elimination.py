"""The shape of a sparse Cholesky factorisation, from the pattern of the matrix alone.

The matrix consists of square blocks, in the order of elimination. Its pattern is a graph of blocks:
the neighbours of i are indices[starts[i] : starts[i + 1]], without i itself. From it follow

    the elimination tree   the parent of column k is the first row below the diagonal in column k of
                           the factor; a column needs only the columns below it in the tree
    the columns' rows      which blocks of the factor are not zero
    the supernodes         successive columns with the same rows, or nearly, which are eliminated
                           together as one dense front

Source: J. W. H. Liu, The role of elimination trees in sparse factorization (1990), sections 2.2,
4.2 and 5.1; for supernodes, The multifrontal method for sparse matrix solution: theory and practice
(1992), section 6.
"""

import numpy as np

from izo_ref.base.arrays import AnyInts, Indices, Ints, Offsets
from izo_ref.base.compile import compiled

# Two supernodes are joined if at most this fraction of the factor's blocks in them is zero then.
ZEROS = 0.1
# Up to this many columns they are always joined, because their bookkeeping costs more than the
# additional dense work.
SMALL = 4


@compiled
def graph_of(entries: AnyInts, n: int) -> tuple[Offsets, Ints]:
    """Return the pattern as a graph.

    Args:
        entries: (n_entries, 2) whole numbers, row and column of each block; only one of (i, j) and
            (j, i) is there.
        n: Number of blocks in a row.

    Returns:
        (n + 1,) i8 starts, and (n_neighbours,) i4 indices.
    """
    starts = np.zeros(n + 1, np.int64)
    for e in range(entries.shape[0]):
        if entries[e, 0] != entries[e, 1]:
            starts[entries[e, 0]] += 1
            starts[entries[e, 1]] += 1
    total = 0
    for i in range(n + 1):
        total += starts[i]
        starts[i] = total  # where the list of i ends; it is filled from there downwards
    indices = np.empty(total, np.int32)
    for e in range(entries.shape[0]):
        i, j = entries[e, 0], entries[e, 1]
        if i != j:
            starts[i] -= 1
            indices[starts[i]] = j
            starts[j] -= 1
            indices[starts[j]] = i
    return starts, indices


@compiled
def elimination_tree(starts: AnyInts, indices: Ints) -> Ints:
    """Return the parent of each block in the elimination tree, (n,) i4; -1 for a root."""
    n = starts.shape[0] - 1
    parent, ancestor = np.full(n, -1, np.int32), np.full(n, -1, np.int32)
    for i in range(n):
        for p in range(starts[i], starts[i + 1]):
            k = indices[p]
            while 0 <= k < i:
                above = ancestor[k]
                ancestor[k] = i
                if above < 0:
                    parent[k] = i
                k = above if above != i else -1
    return parent


@compiled
def postorder(parent: Ints) -> Ints:
    """Return the blocks in postorder, (n,) i4: each directly follows all blocks below it."""
    n = parent.shape[0]
    head, following = np.full(n, -1, np.int32), np.empty(n, np.int32)
    order, stack = np.empty(n, np.int32), np.empty(n, np.int32)
    for i in range(n - 1, -1, -1):
        if parent[i] >= 0:
            following[i] = head[parent[i]]
            head[parent[i]] = i
    done = 0
    for root in range(n):
        if parent[root] >= 0:
            continue
        top = 0
        stack[0] = root
        while top >= 0:
            child = head[stack[top]]
            if child >= 0:
                head[stack[top]] = following[child]
                top += 1
                stack[top] = child
            else:
                order[done] = stack[top]
                done += 1
                top -= 1
    return order


@compiled
def factor_structure(starts: AnyInts, indices: Ints, parent: Ints) -> tuple[Offsets, Ints]:
    """Return the rows below the diagonal of each column of the factor, ascending.

    Returns:
        (n + 1,) i8, where the rows of each column begin; and the rows, i4.
    """
    n = parent.shape[0]
    counts, mark = np.zeros(n + 1, np.int64), np.full(n, -1, np.int32)
    rows, ends = np.empty(0, np.int32), np.empty(0, np.int64)
    for filling in (False, True):
        mark[:] = -1
        for i in range(n):
            mark[i] = i
            for p in range(starts[i], starts[i + 1]):
                k = indices[p]
                while k < i and mark[k] != i:
                    mark[k] = i
                    if filling:
                        rows[ends[k]] = i
                        ends[k] += 1
                    else:
                        counts[k + 1] += 1
                    k = parent[k]
        if not filling:
            counts = np.cumsum(counts)
            rows, ends = np.empty(counts[n], np.int32), counts[:n].copy()
    return counts, rows


@compiled
def supernodes(parent: Ints, counts: Offsets) -> Ints:
    """Return the first column of each supernode, and n at the end.

    The columns of a supernode have the same rows, or nearly.

    Args:
        parent: (n,) i4, the elimination tree, in postorder.
        counts: (n,) i8, number of rows below the diagonal of each column.
    """
    n = parent.shape[0]
    firsts, zeros = np.empty(n + 1, np.int32), np.empty(n + 1, np.int64)
    k = -1
    for j in range(n):
        k += 1
        firsts[k], zeros[k] = j, 0
        last = j
        while k > 0:
            child_last = firsts[k] - 1
            if not firsts[k] <= parent[child_last] <= last:
                break
            own, child = last + 1 - firsts[k], firsts[k] - firsts[k - 1]
            both, rows = own + child, counts[last]
            more = zeros[k] + zeros[k - 1] + child * (own + rows - counts[child_last])
            whole = both * (both + 1) // 2 + both * rows
            if more > ZEROS * whole and both > SMALL:
                break
            k -= 1
            zeros[k] = more
    firsts[k + 1] = n
    return firsts[: k + 2]


@compiled
def relative_rows(
    firsts: Ints,
    starts: Offsets,
    rows: Ints,
    node_of: Ints,
    above_out: Ints,
    place_out: Ints,
    place_starts: Indices,
) -> None:
    """Find the rows of each supernode in the front of the supernode above it.

    A front holds the supernode's own blocks, then the rows below them. These are the rows of the
    supernode's last column.

    Args:
        firsts: (n_fronts + 1,) i4, the first column of each supernode, and n.
        starts: (n + 1,) i8, where the rows of each column begin.
        rows: i4, the rows of each column.
        node_of: (n,) i4, the supernode of each column.
        above_out: (n_fronts,) i4, the supernode above, or -1 if there is none.
        place_out: i4, the place of each row in the front above, in blocks.
        place_starts: (n_fronts,) i8, where the places of each supernode begin.
    """
    for s in range(firsts.shape[0] - 1):
        last = firsts[s + 1] - 1
        begin, end = starts[last], starts[last + 1]
        if begin == end:
            above_out[s] = -1
            continue
        t = node_of[rows[begin]]
        above_out[s] = t
        own, at = firsts[t + 1] - firsts[t], starts[firsts[t + 1] - 1]
        for p in range(begin, end):
            if rows[p] < firsts[t + 1]:
                place_out[place_starts[s] + p - begin] = rows[p] - firsts[t]
            else:
                while rows[at] != rows[p]:
                    at += 1
                place_out[place_starts[s] + p - begin] = own + at - starts[firsts[t + 1] - 1]


@compiled
def entries_by_front(
    entries: AnyInts, firsts: Ints, starts: Offsets, rows: Ints, node_of: Ints
) -> tuple[Offsets, Ints]:
    """Return the entries of the matrix, front by front, and where they are in their front.

    Args:
        entries: (n_entries, 2) whole numbers i <= j.
        firsts: As in `relative_rows`, and so are starts, rows and node_of.
        starts: (n + 1,) i8.
        rows: i4.
        node_of: (n,) i4.

    Returns:
        (n_fronts + 1,) i8, where the entries of each front begin; and (n_entries, 3) i4: the number
        of the entry, ascending in each front, and its row and column in the front, in blocks.
    """
    n_fronts = firsts.shape[0] - 1
    begins = np.zeros(n_fronts + 1, np.int64)
    for e in range(entries.shape[0]):
        begins[node_of[entries[e, 0]] + 1] += 1
    for s in range(n_fronts):
        begins[s + 1] += begins[s]
    ends, sorted_entries = begins[:n_fronts].copy(), np.empty((entries.shape[0], 3), np.int32)
    for e in range(entries.shape[0]):
        s = node_of[entries[e, 0]]
        sorted_entries[ends[s], 0] = e
        ends[s] += 1
    place = np.empty(node_of.shape[0], np.int32)  # of each block in the present front
    for s in range(n_fronts):
        own = firsts[s + 1] - firsts[s]
        for k in range(own):
            place[firsts[s] + k] = k
        begin = starts[firsts[s + 1] - 1]
        for p in range(begin, starts[firsts[s + 1]]):
            place[rows[p]] = own + p - begin
        for e in range(begins[s], begins[s + 1]):
            i, j = entries[sorted_entries[e, 0]]
            sorted_entries[e, 1], sorted_entries[e, 2] = place[i], place[j]
    return begins, sorted_entries
