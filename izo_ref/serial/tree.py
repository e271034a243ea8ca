"""Walk a tree of boxes: every leaf whose box meets a query's box.

The tree is implicit. Elements are sorted along a space-filling curve and taken `GROUP` at
a time as leaves; with P leaves, P a power of two, node i has the children 2 i and 2 i + 1
and leaf k is node P + k. So there is nothing to build but boxes, bottom up, and nothing
to keep while walking: the node after node i is i + 1 with its trailing zero bits cut off,
and that is 1 after the last one.

Boxes are closed and hold the exact minima and maxima of positions at both ends of the
path, so a pair that meets has boxes that meet: the test needs no tolerance.
"""

from izo_ref._jit import compiled

GROUP = 4


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
def meeting_leaves(
    query,  # position of the query in its own sorted order
    query_boxes,  # (n_queries, 6) f8  [m]
    query_nodes,  # (n_queries, k) i4
    query_moved,  # (n_queries,) b1
    leaf_boxes,  # (n_leaves, 6) f8  [m]
    leaf_nodes,  # (n_leaves, k) i4
    leaf_moved,  # (n_leaves,) b1
    node_boxes,  # (2 P, 6) f8  [m]
    node_moved,  # (2 P,) b1
    against_itself,  # queries are the leaves: meet each pair once, in leaf order
    store,
    pairs_out,  # (n_pairs, 2) i4
    start,
):
    """Count the leaves a query has to be tested against; write them from `start` on if
    `store`. Pairs of which neither side moved, or which share a vertex, are left out."""
    first_leaf = node_boxes.shape[0] // 2
    moved = query_moved[query]
    count = 0
    node = first_leaf + query // GROUP if against_itself else 1
    while True:
        if (moved or node_moved[node]) and boxes_meet(query_boxes, query, node_boxes, node):
            if node < first_leaf:
                node = 2 * node
                continue
            begin = (node - first_leaf) * GROUP
            end = min(begin + GROUP, leaf_boxes.shape[0])
            if against_itself:
                begin = max(begin, query + 1)
            for leaf in range(begin, end):
                if (
                    (moved or leaf_moved[leaf])
                    and boxes_meet(query_boxes, query, leaf_boxes, leaf)
                    and not share_node(query_nodes, query, leaf_nodes, leaf)
                ):
                    if store:
                        pairs_out[start + count, 0] = query
                        pairs_out[start + count, 1] = leaf
                    count += 1
        node = next_node(node)
        if node == 1:
            return count
