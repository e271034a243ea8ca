"""Walk trees of boxes: every pair of elements whose boxes meet.

A tree is implicit. Elements are sorted along a space-filling curve and taken `GROUP` at
a time as leaves; with P leaves, P a power of two, node i has the children 2 i and 2 i + 1
and leaf k is node P + k. So there is nothing to build but boxes, bottom up, and nothing
to keep while walking: the node after node i is i + 1 with its trailing zero bits cut off,
and that is 1 after the last one.

Boxes are closed and hold the exact minima and maxima of positions at both ends of the
path, so a pair that meets has boxes that meet: the test needs no tolerance.
"""

from typing import NamedTuple

import numpy as np

from izo_ref._jit import compiled

GROUP = 4


class Tree(NamedTuple):
    """Elements of one kind in the order of a curve, and the boxes above them."""

    order: np.ndarray  # (n,) i8, the element in each place
    nodes: np.ndarray  # (n, k) i4, its vertices
    boxes: np.ndarray  # (n, 6) f8 [m], minima then maxima over the path
    moved: np.ndarray  # (n,) b1, whether it has to be looked at
    node_boxes: np.ndarray  # (2 P, 6) f8 [m], of the nodes; row 0 is none
    node_moved: np.ndarray  # (2 P,) b1, whether one of those below has to be looked at


@compiled
def next_node(node):
    node += 1
    while node & 1 == 0:
        node >>= 1
    return node


@compiled
def boxes_meet(a, i, b, j):
    """Whether box i of a and box j of b meet; rows are three minima, then three maxima."""
    return (
        a[i, 0] <= b[j, 3]
        and b[j, 0] <= a[i, 3]
        and a[i, 1] <= b[j, 4]
        and b[j, 1] <= a[i, 4]
        and a[i, 2] <= b[j, 5]
        and b[j, 2] <= a[i, 5]
    )


@compiled
def share_node(a, i, b, j):
    """Whether element i of a and element j of b have a vertex in common."""
    for k in range(a.shape[1]):
        for m in range(b.shape[1]):
            if a[i, k] == b[j, m]:
                return True
    return False


@compiled
def next_pairs(group, node, queries, leaves, against_itself, pairs_out):
    """Pairs of a query of one group and a leaf, whose boxes meet.

    Pairs of which neither side moved, or which share a vertex, are left out.

    Args:
        group: of the queries.
        node: of the leaves' tree, where to go on; 0 to begin.
        queries, leaves: `Tree`s.
        against_itself: they are the same tree: each pair comes once, in its order.
        pairs_out: (n, 2) i4, n >= GROUP^2: places of the query and the leaf.

    Returns:
        How many pairs, and the node to go on from; 0 after the last one.
    """
    # arrays by names of their own: fields would be counted as references at each use
    group_boxes, query_boxes, query_nodes = queries.node_boxes, queries.boxes, queries.nodes
    node_boxes, leaf_boxes, leaf_nodes = leaves.node_boxes, leaves.boxes, leaves.nodes
    query_moved, leaf_moved, node_moved = queries.moved, leaves.moved, leaves.node_moved
    own, first_leaf = group_boxes.shape[0] // 2 + group, node_boxes.shape[0] // 2
    first_query = group * GROUP
    last_query = min(first_query + GROUP, query_boxes.shape[0])
    moved, count = queries.node_moved[own], 0
    if node == 0:
        node = own if against_itself else 1
    while True:
        looked_at = moved or node_moved[node]
        if looked_at and boxes_meet(group_boxes, own, node_boxes, node):
            if node < first_leaf:
                node = 2 * node
                continue
            if count + GROUP * GROUP > pairs_out.shape[0]:
                return count, node
            begin = (node - first_leaf) * GROUP
            end = min(begin + GROUP, leaf_boxes.shape[0])
            for query in range(first_query, last_query):
                if not boxes_meet(query_boxes, query, node_boxes, node):
                    continue
                for leaf in range(max(begin, query + 1) if against_itself else begin, end):
                    if (
                        boxes_meet(query_boxes, query, leaf_boxes, leaf)
                        and (query_moved[query] or leaf_moved[leaf])
                        and not share_node(query_nodes, query, leaf_nodes, leaf)
                    ):
                        pairs_out[count, 0] = query
                        pairs_out[count, 1] = leaf
                        count += 1
        node = next_node(node)
        if node == 1:
            return count, 0
