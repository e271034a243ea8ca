"""An order of elimination with little fill: approximate minimum degree.

The graph is that of a symmetric matrix. Eliminating a vertex joins all its neighbours; instead
of the edges between them an *element* is kept, the list of these neighbours, which takes in
the elements that the vertex was part of. Vertices that have become indistinguishable go on as
one, of their number as weight.

Source: P. R. Amestoy, T. A. Davis, I. S. Duff, An approximate minimum degree ordering
algorithm (1996), with its element absorption, mass elimination and bound of the degree.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.compile import compiled

NONE = -1


class _Graph(NamedTuple):
    """The graph as it is being eliminated; a number is a vertex, or the element it became."""

    begin: np.ndarray  # (n,) i8, into lists: of a vertex its elements, then its vertices
    n_elements: np.ndarray  # (n,) i4
    length: np.ndarray  # (n,) i4, of the list
    weight: np.ndarray  # (n,) i4, vertices that it stands for; 0: it went into another;
    # negative while it is in the element that is being made
    degree: np.ndarray  # (n,) i4, bound of that of a vertex; weight of an element's list
    dead: np.ndarray  # (n,) b1, elements that went into others
    seen: np.ndarray  # (n,) i8, mark of the elements looked at


class _Queue(NamedTuple):
    """Vertices by degree, in lists that are linked both ways."""

    head: np.ndarray  # (n + 1,) i8
    following: np.ndarray  # (n,) i8
    previous: np.ndarray  # (n,) i8


class _Members(NamedTuple):
    """The vertices that a vertex stands for, as a list that begins with itself."""

    last: np.ndarray  # (n,) i8
    following: np.ndarray  # (n,) i8


class _Buckets(NamedTuple):
    """Vertices by a hash of their lists."""

    head: np.ndarray  # (n,) i8
    following: np.ndarray  # (n,) i8
    of: np.ndarray  # (n,) i8, the bucket of a vertex


@compiled
def _insert(queue, i, degree):
    first = queue.head[degree]
    queue.following[i], queue.previous[i] = first, NONE
    if first != NONE:
        queue.previous[first] = i
    queue.head[degree] = i


@compiled
def _remove(queue, i, degree):
    before, after = queue.previous[i], queue.following[i]
    if after != NONE:
        queue.previous[after] = before
    if before != NONE:
        queue.following[before] = after
    else:
        queue.head[degree] = after


@compiled
def _take(graph, queue, i, lists, end):
    """Put a vertex into the element that ends at `end`, once; returns the new end."""
    if graph.weight[i] > 0:
        _remove(queue, i, graph.degree[i])
        graph.weight[i] = -graph.weight[i]
        lists[end] = i
        end += 1
    return end


@compiled
def _eliminate(graph, queue, pivot, lists, end):
    """Make the pivot an element, its list from `end` on; returns where that ends."""
    begin, own = graph.begin[pivot], graph.weight[pivot]
    graph.weight[pivot] = 0  # not part of its own list
    start = end
    for p in range(begin, begin + graph.n_elements[pivot]):
        element = lists[p]
        if graph.dead[element]:
            continue
        graph.dead[element] = True
        first = graph.begin[element]
        for q in range(first, first + graph.length[element]):
            end = _take(graph, queue, lists[q], lists, end)
    for p in range(begin + graph.n_elements[pivot], begin + graph.length[pivot]):
        end = _take(graph, queue, lists[p], lists, end)
    graph.weight[pivot] = own
    graph.begin[pivot], graph.length[pivot] = start, end - start
    total = 0
    for p in range(start, end):
        total -= graph.weight[lists[p]]
    graph.degree[pivot] = total
    return end


@compiled
def _overlaps(graph, pivot, lists, mark):
    """seen[e] - mark = weight of what element e has besides the pivot's list."""
    for p in range(graph.begin[pivot], graph.begin[pivot] + graph.length[pivot]):
        i = lists[p]
        for q in range(graph.begin[i], graph.begin[i] + graph.n_elements[i]):
            element = lists[q]
            if graph.dead[element]:
                continue
            if graph.seen[element] < mark:
                graph.seen[element] = mark + graph.degree[element]
            graph.seen[element] += graph.weight[i]  # negative


@compiled
def _prune(graph, i, pivot, lists, mark):
    """Take out of a vertex's list what the pivot's element says.

    Returns:
        Weight of its neighbours besides those in the element, at most, and a hash of the list.
    """
    begin, besides, total = graph.begin[i], 0, np.int64(pivot)
    middle, end = begin + graph.n_elements[i], begin + graph.length[i]
    kept = begin
    for p in range(begin, middle):
        element = lists[p]
        if graph.dead[element]:
            continue
        more = graph.seen[element] - mark
        if more == 0:
            graph.dead[element] = True  # all of it is in the pivot's element
            continue
        besides += more
        total += element
        lists[kept] = element
        kept += 1
    last = kept
    for p in range(middle, end):
        j = lists[p]
        if graph.weight[j] > 0 and j != pivot:
            besides += graph.weight[j]
            total += j
            lists[last] = j
            last += 1
    # the pivot, or an element it took in, has left a place: the pivot is the first element
    lists[last] = lists[kept]
    lists[kept] = lists[begin]
    lists[begin] = pivot
    graph.n_elements[i] = kept + 1 - begin
    graph.length[i] = last + 1 - begin
    return besides, total


