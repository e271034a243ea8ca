"""A graph from which vertices are eliminated one after the other.

The graph is that of a symmetric matrix. Eliminating a vertex joins all its neighbours to each
other. The edges between them are not stored. Instead, the eliminated vertex becomes an *element*:
the list of these neighbours. The new element absorbs the elements that contained the vertex.

Vertices with the same neighbours go on as one vertex, whose weight is their number.

Source: P. R. Amestoy, T. A. Davis, I. S. Duff, An approximate minimum degree ordering algorithm
(1996).
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyInt, Flags, Indices, Ints
from izo_ref.base.compile import compiled

NONE = -1


class Graph(NamedTuple):
    """The graph; a number is a vertex, or the element that the vertex became.

    The lists of all vertices and elements are in one array `lists`, which may grow.
    """

    begin: Indices  # (n,) i8, where a list begins: a vertex has its elements, then its vertices
    n_elements: Ints  # (n,) i4, how many elements the list of a vertex has
    length: Ints  # (n,) i4, of the list
    weight: Ints  # (n,) i4, how many vertices it stands for; 0: it was joined to another;
    # negative while it is in the element that is being made
    degree: Ints  # (n,) i4, of a vertex a bound of its degree; of an element its list's weight
    dead: Flags  # (n,) b1, whether another element has absorbed an element
    seen: Indices  # (n,) i8, what `measure_overlaps` found for an element


class DegreeQueue(NamedTuple):
    """The vertices by degree, in lists that are linked in both directions."""

    head: Indices  # (n + 1,) i8, the first vertex of each degree
    following: Indices  # (n,) i8
    previous: Indices  # (n,) i8


@compiled
def insert(queue: DegreeQueue, i: AnyInt, degree: AnyInt) -> None:
    """Insert a vertex with this degree."""
    first = queue.head[degree]
    queue.following[i], queue.previous[i] = first, NONE
    if first != NONE:
        queue.previous[first] = i
    queue.head[degree] = i


@compiled
def remove(queue: DegreeQueue, i: AnyInt, degree: AnyInt) -> None:
    """Remove a vertex that was inserted with this degree."""
    before, after = queue.previous[i], queue.following[i]
    if after != NONE:
        queue.previous[after] = before
    if before != NONE:
        queue.following[before] = after
    else:
        queue.head[degree] = after


@compiled
def _take(graph: Graph, queue: DegreeQueue, i: AnyInt, lists: Ints, end: AnyInt) -> AnyInt:
    """Put a vertex once into the element that ends at `end`, and return the new end."""
    if graph.weight[i] > 0:
        remove(queue, i, graph.degree[i])
        graph.weight[i] = -graph.weight[i]
        lists[end] = i
        end += 1
    return end


@compiled
def eliminate(graph: Graph, queue: DegreeQueue, pivot: AnyInt, lists: Ints, end: AnyInt) -> AnyInt:
    """Make the pivot an element, whose list begins at `end`, and return where the list ends."""
    begin, own = graph.begin[pivot], graph.weight[pivot]
    graph.weight[pivot] = 0  # so that it is not put into its own list
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
def measure_overlaps(graph: Graph, pivot: AnyInt, lists: Ints, mark: AnyInt) -> None:
    """Set seen[e] - mark to the weight of what element e has besides the pivot's list.

    This is done for the elements of all vertices in the pivot's list.
    """
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
def with_room(graph: Graph, pivot: AnyInt, lists: Ints, end: AnyInt) -> Ints:
    """Return the lists, with room behind `end` for the pivot's element."""
    begin = graph.begin[pivot]
    most = graph.length[pivot]
    for p in range(begin, begin + graph.n_elements[pivot]):
        most += graph.length[lists[p]]
    if end + most <= lists.shape[0]:
        return lists
    return np.concatenate((lists, np.empty(lists.shape[0] + most, lists.dtype)))
