"""What a sparse Cholesky factorisation will look like, from the pattern of the matrix alone.

The pattern is a graph of blocks in the order of elimination: neighbours of i are
indices[starts[i] : starts[i + 1]], without i itself.

Source: J. W. H. Liu, The role of elimination trees in sparse factorization (1990), sections
2.2, 4.2 and 5.1; The multifrontal method for sparse matrix solution: theory and practice
(1992), section 6 for supernodes.
"""

import numpy as np

from izo_ref.base.compile import compiled

# Supernodes are joined if of the factor's blocks in the two at most this part is zero; small
# ones always, whose dense work costs less than their bookkeeping.
ZEROS = 0.1
SMALL = 4


@compiled
def graph_of(entries, n):
    """The pattern as a graph, (starts, indices).

    Args:
        entries: (n_entries, 2) ints, rows and columns; of (i, j) and (j, i) one is there.
        n: blocks.
    """
    starts = np.zeros(n + 1, np.int64)
    for e in range(entries.shape[0]):
        if entries[e, 0] != entries[e, 1]:
            starts[entries[e, 0]] += 1
            starts[entries[e, 1]] += 1
    total = 0
    for i in range(n + 1):
        total += starts[i]
        starts[i] = total  # where the list of i ends; filled from there down
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
def elimination_tree(starts, indices):
    """(n,) i4, the parent of each block; -1 for a root."""
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
def postorder(parent):
    """(n,) i4, the blocks in an order in which each follows all below it, at once."""
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
def factor_structure(starts, indices, parent):
    """Rows below the diagonal of each column of the factor, ascending, as (starts, rows)."""
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
def supernodes(parent, counts):
    """First block of each supernode, and the end: columns that share their rows, or nearly.

    Args:
        counts: (n,) i8, rows below the diagonal of each column.
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
def relative_rows(firsts, starts, rows, node_of, above_out, place_out, place_starts):
    """Where the rows of each supernode are in the front of the one above it.

    A front has the supernode's own blocks first, then its rows, those of its last column.
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
def place_in_front(i, j, firsts, starts, rows, node_of):
    """(supernode, row, column) of the entry (i, j), i <= j, in blocks of its front."""
    s = node_of[i]
    if j < firsts[s + 1]:
        return s, i - firsts[s], j - firsts[s]
    low, high = starts[firsts[s + 1] - 1], starts[firsts[s + 1]]
    begin = low
    while low < high:
        middle = (low + high) // 2
        if rows[middle] < j:
            low = middle + 1
        else:
            high = middle
    return s, i - firsts[s], firsts[s + 1] - firsts[s] + low - begin


@compiled
def places_of_entries(entries, firsts, starts, rows, node_of, places_out):
    for e in range(entries.shape[0]):
        s, row, column = place_in_front(entries[e, 0], entries[e, 1], firsts, starts, rows, node_of)
        places_out[e, 0], places_out[e, 1], places_out[e, 2] = s, row, column