@compiled
def _join(graph, members, i, into):
    """Vertex i goes on as part of another."""
    graph.weight[into] += graph.weight[i]
    graph.weight[i] = 0
    members.following[members.last[into]] = i
    members.last[into] = members.last[i]


@compiled
def _absorb(graph, members, buckets, pivot, lists, mark):
    """Prune the vertices of the pivot's element; those with no other neighbours join it."""
    begin, end = graph.begin[pivot], graph.begin[pivot] + graph.length[pivot]
    for p in range(begin, end):
        i = lists[p]
        besides, total = _prune(graph, i, pivot, lists, mark)
        if besides == 0:
            graph.degree[pivot] += graph.weight[i]
            graph.weight[i] = -graph.weight[i]
            _join(graph, members, i, pivot)
            continue
        graph.degree[i] = min(graph.degree[i], besides)
        bucket = total % buckets.head.shape[0]
        buckets.of[i] = bucket
        buckets.following[i] = buckets.head[bucket]
        buckets.head[bucket] = i


@compiled
def _has_all_neighbours(graph, lists, i, marks, mark):
    for p in range(graph.begin[i], graph.begin[i] + graph.length[i]):
        if marks[lists[p]] != mark:
            return False
    return True


@compiled
def _unite(graph, members, buckets, pivot, lists, marks):
    """Join vertices of the pivot's element with the same neighbours; empties the buckets."""
    for p in range(graph.begin[pivot], graph.begin[pivot] + graph.length[pivot]):
        if graph.weight[lists[p]] == 0:
            continue
        i = buckets.head[buckets.of[lists[p]]]
        buckets.head[buckets.of[lists[p]]] = NONE
        while i != NONE and buckets.following[i] != NONE:
            for q in range(graph.begin[i], graph.begin[i] + graph.length[i]):
                marks[lists[q]] = i
            before, j = i, buckets.following[i]
            while j != NONE:
                same_length = graph.length[j] == graph.length[i]
                if same_length and _has_all_neighbours(graph, lists, j, marks, i):
                    _join(graph, members, j, i)
                    buckets.following[before] = buckets.following[j]
                else:
                    before = j
                j = buckets.following[j]
            i = buckets.following[i]


@compiled
def _finish(graph, queue, pivot, lists, left):
    """Keep what is left of the pivot's element, and put its vertices back into the queue.

    Returns:
        Where the list ends, and the lowest degree.
    """
    kept, lowest = graph.begin[pivot], left
    for p in range(graph.begin[pivot], graph.begin[pivot] + graph.length[pivot]):
        i = lists[p]
        if graph.weight[i] == 0:
            continue
        graph.weight[i] = -graph.weight[i]
        others = graph.degree[pivot] - graph.weight[i]
        graph.degree[i] = min(graph.degree[i] + others, left - graph.weight[i])
        lowest = min(lowest, graph.degree[i])
        _insert(queue, i, graph.degree[i])
        lists[kept] = i
        kept += 1
    graph.length[pivot] = kept - graph.begin[pivot]
    return kept, lowest


@compiled
def _with_room(graph, pivot, lists, end):
    """The lists, with room for those of the pivot's element."""
    begin = graph.begin[pivot]
    most = graph.length[pivot]
    for p in range(begin, begin + graph.n_elements[pivot]):
        most += graph.length[lists[p]]
    if end + most <= lists.shape[0]:
        return lists
    return np.concatenate((lists, np.empty(lists.shape[0] + most, lists.dtype)))


@compiled
def minimum_degree(starts, indices):
    """An order of elimination.

    Args:
        starts, indices: of the graph; neighbours of i are indices[starts[i] : starts[i + 1]],
            without i, and each edge is there twice.

    Returns:
        (n,) i4, the vertex to eliminate first, second, ...
    """
    n = starts.shape[0] - 1
    degrees = (starts[1:] - starts[:n]).astype(np.int32)
    graph = _Graph(
        starts[:n].astype(np.int64),
        np.zeros(n, np.int32),
        degrees.copy(),
        np.ones(n, np.int32),
        degrees,
        np.zeros(n, np.bool_),
        np.zeros(n, np.int64),
    )
    lists, end = np.concatenate((indices, np.empty_like(indices))), indices.shape[0]
    queue = _Queue(np.full(n + 1, NONE), np.full(n, NONE), np.full(n, NONE))
    buckets = _Buckets(np.full(n, NONE), np.full(n, NONE), np.empty(n, np.int64))
    members = _Members(np.arange(n), np.full(n, NONE))
    for i in range(n - 1, -1, -1):
        _insert(queue, i, graph.degree[i])
    marks, order = np.full(n, NONE), np.empty(n, np.int32)
    done, lowest = 0, 0
    mark = np.int64(1)  # with a plain 1, numba compiles the callees for the literal 1 too
    while done < n:
        while queue.head[lowest] == NONE:
            lowest += 1
        pivot = queue.head[lowest]
        _remove(queue, pivot, lowest)
        lists = _with_room(graph, pivot, lists, end)
        end = _eliminate(graph, queue, pivot, lists, end)
        _overlaps(graph, pivot, lists, mark)
        _absorb(graph, members, buckets, pivot, lists, mark)
        mark += n + 1  # more than any weight
        _unite(graph, members, buckets, pivot, lists, marks)
        i = pivot
        while i != NONE:
            order[done] = i
            done += 1
            i = members.following[i]
        end, lowest_there = _finish(graph, queue, pivot, lists, n - done)
        lowest = min(lowest, lowest_there)
    return order
