"""Walk trees of moving boxes: every pair of elements whose boxes meet on the path.

Two elements are told apart by an axis along which all of the one is below all of the other,
at the start and at the end of the path: vertices move on straight lines at constant speed, so
it is in between too. A box that is swept over the path says less: it tells apart only what
never is at the same place, now or later. Of armadillo-rollers 7,100,661 swept boxes meet.

Boxes are compared in float32. Every coordinate goes through the same rounding, and rounding
is monotone: where the rounded values are in strict order, the exact ones are. So there is
nothing to round outward, and no tolerance.

A tree is wide and implicit. Elements are sorted along a space-filling curve and taken `WIDTH`
at a time; the boxes of such a block lie side by side, so that one box is compared with all of
them at once. A block's own box is a lane of a block of the level above: block b of a level is
lane b % WIDTH of block b // WIDTH there. So there is nothing to build but boxes, bottom up.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.compile import compiled, inlined

WIDTH = 8  # a power of two, see the shifts below
ALL_LANES = 255
# Rows of a block: minima and maxima of the start, minima and maxima of the end.
ROWS = 12


class Tree(NamedTuple):
    """Elements of one kind in the order of a curve, and the boxes above them."""

    order: np.ndarray  # (n,) i4, the element in each place
    nodes: np.ndarray  # (n, k) i4, its vertices
    blocks: np.ndarray  # (m, ROWS, WIDTH) f4, level by level, that of the elements first
    lanes: np.ndarray  # (m,) u1, bit k: something in lane k has to be looked at
    levels: np.ndarray  # (n_levels + 1,) i8, the first block of each


@inlined
def box_of(blocks, block, lane):
    """The twelve numbers of one lane."""
    return (
        blocks[block, 0, lane],
        blocks[block, 1, lane],
        blocks[block, 2, lane],
        blocks[block, 3, lane],
        blocks[block, 4, lane],
        blocks[block, 5, lane],
        blocks[block, 6, lane],
        blocks[block, 7, lane],
        blocks[block, 8, lane],
        blocks[block, 9, lane],
        blocks[block, 10, lane],
        blocks[block, 11, lane],
    )


@inlined
def meeting_lanes(box, blocks, block):
    """Bit k: the box is not apart from lane k of a block."""
    mask = np.uint32(0)
    # without branches, and with a number of lanes that the compiler does not know, it takes all
    # of them at once: 19 ns a block; with branches 106
    for k in range(blocks.shape[2]):
        apart = (
            ((box[3] < blocks[block, 0, k]) & (box[9] < blocks[block, 6, k]))
            | ((box[4] < blocks[block, 1, k]) & (box[10] < blocks[block, 7, k]))
            | ((box[5] < blocks[block, 2, k]) & (box[11] < blocks[block, 8, k]))
            | ((blocks[block, 3, k] < box[0]) & (blocks[block, 9, k] < box[6]))
            | ((blocks[block, 4, k] < box[1]) & (blocks[block, 10, k] < box[7]))
            | ((blocks[block, 5, k] < box[2]) & (blocks[block, 11, k] < box[8]))
        )
        mask |= (np.uint32(0) if apart else np.uint32(1)) << np.uint32(k)
    return np.int64(mask)


@inlined
def lowest_lane(mask):
    """Number of the lowest bit of a mask that is not zero."""
    bit = mask & -mask
    return int((bit & 0xAA) != 0) + 2 * int((bit & 0xCC) != 0) + 4 * int((bit & 0xF0) != 0)


@inlined
def lanes_to_enter(box, looked_at, own, level, block, blocks, lanes, levels):
    """Bit k: there is something in or under lane k of a block that the box may meet.

    Args:
        box: of a block of queries.
        looked_at: whether one of them is; else only what is itself.
        own: that block if the tree is that of the queries, so that pairs come once, else -1.
        level, block: in the tree; the level is not the first.
        blocks, lanes, levels: of the `Tree`.
    """
    at = levels[level] + block
    mask = meeting_lanes(box, blocks, at)
    if not looked_at:
        mask &= lanes[at]
    if own >= 0:
        above = own >> (3 * (level - 1))  # the lane that the own block is, or is under
        if above >> 3 == block:
            mask &= ALL_LANES << (above & 7)
    return mask


@inlined
def share_node(a, i, b, j):
    """Whether element i of a and element j of b have a vertex in common."""
    shared = False
    for k in range(a.shape[1]):
        for m in range(b.shape[1]):
            shared |= a[i, k] == b[j, m]
    return shared


@inlined
def _pairs_of_two_blocks(
    own,
    wanted,
    other,
    other_box,
    query_blocks,
    query_lanes,
    query_nodes,
    leaf_blocks,
    leaf_lanes,
    leaf_nodes,
    same,
    start,
    end,
    pairs_out,
):
    count = 0
    queries = meeting_lanes(other_box, query_blocks, own) & wanted
    while queries:
        lane = lowest_lane(queries)
        queries &= queries - 1
        query = WIDTH * own + lane
        mask = meeting_lanes(box_of(query_blocks, own, lane), leaf_blocks, other)
        if not (query_lanes >> lane) & 1:
            mask &= leaf_lanes
        if same:
            mask &= ALL_LANES << (lane + 1)
        while mask:
            leaf = WIDTH * other + lowest_lane(mask)
            mask &= mask - 1
            # no branch on what cannot be foreseen: a pair that does not count is overwritten
            at = start + count
            if at < end:
                pairs_out[at, 0], pairs_out[at, 1] = query, leaf
            count += not share_node(query_nodes, query, leaf_nodes, leaf)
    return count


@compiled
def pairs_of_block(own, wanted, queries, leaves, against_itself, start, end, pairs_out):
    """Pairs of a block of queries and the leaves of a tree, whose moving boxes meet.

    Pairs of which neither side has to be looked at, or which share a vertex, are left out.

    Args:
        own: the block.
        wanted: the lanes of it that are asked for, ALL_LANES or one alone.
        queries, leaves: `Tree`s.
        against_itself: they are the same tree: each pair comes once, in its order.
        start, end: where to write.
        pairs_out: (n, 2) i4, places of the query and the leaf.

    Returns:
        How many pairs, also those without room.
    """
    # arrays by names of their own: fields would be counted as references at each use
    query_blocks, query_lanes, query_nodes = queries.blocks, queries.lanes, queries.nodes
    blocks, lanes, leaf_nodes, levels = leaves.blocks, leaves.lanes, leaves.nodes, leaves.levels
    top = levels.shape[0] - 2
    if wanted == ALL_LANES:
        box = box_of(query_blocks, queries.levels[1] + own // WIDTH, own % WIDTH)
    else:
        box = box_of(query_blocks, own, lowest_lane(wanted))
    looked_at = query_lanes[own] & wanted
    first = own if against_itself else -1
    count = 0
    to_enter = np.int64(0)  # lanes that are left of each level above, in eight bits of its own
    level, block = top, np.int64(0)  # typed: else the next would be compiled twice
    mask = lanes_to_enter(box, looked_at != 0, first, level, block, blocks, lanes, levels)
    while True:
        if level == 1:
            while mask:
                lane = lowest_lane(mask)
                mask &= mask - 1
                other = WIDTH * block + lane
                count += _pairs_of_two_blocks(
                    own,
                    wanted,
                    other,
                    box_of(blocks, levels[1] + block, lane),
                    query_blocks,
                    looked_at,
                    query_nodes,
                    blocks,
                    lanes[other],
                    leaf_nodes,
                    against_itself and own == other,
                    start + count,
                    end,
                    pairs_out,
                )
        while mask == 0 and level < top:
            level += 1
            block //= WIDTH
            mask = (to_enter >> (8 * (level - 1))) & ALL_LANES
        if mask == 0:
            return count
        shift = 8 * (level - 1)  # levels 1 to 8: over that many lie 8^9 elements
        to_enter = (to_enter & ~(ALL_LANES << shift)) | ((mask & (mask - 1)) << shift)
        level -= 1
        block = WIDTH * block + lowest_lane(mask)
        mask = lanes_to_enter(box, looked_at != 0, first, level, block, blocks, lanes, levels)
