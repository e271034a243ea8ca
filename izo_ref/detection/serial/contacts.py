"""Which pairs of elements meet on their path, or at rest."""

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.base.formulas.vec3 import sub3
from izo_ref.detection.formulas.advance import APART, advance
from izo_ref.detection.formulas.crossing import edge_face_status


@compiled
def row3(array, i):
    return (array[i, 0], array[i, 1], array[i, 2])


@compiled
def row4(array, i):
    return (array[i, 0], array[i, 1], array[i, 2], array[i, 3])


@compiled
def relative_nodes(positions, nodes):
    """Nodes 1..3 of a pair relative to its node 0."""
    p0 = row3(positions, nodes[0])
    return (
        sub3(row3(positions, nodes[1]), p0),
        sub3(row3(positions, nodes[2]), p0),
        sub3(row3(positions, nodes[3]), p0),
    )


@compiled
def pair_nodes(a, b, first_order, first_nodes, second_order, second_nodes):
    """The four vertices of places a and b; of two edges the one with the lower index first."""
    if first_nodes.shape[1] == 1:
        return (first_nodes[a, 0], second_nodes[b, 0], second_nodes[b, 1], second_nodes[b, 2])
    if first_order[a] > second_order[b]:
        return (second_nodes[b, 0], second_nodes[b, 1], first_nodes[a, 0], first_nodes[a, 1])
    return (first_nodes[a, 0], first_nodes[a, 1], second_nodes[b, 0], second_nodes[b, 1])


@compiled
def pair_key(a, b, first_order, first_nodes, second_order):
    """What places a and b are sorted by: their elements, of two edges the lower first."""
    first, second = np.int64(first_order[a]), np.int64(second_order[b])
    if first_nodes.shape[1] == 2 and first > second:
        first, second = second, first
    return (first << 32) | second


@compiled
def contacts_of_pairs(
    first,
    last,
    pairs,
    first_order,
    first_nodes,
    second_order,
    second_nodes,
    positions_t0,
    positions_t1,
    reach,
    max_steps,
    index_out,
    toi_out,
    directions_out,
):
    """Those of some pairs that are not proved apart, vertices with faces or edges with edges.

    Args:
        first, last: of the pairs; results are written from `first` on.
        pairs: (n, 2) i4, places.
        first_order, first_nodes, second_order, second_nodes: of the two `Tree`s.
        positions_t0, positions_t1: (n_vertices, 3) f8 [m].
        reach: (n_vertices,) f8 [m], each may end so far from positions_t1, along each axis.
        max_steps: [steps] before a pair is given up, which then counts as a contact.
        index_out: (n,) i8, the pair.
        toi_out: (n,) f8, until when it is proved apart.
        directions_out: (n, 3) f8, the last direction that separated the sides.

    Returns:
        Contacts; proofs, and the most for one pair.
    """
    contacts, proofs, most = 0, 0, 0
    is_edge_edge = first_nodes.shape[1] == 2
    for i in range(first, last):
        nodes = pair_nodes(
            pairs[i, 0], pairs[i, 1], first_order, first_nodes, second_order, second_nodes
        )
        a1, a2, a3 = relative_nodes(positions_t0, nodes)
        b1, b2, b3 = relative_nodes(positions_t1, nodes)
        within = (reach[nodes[0]], reach[nodes[1]], reach[nodes[2]], reach[nodes[3]])
        status, toi, direction, steps = advance(
            is_edge_edge, a1, a2, a3, b1, b2, b3, within, max_steps
        )
        proofs += steps
        most = max(most, steps)
        if status == APART:
            continue
        at = first + contacts
        contacts += 1
        index_out[at] = i
        toi_out[at] = toi
        for axis in range(3):
            directions_out[at, axis] = direction[axis]
    return contacts, proofs, most


@compiled
def crossings_of_pairs(first, last, pairs, edges, faces, positions, statuses_out):
    """Whether edges meet faces at rest: a status of `formulas/advance.py` for each pair."""
    for i in range(first, last):
        a, b = pairs[i, 0], pairs[i, 1]
        statuses_out[i] = edge_face_status(
            row3(positions, edges[a, 0]),
            row3(positions, edges[a, 1]),
            row3(positions, faces[b, 0]),
            row3(positions, faces[b, 1]),
            row3(positions, faces[b, 2]),
        )
