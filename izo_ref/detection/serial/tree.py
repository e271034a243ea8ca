"""Walk trees of moving boxes, and find every pair of elements whose boxes meet on the path.

**Moving boxes.** An element has two boxes: one about its vertices at the start of the path, one
about them at the end. Two elements are apart if, along one axis, all of the one is below all of the
other both at the start and at the end. Vertices move on straight lines at constant speed, so it is
below in between too. The box that is swept over the whole path would say less: it separates only
what is never at the same place, now or later. On armadillo-rollers 7,100,661 pairs of swept boxes
meet.

**Rounding.** Boxes are compared in float32. Every coordinate is rounded in the same way, and
rounding is monotone: where the rounded values are in strict order, the exact values are too. So no
box is rounded outward, and there is no tolerance.

**The tree.** It is wide and implicit. The elements are sorted along a space-filling curve and taken
`WIDTH` at a time. Such a block stores the boxes of its elements side by side, one in each lane, so
that one box is compared with all of them at once. The box about a whole block is one lane of a
block of the level above: block b of a level is lane b % WIDTH of block b // WIDTH there. So
building a tree means fitting boxes, from the elements up.

**Marks.** An element with a vertex that moved is marked, and so is every lane above it. Only pairs
with at least one marked element are wanted. An element that is not marked can still be hit by a
marked one.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyFloats, AnyInt, AnyInts, Bits, Ints, Offsets
from izo_ref.base.compile import compiled, inlined

WIDTH = 8  # lanes of a block; the shifts below need this power of two
ALL_LANES = 255
# Rows of a block, three each: minima and maxima at the start, minima and maxima at the end.
ROWS = 12


class Tree(NamedTuple):
    """Elements of one kind in the order of a curve, and the boxes above them."""

    order: Ints  # (n,) i4, the element in each place
    nodes: Ints  # (n, k) i4, its vertices
    blocks: AnyFloats  # (m, ROWS, WIDTH) f4, level by level, that of the elements first
    lanes: Bits  # (m,) u1, bit k: lane k of the block is marked
    levels: Offsets  # (n_levels + 1,) i8, the first block of each


@inlined
def box_of(blocks: AnyFloats, block: AnyInt, lane: AnyInt) -> tuple[float, ...]:
    """Return the twelve numbers of one lane of a block."""
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
def meeting_lanes(box: tuple[float, ...], blocks: AnyFloats, block: AnyInt) -> AnyInt:
    """Return a mask of the lanes of a block whose boxes are not apart from a box."""
    mask = np.uint32(0)
    # The loop has no branches, and the compiler does not know the number of lanes: so it compares
    # all lanes at once, in 19 ns a block. With branches it takes 106 ns.
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
def lowest_lane(mask: AnyInt) -> int:
    """Return the number of the lowest bit of a mask that is not zero."""
    bit = mask & -mask
    return int((bit & 0xAA) != 0) + 2 * int((bit & 0xCC) != 0) + 4 * int((bit & 0xF0) != 0)


@inlined
def lanes_to_enter(
    box: tuple[float, ...],  # of a block of queries, or of one query
    is_marked: bool,  # whether a query in it is marked
    own: AnyInt,  # that block if the tree is that of the queries, so that pairs come once, else -1
    level: int,  # in the tree, 1 or higher
    block: AnyInt,  # in that level
    blocks: AnyFloats,  # of the `Tree`
    lanes: Bits,
    levels: Offsets,
) -> AnyInt:
    """Return a mask of the lanes of a block in or below which the box may meet a wanted element."""
    at: AnyInt = levels[level] + block
    mask = meeting_lanes(box, blocks, at)
    if not is_marked:
        mask &= lanes[at]
    if own >= 0:
        above = own >> (3 * (level - 1))  # the lane that is the own block, or is above it
        if above >> 3 == block:
            mask &= ALL_LANES << (above & 7)
    return mask


@inlined
def share_node(a: AnyInts, i: AnyInt, b: AnyInts, j: AnyInt) -> bool:
    """Return whether element i of a and element j of b have a vertex in common."""
    shared = False
    for k in range(a.shape[1]):
        for m in range(b.shape[1]):
            shared |= a[i, k] == b[j, m]
    return shared


@inlined
def _pairs_of_two_blocks(
    own: AnyInt,  # block of queries
    other: AnyInt,  # block of leaves
    other_box: tuple[float, ...],  # box about it
    query_blocks: AnyFloats,
    query_lanes: AnyInt,  # mask of the marked lanes of the own block
    query_nodes: Ints,
    leaf_blocks: AnyFloats,
    leaf_lanes: AnyInt,  # mask of the marked lanes of the other block
    leaf_nodes: Ints,
    same: bool,  # both are the same block
    start: int,
    end: int,
    pairs_out: Ints,
) -> int:
    """Write the pairs of two blocks from `start` on, as far as `end`, and return their number."""
    count = 0
    queries = meeting_lanes(other_box, query_blocks, own)
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
            # No branch here, because the CPU could not predict it: a pair that shares a vertex is
            # written too, and the next pair overwrites it.
            at = start + count
            if at < end:
                pairs_out[at, 0], pairs_out[at, 1] = query, leaf
            count += not share_node(query_nodes, query, leaf_nodes, leaf)
    return count


@inlined
def next_block(
    mask: AnyInt,  # lanes to enter of the block
    level: int,
    block: AnyInt,  # in that level
    to_enter: AnyInt,  # lanes that are left to enter in the levels above, eight bits for each level
    top: int,  # the highest level
) -> tuple[int, AnyInt, AnyInt]:
    """Return the level and the number of the next block of a walk, and what is left to enter.

    The level is 0 if the walk is at its end.
    """
    while mask == 0 and level < top:
        level += 1
        block //= WIDTH
        mask = (to_enter >> (8 * (level - 1))) & ALL_LANES
    if mask == 0:
        return 0, block, to_enter
    shift = 8 * (level - 1)  # levels 1 to 8, enough for 8^9 elements
    to_enter = (to_enter & ~(ALL_LANES << shift)) | ((mask & (mask - 1)) << shift)
    return level - 1, WIDTH * block + lowest_lane(mask), to_enter


@compiled
def pairs_of_block(
    own: int,
    queries: Tree,
    leaves: Tree,
    against_itself: bool,
    start: int,
    end: int,
    pairs_out: Ints,
) -> int:
    """Write the pairs of a block of queries and the leaves of a tree whose moving boxes meet.

    Pairs without a marked element and pairs that share a vertex are left out.

    Args:
        own: The block of queries.
        queries: Tree of the queries.
        leaves: Tree of the leaves.
        against_itself: Whether both are the same tree. Each pair then comes once, in the order of
            the tree.
        start: Where the pairs are written.
        end: Where the room ends.
        pairs_out: (n, 2) i4, places of the query and the leaf.

    Returns:
        The number of pairs, also of those for which there was no room.
    """
    # the fields get names of their own: numba would count references at each use of a field
    query_blocks, query_lanes, query_nodes = queries.blocks, queries.lanes, queries.nodes
    blocks, lanes, leaf_nodes, levels = leaves.blocks, leaves.lanes, leaves.nodes, leaves.levels
    top = levels.shape[0] - 2
    box = box_of(query_blocks, queries.levels[1] + own // WIDTH, own % WIDTH)
    marked = query_lanes[own]
    first = own if against_itself else -1
    count = 0
    to_enter = np.int64(0)  # lanes that are left to enter, eight bits for each level
    level, block = top, np.int64(0)  # typed, or else the next call would be compiled twice
    mask = lanes_to_enter(box, marked != 0, first, level, block, blocks, lanes, levels)
    while True:
        if level == 1:
            while mask:
                lane = lowest_lane(mask)
                mask &= mask - 1
                other = WIDTH * block + lane
                count += _pairs_of_two_blocks(
                    own,
                    other,
                    box_of(blocks, levels[1] + block, lane),
                    query_blocks,
                    marked,
                    query_nodes,
                    blocks,
                    lanes[other],
                    leaf_nodes,
                    against_itself and own == other,
                    start + count,
                    end,
                    pairs_out,
                )
        level, block, to_enter = next_block(mask, level, block, to_enter, top)
        if level == 0:
            return count
        mask = lanes_to_enter(box, marked != 0, first, level, block, blocks, lanes, levels)
