"""Find the pairs of two trees whose moving boxes meet, one thread a query; `tree.py` has the walk.

The threads append to one list, in any order. A pair says its kind by its first number: it is the
place of a vertex, or -1 minus the place of an edge.
"""

import numpy as np

from izo_ref.base.arrays import AnyInt, Indices, Ints
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup, group_add
from izo_ref.detection.serial.found_counts import PAIRS
from izo_ref.detection.serial.tree import (
    ALL_LANES,
    WIDTH,
    Tree,
    box_of,
    lanes_to_enter,
    lowest_lane,
    meeting_lanes,
    next_block,
    share_node,
)


@compiled
def _apart_in_mesh(
    query: int, other: AnyInt, mask: AnyInt, query_nodes: Ints, leaf_nodes: Ints
) -> tuple[AnyInt, int]:
    """Return the lanes of a mask whose leaves share no vertex with a query, and their number."""
    kept, count, rest = mask, 0, mask
    while rest:
        lane = lowest_lane(rest)
        rest &= rest - 1
        if share_node(query_nodes, query, leaf_nodes, WIDTH * other + lane):
            kept &= ~(1 << lane)
        else:
            count += 1
    return kept, count


@compiled
def _append(
    group: ThreadGroup, first: int, other: AnyInt, mask: AnyInt, n: int, counts: Indices, out: Ints
) -> None:
    """Append the pairs of a query and n lanes of a block of leaves, as far as there is room."""
    at = group_add(group, counts, PAIRS, n)
    while mask:
        if at < out.shape[0]:
            out[at, 0], out[at, 1] = first, WIDTH * other + lowest_lane(mask)
        mask &= mask - 1
        at += 1


@compiled
def append_pairs_of_query(
    group: ThreadGroup,
    query: int,
    queries: Tree,
    leaves: Tree,
    against_itself: bool,
    counts_out: Indices,
    pairs_out: Ints,
) -> int:
    """Append the pairs of a query and the leaves of a tree whose moving boxes meet.

    Pairs without a marked element and pairs that share a vertex are left out.

    Args:
        group: The threads that append to the list.
        query: Place of the query.
        queries: Tree of the query.
        leaves: Tree of the leaves.
        against_itself: Whether both are the tree of the edges, so that each pair comes once.
        counts_out: PAIRS is counted, also beyond the room.
        pairs_out: (n, 2) i4.

    Returns:
        The number of pairs.
    """
    blocks, lanes, levels = leaves.blocks, leaves.lanes, leaves.levels
    top, own, own_lane = levels.shape[0] - 2, query // WIDTH, query % WIDTH
    box = box_of(queries.blocks, own, own_lane)
    is_marked = (queries.lanes[own] >> own_lane) & 1 != 0
    first, before = (-1 - query, own) if against_itself else (query, -1)
    count = 0
    to_enter = np.int64(0)  # lanes that are left to enter, eight bits for each level
    level, block = top, np.int64(0)
    while level > 0:
        mask = lanes_to_enter(box, is_marked, before, level, block, blocks, lanes, levels)
        while mask and level == 1:
            other = WIDTH * block + lowest_lane(mask)
            mask &= mask - 1
            found = meeting_lanes(box, blocks, other)
            if not is_marked:
                found &= lanes[other]
            if against_itself and own == other:
                found &= ALL_LANES << (own_lane + 1)
            found, n = _apart_in_mesh(query, other, found, queries.nodes, leaves.nodes)
            if n:
                _append(group, first, other, found, n, counts_out, pairs_out)
                count += n
        level, block, to_enter = next_block(mask, level, block, to_enter, top)
    return count


@compiled
def append_pairs(
    group: ThreadGroup, vertices: Tree, edges: Tree, faces: Tree, counts_out: Indices, out: Ints
) -> int:
    """Append the vertex-face and edge-edge pairs whose moving boxes meet; the group never waits.

    Args:
        group: The threads that append to the list.
        vertices: Tree of the vertices.
        edges: Tree of the edges.
        faces: Tree of the faces.
        counts_out: (N_COUNTS,) i8; PAIRS is counted, also beyond the room.
        out: (n, 2) i4, the pairs.

    Returns:
        The number of vertex-face pairs that this thread found.
    """
    n_edges, count = edges.nodes.shape[0], 0
    for k in range(group.rank(), n_edges + vertices.nodes.shape[0], group.size()):
        if k < n_edges:
            append_pairs_of_query(group, k, edges, edges, True, counts_out, out)
        else:
            query = k - n_edges
            count += append_pairs_of_query(group, query, vertices, faces, False, counts_out, out)
    return count


@compiled
def append_edge_faces(
    group: ThreadGroup, edges: Tree, faces: Tree, counts_out: Indices, out: Ints
) -> None:
    """Append the edges and faces whose moving boxes meet; the group never waits.

    Args:
        group: The threads that append to the list.
        edges: Tree of the edges.
        faces: Tree of the faces.
        counts_out: (N_COUNTS,) i8; PAIRS is counted, also beyond the room.
        out: (n, 2) i4, places of the edge and the face of each pair.
    """
    for k in range(group.rank(), edges.nodes.shape[0], group.size()):
        append_pairs_of_query(group, k, edges, faces, False, counts_out, out)
