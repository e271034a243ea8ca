"""An order of elimination with little fill: approximate minimum degree.

Cholesky factors of a sparse matrix have entries where the matrix has none (fill). How many there
are depends on the order in which the unknowns are eliminated. The method next eliminates the vertex
with the smallest upper bound of its degree; this vertex is the pivot. Four devices make it fast
(`solvers/serial/quotient_graph.py`):

    elements            lists of neighbours stand for the edges that eliminations add
    absorption          an element is forgotten if another element contains its whole list
    mass elimination    vertices whose other neighbours are all neighbours of the pivot are
                        eliminated with the pivot
    indistinguishable   vertices with the same neighbours go on as one vertex

Source: P. R. Amestoy, T. A. Davis, I. S. Duff, An approximate minimum degree ordering algorithm
(1996), with its element absorption, mass elimination and bound of the degree.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyInt, AnyInts, Indices, Ints
from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.quotient_graph import (
    NONE,
    DegreeQueue,
    Graph,
    eliminate,
    insert,
    measure_overlaps,
    remove,
    with_room,
)


class _Members(NamedTuple):
    """The vertices that a vertex stands for, as a list that begins with the vertex itself."""

    last: Indices  # (n,) i8
    following: Indices  # (n,) i8


class _Buckets(NamedTuple):
    """Vertices by a hash of their lists."""

    head: Indices  # (n,) i8, the first vertex of each bucket
    following: Indices  # (n,) i8
    of: Indices  # (n,) i8, the bucket of a vertex


@compiled
def minimum_degree(starts: AnyInts, indices: Ints) -> Ints:
    """Compute an order of elimination.

    Args:
        starts: (n + 1,) whole numbers, where the neighbours of each vertex begin.
        indices: (n_neighbours,) i4; the neighbours of i are indices[starts[i] : starts[i + 1]],
            without i. Each edge is there twice.

    Returns:
        (n,) i4, the vertex to eliminate first, second, ...
    """
    n = starts.shape[0] - 1
    degrees = (starts[1:] - starts[:n]).astype(np.int32)
    graph = Graph(
        starts[:n].astype(np.int64),
        np.zeros(n, np.int32),
        degrees.copy(),
        np.ones(n, np.int32),
        degrees,
        np.zeros(n, np.bool_),
        np.zeros(n, np.int64),
    )
    lists, end = np.concatenate((indices, np.empty_like(indices))), indices.shape[0]
    queue = DegreeQueue(np.full(n + 1, NONE), np.full(n, NONE), np.full(n, NONE))
    buckets = _Buckets(np.full(n, NONE), np.full(n, NONE), np.empty(n, np.int64))
    members = _Members(np.arange(n), np.full(n, NONE))
    for i in range(n - 1, -1, -1):
        insert(queue, i, graph.degree[i])
    marks, order = np.full(n, NONE), np.empty(n, np.int32)
    done, lowest = 0, 0
    mark = np.int64(1)  # with a plain 1, numba compiles the callees for the literal 1 too
    while done < n:
        while queue.head[lowest] == NONE:
            lowest += 1
        pivot = queue.head[lowest]
        remove(queue, pivot, lowest)
        lists = with_room(graph, pivot, lists, end)
        end = eliminate(graph, queue, pivot, lists, end)
        measure_overlaps(graph, pivot, lists, mark)
        _absorb(graph, members, buckets, pivot, lists, mark)
        mark += n + 1  # more than any weight, so that old values of `seen` are below the mark
        _unite(graph, members, buckets, pivot, lists, marks)
        i = pivot
        while i != NONE:
            order[done] = i
            done += 1
            i = members.following[i]
        end, lowest_there = _finish(graph, queue, pivot, lists, n - done)
        lowest = min(lowest, lowest_there)
    return order


@compiled
def _prune(
    graph: Graph, i: AnyInt, pivot: AnyInt, lists: Ints, mark: AnyInt
) -> tuple[AnyInt, AnyInt]:
    """Remove from the list of a vertex what the pivot's element contains already.

    Returns:
        A bound of the weight of its neighbours besides those in the element, and a hash of the
        list.
    """
    begin, besides, total = graph.begin[i], 0, np.int64(pivot)
    middle, end = begin + graph.n_elements[i], begin + graph.length[i]
    kept = begin
    for p in range(begin, middle):
        element: AnyInt = lists[p]
        if graph.dead[element]:
            continue
        more = graph.seen[element] - mark
        if more == 0:
            graph.dead[element] = True  # the pivot's element contains all of it
            continue
        besides += more
        total += element
        lists[kept] = element
        kept += 1
    last = kept
    for p in range(middle, end):
        j: AnyInt = lists[p]
        if graph.weight[j] > 0 and j != pivot:
            besides += graph.weight[j]
            total += j
            lists[last] = j
            last += 1
    # the pivot becomes the first element; it, or an element that it absorbed, has left a place
    lists[last] = lists[kept]
    lists[kept] = lists[begin]
    lists[begin] = pivot
    graph.n_elements[i] = kept + 1 - begin
    graph.length[i] = last + 1 - begin
    return besides, total


@compiled
def _join(graph: Graph, members: _Members, i: AnyInt, into: AnyInt) -> None:
    """Let vertex i go on as a member of another."""
    graph.weight[into] += graph.weight[i]
    graph.weight[i] = 0
    members.following[members.last[into]] = i
    members.last[into] = members.last[i]


@compiled
def _absorb(
    graph: Graph, members: _Members, buckets: _Buckets, pivot: AnyInt, lists: Ints, mark: AnyInt
) -> None:
    """Prune the vertices of the pivot's element, and put each into a bucket.

    Vertices that have no neighbours outside the element join the pivot.
    """
    begin, end = graph.begin[pivot], graph.begin[pivot] + graph.length[pivot]
    for p in range(begin, end):
        i: AnyInt = lists[p]
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
def _has_all_neighbours(graph: Graph, lists: Ints, i: AnyInt, marks: Indices, mark: AnyInt) -> bool:
    """Return whether everything in the list of a vertex has this mark."""
    for p in range(graph.begin[i], graph.begin[i] + graph.length[i]):
        if marks[lists[p]] != mark:
            return False
    return True


@compiled
def _unite(
    graph: Graph, members: _Members, buckets: _Buckets, pivot: AnyInt, lists: Ints, marks: Indices
) -> None:
    """Join vertices of the pivot's element with the same neighbours, and empty the buckets."""
    for p in range(graph.begin[pivot], graph.begin[pivot] + graph.length[pivot]):
        vertex: AnyInt = lists[p]
        if graph.weight[vertex] == 0:
            continue
        bucket: AnyInt = buckets.of[vertex]
        i: AnyInt = buckets.head[bucket]
        buckets.head[bucket] = NONE
        while i != NONE and buckets.following[i] != NONE:
            for q in range(graph.begin[i], graph.begin[i] + graph.length[i]):
                marks[lists[q]] = i
            before: AnyInt = i
            j: AnyInt = buckets.following[i]
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
def _finish(
    graph: Graph, queue: DegreeQueue, pivot: AnyInt, lists: Ints, left: AnyInt
) -> tuple[AnyInt, AnyInt]:
    """Keep what is left of the pivot's element, and put its vertices back into the queue.

    `left` is the number of vertices that are not eliminated.

    Returns:
        Where the element's list ends, and the lowest degree of its vertices, at most `left`.
    """
    kept, lowest = graph.begin[pivot], left
    for p in range(graph.begin[pivot], graph.begin[pivot] + graph.length[pivot]):
        i: AnyInt = lists[p]
        if graph.weight[i] == 0:
            continue
        graph.weight[i] = -graph.weight[i]
        others = graph.degree[pivot] - graph.weight[i]
        graph.degree[i] = min(graph.degree[i] + others, left - graph.weight[i])
        lowest = min(lowest, graph.degree[i])
        insert(queue, i, graph.degree[i])
        lists[kept] = i
        kept += 1
    graph.length[pivot] = kept - graph.begin[pivot]
    return kept, lowest
