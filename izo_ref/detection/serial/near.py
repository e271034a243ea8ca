"""Keep lists of pairs: the pairs that are near, and the contacts among them."""

import numpy as np

from izo_ref.base.arrays import AnyInt, Bits, Floats, Indices, Ints, Nodes, Times
from izo_ref.base.compile import compiled
from izo_ref.detection.serial.contacts import pair_key, pair_nodes
from izo_ref.detection.serial.tree import WIDTH


@compiled
def pack_pairs(room: int, counts: Indices, pairs: Ints) -> tuple[Ints, int]:
    """Put the pairs that chunks of queries found one chunk after the other.

    Args:
        room: Number of pairs for which each chunk has room.
        counts: (n,) i8, pairs that each chunk found.
        pairs: (n * room, 2) i4; chunk k wrote from k * room on.

    Returns:
        (m, 2) i4, the pairs of the chunks that had room for all; and the number of other chunks.
    """
    n_pairs, n_full = 0, 0
    for k in range(counts.shape[0]):
        if counts[k] <= room:
            n_pairs += counts[k]
        else:
            n_full += 1
    packed, at = np.empty((n_pairs, 2), np.int32), 0
    for k in range(counts.shape[0]):
        if counts[k] <= room:
            for i in range(k * room, k * room + counts[k]):
                packed[at, 0], packed[at, 1] = pairs[i, 0], pairs[i, 1]
                at += 1
    return packed, n_full


@compiled
def _is_marked(place: AnyInt, lanes: Bits) -> bool:
    """Return whether the element in a place of a tree is marked."""
    return (lanes[place // WIDTH] >> (place % WIDTH)) & 1 != 0


@compiled
def replace_marked(
    near: Ints, margins: Floats, first_lanes: Bits, second_lanes: Bits, new: Ints
) -> tuple[Ints, Floats]:
    """Drop the near pairs with a marked element, and append new pairs with a margin of -1.

    Args:
        near: (n, 2) i4, places in two trees.
        margins: (n,) f8 [m].
        first_lanes: (m,) u1, `lanes` of the first tree.
        second_lanes: (m,) u1, `lanes` of the second tree.
        new: (k, 2) i4, places.

    Returns:
        The pairs, and their margins.
    """
    most, n_kept = near.shape[0] + new.shape[0], 0
    pairs_out, margins_out = np.empty((most, 2), np.int32), np.empty(most)
    for i in range(near.shape[0]):
        a, b = near[i, 0], near[i, 1]
        if not (_is_marked(a, first_lanes) or _is_marked(b, second_lanes)):
            pairs_out[n_kept, 0], pairs_out[n_kept, 1] = a, b
            margins_out[n_kept] = margins[i]
            n_kept += 1
    for i in range(new.shape[0]):
        pairs_out[n_kept + i, 0], pairs_out[n_kept + i, 1] = new[i, 0], new[i, 1]
        margins_out[n_kept + i] = -1.0
    n = n_kept + new.shape[0]
    return pairs_out[:n], margins_out[:n]


@compiled
def use_up_margins(
    near: Ints, first_nodes: Ints, second_nodes: Ints, moves: Floats, margins_out: Floats
) -> Indices:
    """Take moves off the margins of near pairs, and return the pairs whose margin is used up.

    Args:
        near: (n, 2) i4, places in two trees.
        first_nodes: (m, k) i4, vertices of the elements of the first tree.
        second_nodes: (m, k) i4, vertices of the elements of the second tree.
        moves: (n_vertices,) f8 [m].
        margins_out: (n,) f8 [m]; the move of the vertex that moved farthest is taken off.

    Returns:
        (n_due,) i8.
    """
    due, n_due = np.empty(near.shape[0], np.int64), 0
    for i in range(near.shape[0]):
        a, b = near[i, 0], near[i, 1]
        largest = 0.0
        for k in range(first_nodes.shape[1]):
            largest = max(largest, moves[first_nodes[a, k]])
        for k in range(second_nodes.shape[1]):
            largest = max(largest, moves[second_nodes[b, k]])
        margins_out[i] -= largest
        if margins_out[i] < 0.0:
            due[n_due] = i
            n_due += 1
    return due[:n_due]


@compiled
def collect_contacts(
    chunk: int,  # number of pairs of a chunk
    tallies: Indices,  # (n, 3) i8, of `find_contacts`
    index: Indices,  # (n_pairs,) i8, the pair of each contact; chunk c wrote from chunk * c on
    pairs: Ints,  # (n_pairs, 2) i4, places
    pair_toi: Times,  # (n_pairs,) f8
    pair_directions: Floats,  # (n_pairs, 3) f8
    first_order: Ints,  # (m,) i4, element in each place of the tree of vertices or edges
    first_nodes: Ints,  # (m, k) i4, its vertices
    second_order: Ints,  # (m,) i4, of the tree of faces or edges
    second_nodes: Ints,  # (m, k) i4
) -> tuple[tuple[Indices, Nodes, Times, Floats], int, int]:
    """Return the contacts that chunks of pairs found, and the steps of their proofs.

    Returns:
        Keys, nodes, times and last directions of the contacts; steps of all proofs, and of the
        longest one.
    """
    n, steps, most = 0, 0, 0
    for c in range(tallies.shape[0]):
        n += tallies[c, 0]
        steps += tallies[c, 1]
        most = max(most, tallies[c, 2])
    keys, nodes = np.empty(n, np.int64), np.empty((n, 4), np.int32)
    toi, directions, i = np.empty(n), np.empty((n, 3)), 0
    for c in range(tallies.shape[0]):
        for at in range(chunk * c, chunk * c + tallies[c, 0]):
            a, b = pairs[index[at], 0], pairs[index[at], 1]
            keys[i] = pair_key(a, b, first_order, first_nodes, second_order)
            own = pair_nodes(a, b, first_order, first_nodes, second_order, second_nodes)
            for k in range(4):
                nodes[i, k] = own[k]
            toi[i] = pair_toi[at]
            for axis in range(3):
                directions[i, axis] = pair_directions[at, axis]
            i += 1
    return (keys, nodes, toi, directions), steps, most
