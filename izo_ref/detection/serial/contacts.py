"""Decide which pairs of elements meet on their path, or at rest."""

import numpy as np

from izo_ref.base.arrays import (
    AnyInt,
    Codes,
    Floats,
    Indices,
    Ints,
    Nodes,
    Positions,
    Times,
    Vec3,
)
from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import sub3
from izo_ref.detection.formulas.advance import APART, advance
from izo_ref.detection.formulas.crossing import edge_face_status

# Added to the keys of vertex-face pairs, so that they are sorted before those of edge-edge pairs.
VERTEX_FACE_OFFSET = -(2**63)


@compiled
def row3(array: Floats, i: int) -> Vec3:
    """Return row i of an array with three columns."""
    return (array[i, 0], array[i, 1], array[i, 2])


@compiled
def row4(array: Nodes, i: int) -> tuple[int, int, int, int]:
    """Return row i of an array with four columns."""
    return (array[i, 0], array[i, 1], array[i, 2], array[i, 3])


@compiled
def relative_nodes(
    positions: Positions, nodes: tuple[int, int, int, int]
) -> tuple[Vec3, Vec3, Vec3]:
    """Return nodes 1 to 3 of a pair relative to its node 0."""
    p0 = row3(positions, nodes[0])
    return (
        sub3(row3(positions, nodes[1]), p0),
        sub3(row3(positions, nodes[2]), p0),
        sub3(row3(positions, nodes[3]), p0),
    )


@compiled
def pair_nodes(
    a: int, b: int, first_order: Ints, first_nodes: Ints, second_order: Ints, second_nodes: Ints
) -> tuple[int, int, int, int]:
    """Return the four vertices of places a and b of two trees; two edges come in their order."""
    if first_nodes.shape[1] == 1:
        return (first_nodes[a, 0], second_nodes[b, 0], second_nodes[b, 1], second_nodes[b, 2])
    if first_order[a] > second_order[b]:
        return (second_nodes[b, 0], second_nodes[b, 1], first_nodes[a, 0], first_nodes[a, 1])
    return (first_nodes[a, 0], first_nodes[a, 1], second_nodes[b, 0], second_nodes[b, 1])


@compiled
def pair_key(a: int, b: int, first_order: Ints, first_nodes: Ints, second_order: Ints) -> AnyInt:
    """Return the sort key of places a and b: kind, then elements, the lower one of two edges first.

    Keys of edge-edge pairs are not negative, and those of vertex-face pairs are.
    """
    first, second = np.int64(first_order[a]), np.int64(second_order[b])
    if first_nodes.shape[1] == 1:
        return ((first << 32) | second) + VERTEX_FACE_OFFSET
    if first > second:
        first, second = second, first
    return (first << 32) | second


@compiled
def contacts_of_pairs(
    # In:
    begin: int,  # the first pair to decide; the results are written from here on
    end: int,  # behind the last one
    pairs: Ints,  # (n_pairs, 2) i4, places
    first_order: Ints,  # (m,) i4, element in each place of the tree of vertices or edges
    first_nodes: Ints,  # (m, k) i4, its vertices
    second_order: Ints,  # (m,) i4, of the tree of faces or edges
    second_nodes: Ints,  # (m, k) i4
    positions_t0: Positions,  # (n_vertices, 3) f8 [m]
    positions_t1: Positions,  # (n_vertices, 3) f8 [m]
    # Out:
    index_out: Indices,  # (n_pairs,) i8, the pair of each contact
    toi_out: Times,  # (n_pairs,) f8, time until which it is proved apart
    directions_out: Floats,  # (n_pairs, 3) f8, the last direction that separated its sides
    margins_out: Floats,  # (n_pairs,) f8 [m], of each pair: as far from positions_t1, along each
    # axis, its vertices may end while it stays apart; 0 for a contact
) -> tuple[int, int, int]:
    """Find the contacts among some pairs: those that are not proved apart.

    Returns:
        The number of contacts, of steps of all proofs, and of steps of the longest proof.
    """
    contacts, proofs, most = 0, 0, 0
    is_edge_edge = first_nodes.shape[1] == 2
    for i in range(begin, end):
        nodes = pair_nodes(
            pairs[i, 0], pairs[i, 1], first_order, first_nodes, second_order, second_nodes
        )
        a1, a2, a3 = relative_nodes(positions_t0, nodes)
        b1, b2, b3 = relative_nodes(positions_t1, nodes)
        status, toi, direction, steps, margin = advance(is_edge_edge, a1, a2, a3, b1, b2, b3)
        margins_out[i] = margin
        proofs += steps
        most = max(most, steps)
        if status == APART:
            continue
        at = begin + contacts
        contacts += 1
        index_out[at] = i
        toi_out[at] = toi
        for axis in range(3):
            directions_out[at, axis] = direction[axis]
    return contacts, proofs, most


@compiled
def crossing_status(i: int, pairs: Ints, edges: Ints, faces: Ints, positions: Positions) -> int:
    """Return whether the edge and the face of pair i meet at rest, as `edge_face_status` does."""
    a, b = pairs[i, 0], pairs[i, 1]
    return edge_face_status(
        row3(positions, edges[a, 0]),
        row3(positions, edges[a, 1]),
        row3(positions, faces[b, 0]),
        row3(positions, faces[b, 1]),
        row3(positions, faces[b, 2]),
    )


@compiled
def crossings_of_pairs(
    begin: int,
    end: int,
    pairs: Ints,
    edges: Ints,
    faces: Ints,
    positions: Positions,
    statuses_out: Codes,
) -> None:
    """Write whether edges meet faces at rest: a status of `formulas/advance.py` for each pair."""
    for i in range(begin, end):
        statuses_out[i] = crossing_status(i, pairs, edges, faces, positions)
