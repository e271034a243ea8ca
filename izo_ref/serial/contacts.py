"""The pairs of two trees that meet on their path, or at rest.

Candidates are tested as soon as they are found, while their boxes are at hand; no list of
them is ever made.
"""

import numpy as np

from izo_ref._jit import compiled
from izo_ref.scalar.advance import APART, advance
from izo_ref.scalar.crossing import edge_face_status
from izo_ref.scalar.vec3 import sub3
from izo_ref.serial.tree import next_pairs

# Candidates that wait for their test at a time: 2 kB.
BUFFER = 256


@compiled
def row3(array, i):
    return (array[i, 0], array[i, 1], array[i, 2])


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


# Tests are loops of their own over plain arrays: with the trees in them, each use of a field
# would be counted as a reference: 0.95 s for armadillo-rollers on one thread, not 0.63.
@compiled
def _contacts_of_pairs(
    found,
    count,
    first_order,
    first_nodes,
    second_order,
    second_nodes,
    positions_t0,
    positions_t1,
    start,
    end,
    pairs_out,
    nodes_out,
    toi_out,
    directions_out,
):
    contacts, proofs, most = 0, 0, 0
    is_edge_edge = first_nodes.shape[1] == 2
    for i in range(count):
        nodes = pair_nodes(
            found[i, 0], found[i, 1], first_order, first_nodes, second_order, second_nodes
        )
        a1, a2, a3 = relative_nodes(positions_t0, nodes)
        b1, b2, b3 = relative_nodes(positions_t1, nodes)
        status, toi, direction, steps = advance(is_edge_edge, a1, a2, a3, b1, b2, b3)
        proofs += steps
        most = max(most, steps)
        if status == APART:
            continue
        at = start + contacts
        contacts += 1
        if at < end:
            pairs_out[at, 0], pairs_out[at, 1] = found[i, 0], found[i, 1]
            toi_out[at] = toi
            for k in range(4):
                nodes_out[at, k] = nodes[k]
            for axis in range(3):
                directions_out[at, axis] = direction[axis]
    return contacts, proofs, most


@compiled
def contacts_of_groups(
    first_group,
    last_group,
    queries,
    leaves,
    against_itself,
    positions_t0,
    positions_t1,
    start,
    end,
    pairs_out,
    nodes_out,
    toi_out,
    directions_out,
):
    """Contacts of some groups of queries, vertices with faces or edges with edges.

    Args:
        queries, leaves, against_itself: as of `next_pairs`.
        positions_t0, positions_t1: (n_vertices, 3) f8 [m].
        start, end: where to write.
        pairs_out: (n, 2) i4, places of the elements of each pair that is not proved apart.
        nodes_out: (n, 4) i4, its vertices, see `pair_nodes`.
        toi_out: (n,) f8, until when it is.
        directions_out: (n, 3) f8, the last direction that separated the sides.

    Returns:
        Contacts, also those without room; candidates; proofs, and the most for one pair.
    """
    found = np.empty((BUFFER, 2), np.int32)
    contacts, candidates, proofs, most = 0, 0, 0, 0
    for group in range(first_group, last_group):
        node = 0
        while True:
            count, node = next_pairs(group, node, queries, leaves, against_itself, found)
            more, steps, most_steps = _contacts_of_pairs(
                found,
                count,
                queries.order,
                queries.nodes,
                leaves.order,
                leaves.nodes,
                positions_t0,
                positions_t1,
                start + contacts,
                end,
                pairs_out,
                nodes_out,
                toi_out,
                directions_out,
            )
            contacts += more
            candidates += count
            proofs += steps
            most = max(most, most_steps)
            if node == 0:
                break
    return contacts, candidates, proofs, most


@compiled
def _crossings_of_pairs(found, count, edges, faces, positions, start, end, pairs_out, statuses_out):
    crossings = 0
    for i in range(count):
        a, b = found[i, 0], found[i, 1]
        status = edge_face_status(
            row3(positions, edges[a, 0]),
            row3(positions, edges[a, 1]),
            row3(positions, faces[b, 0]),
            row3(positions, faces[b, 1]),
            row3(positions, faces[b, 2]),
        )
        if status == APART:
            continue
        at = start + crossings
        crossings += 1
        if at < end:
            pairs_out[at, 0], pairs_out[at, 1], statuses_out[at] = a, b, status
    return crossings


@compiled
def crossings_of_groups(
    first_group, last_group, queries, leaves, positions, start, end, pairs_out, statuses_out
):
    """Edges and faces that may meet at rest, of some groups of edges.

    Args:
        statuses_out: (n,) i1, of scalar/advance.py: CONTACT or UNDECIDED.
        Others: as of `contacts_of_groups`.

    Returns:
        Pairs not proved apart, also those without room, and candidates.
    """
    found = np.empty((BUFFER, 2), np.int32)
    edges, faces = queries.nodes, leaves.nodes
    crossings, candidates = 0, 0
    for group in range(first_group, last_group):
        node = 0
        while True:
            count, node = next_pairs(group, node, queries, leaves, False, found)
            candidates += count
            at = start + crossings
            crossings += _crossings_of_pairs(
                found, count, edges, faces, positions, at, end, pairs_out, statuses_out
            )
            if node == 0:
                break
    return crossings, candidates
