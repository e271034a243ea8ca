"""Find the contacts among candidate pairs, and sort their impacts, by the threads of a group.

Pairs that float32 proves apart are left out first (`serial/filter.py`), by a launch of its own.
"""

import numpy as np

from izo_ref.base.arrays import AnyFloats, Flags, Indices, Ints, Positions, Times
from izo_ref.base.compile import compiled
from izo_ref.base.records import Impacts
from izo_ref.base.serial.group_sort import group_sort
from izo_ref.base.serial.search import is_among
from izo_ref.base.serial.thread_group import ThreadGroup, group_add, group_maxima, group_sums
from izo_ref.detection.formulas.advance import APART, advance
from izo_ref.detection.formulas.frame import impact_frame
from izo_ref.detection.serial.contacts import (
    crossing_status,
    pair_key,
    pair_nodes,
    relative_nodes,
    row3,
    row4,
)
from izo_ref.detection.serial.filter import is_settled
from izo_ref.detection.serial.found_counts import (
    AT_START,
    BLOCKED,
    CONTACTS,
    FOUND,
    OPEN,
    PAIRS,
)
from izo_ref.detection.serial.prescribed import is_prescribed
from izo_ref.detection.serial.records import ContactList, PathArrays, SortSpace
from izo_ref.detection.serial.tree import Tree

LAST_KEY = 2**63 - 1  # behind the keys of all pairs
EDGE_EDGE_FROM = 0  # the least key of an edge-edge pair


@compiled
def _key_and_nodes(
    i: int, pairs: Ints, vertices: Tree, edges: Tree, faces: Tree
) -> tuple[int, tuple[int, int, int, int]]:
    """Return the key and the vertices of pair i of `serial/query.py`."""
    a, b = pairs[i, 0], pairs[i, 1]
    if a >= 0:
        trees = vertices.order, vertices.nodes, faces.order, faces.nodes
    else:
        a = -1 - a
        trees = edges.order, edges.nodes, edges.order, edges.nodes
    return int(pair_key(a, b, *trees[:3])), pair_nodes(a, b, *trees)


@compiled
def append_open_pairs(
    group: ThreadGroup,
    vertex_boxes: AnyFloats,
    vertices: Tree,
    edges: Tree,
    faces: Tree,
    pairs: Ints,
    counts_out: Indices,
    open_out: Ints,
) -> None:
    """Append the pairs that float32 does not prove apart to a list; the group never waits.

    Args:
        group: The threads that append to the list.
        vertex_boxes: (n_vertices, 9) f4, of the path.
        vertices: Tree of the vertices; its boxes are not used.
        edges: Tree of the edges.
        faces: Tree of the faces.
        pairs: (n, 2) i4, of `serial/query.py`; counts_out[PAIRS] says how many there are.
        counts_out: (N_COUNTS,) i8; OPEN is counted.
        open_out: (n, 2) i4, the list, which has as much room as `pairs`.
    """
    n = min(counts_out[PAIRS], pairs.shape[0])
    for i in range(group.rank(), n, group.size()):
        key, nodes = _key_and_nodes(i, pairs, vertices, edges, faces)
        if not is_settled(key >= EDGE_EDGE_FROM, nodes, vertex_boxes):
            at = group_add(group, counts_out, OPEN, 1)
            open_out[at, 0], open_out[at, 1] = pairs[i, 0], pairs[i, 1]


@compiled
def _append_contact(
    group: ThreadGroup,
    path: PathArrays,
    key: int,
    nodes: tuple[int, int, int, int],
    excluded: Indices,
    counts_out: Indices,
    contacts_out: ContactList,
) -> int:
    """Append a pair to the contacts unless it is proved apart or excluded; return its steps."""
    a1, a2, a3 = relative_nodes(path.start, nodes)
    b1, b2, b3 = relative_nodes(path.end, nodes)
    is_edge_edge = bool(key >= EDGE_EDGE_FROM)
    status, toi, direction, steps, _ = advance(is_edge_edge, a1, a2, a3, b1, b2, b3)
    if status != APART and not is_among(key, excluded):
        at = group_add(group, counts_out, CONTACTS, 1)
        if at < contacts_out.keys.shape[0]:
            contacts_out.keys[at], contacts_out.toi[at] = key, toi
            for k in range(4):
                contacts_out.nodes[at, k] = nodes[k]
            for axis in range(3):
                contacts_out.directions[at, axis] = direction[axis]
    return steps


@compiled
def append_contacts(
    group: ThreadGroup,
    path: PathArrays,
    vertices: Tree,
    edges: Tree,
    faces: Tree,
    pairs: Ints,
    excluded: Indices,
    counts_out: Indices,
    contacts_out: ContactList,
) -> tuple[int, int]:
    """Append the pairs that are not proved apart to the contacts; the group never waits.

    Args:
        group: The threads that append to the list.
        path: The path.
        vertices: Tree of the vertices; its boxes are not used.
        edges: Tree of the edges.
        faces: Tree of the faces.
        pairs: (n, 2) i4, of `append_open_pairs`; counts_out[OPEN] says how many there are.
        excluded: (m,) i8, keys of the pairs to ignore, ascending.
        counts_out: (N_COUNTS,) i8; CONTACTS is counted, also beyond the room.
        contacts_out: The list.

    Returns:
        The steps of all proofs of this thread, and those of its longest one.
    """
    steps, most = 0, 0
    for i in range(group.rank(), counts_out[OPEN], group.size()):
        key, nodes = _key_and_nodes(i, pairs, vertices, edges, faces)
        own = _append_contact(group, path, key, nodes, excluded, counts_out, contacts_out)
        steps += own
        most = max(most, own)
    return steps, most


@compiled
def count_open_crossings(
    group: ThreadGroup,
    positions: Positions,
    edges: Tree,
    faces: Tree,
    pairs: Ints,
    counts_out: Indices,
) -> None:
    """Count the edges and faces that are not certainly apart at rest; the group never waits.

    Args:
        group: The threads.
        positions: (n_vertices, 3) f8 [m].
        edges: Tree of the edges; its boxes are not used.
        faces: Tree of the faces.
        pairs: (n, 2) i4, of `append_edge_faces`; counts_out[PAIRS] says how many there are.
        counts_out: (N_COUNTS,) i8; OPEN is counted.
    """
    n = min(counts_out[PAIRS], pairs.shape[0])
    for i in range(group.rank(), n, group.size()):
        if crossing_status(i, pairs, edges.nodes, faces.nodes, positions) != APART:
            group_add(group, counts_out, OPEN, 1)


@compiled
def _compute_frame(path: PathArrays, i: int, contacts_out: ContactList) -> None:
    """Write the weights and the normal of contact i."""
    nodes = row4(contacts_out.nodes, i)
    a1, a2, a3 = relative_nodes(path.start, nodes)
    b1, b2, b3 = relative_nodes(path.end, nodes)
    is_edge_edge = contacts_out.keys[i] >= EDGE_EDGE_FROM
    toi, direction = contacts_out.toi[i], row3(contacts_out.directions, i)
    weights, normal = impact_frame(is_edge_edge, a1, a2, a3, b1, b2, b3, toi, direction)
    for k in range(4):
        contacts_out.weights[i, k] = weights[k]
    for axis in range(3):
        contacts_out.normals[i, axis] = normal[axis]


@compiled
def _copy_impact(i: int, contacts: ContactList, at: int, found_out: Impacts) -> None:
    """Copy contact i to an impact."""
    found_out.is_edge_edge[at] = contacts.keys[i] >= EDGE_EDGE_FROM
    found_out.toi[at] = contacts.toi[i]
    for k in range(4):
        found_out.nodes[at, k] = contacts.nodes[i, k]
        found_out.weights[at, k] = contacts.weights[i, k]
    for axis in range(3):
        found_out.normals[at, axis] = contacts.normals[i, axis]


@compiled
def sort_impacts(
    group: ThreadGroup,
    path: PathArrays,
    n_room: int,
    pinned: Flags,
    to_solve: bool,
    contacts_out: ContactList,
    sort_out: SortSpace,
    least_toi_out: Times,
    counts_out: Indices,
    found_out: Impacts,
) -> None:
    """Compute the frames of the contacts, and write them as impacts, sorted by their keys.

    Does nothing if there was no room for all pairs or for all contacts. The group does not wait at
    the end.

    Args:
        group: The threads.
        path: The path.
        n_room: Number of pairs for which there was room.
        pinned: (n_vertices,) b1.
        to_solve: Whether to leave out the impacts between pinned points. Then nothing is found if
            a contact is at the start: exact arithmetic has to decide first.
        contacts_out: The contacts, in any order; their frames are written.
        sort_out: Work space, with room for as many contacts.
        least_toi_out: (1,) f8, the memory of counts_out[LEAST_TOI].
        counts_out: (N_COUNTS,) i8; FOUND, BLOCKED, AT_START and LEAST_TOI are written.
        found_out: The impacts, with room for as many contacts.
    """
    n = counts_out[CONTACTS]
    if counts_out[PAIRS] > n_room or n > contacts_out.keys.shape[0]:
        return
    rank, size = group.rank(), group.size()
    blocked, at_start, least = 0.0, 0.0, 1.0
    for i in range(rank, n, size):
        _compute_frame(path, i, contacts_out)
        toi = contacts_out.toi[i]
        at_start += toi == 0.0
        if to_solve and is_prescribed(i, contacts_out.nodes, contacts_out.weights, pinned):
            blocked += 1.0
            sort_out.keys[i] = LAST_KEY
        else:
            least = min(least, toi)
            sort_out.keys[i] = contacts_out.keys[i]
    blocked, at_start, _ = group_sums(group, blocked, at_start, 0.0)
    highest, _ = group_maxima(group, -least, 0.0)
    n_found = 0 if to_solve and at_start > 0.0 else n - np.int64(blocked)
    if rank == 0:
        counts_out[FOUND], counts_out[BLOCKED] = n_found, np.int64(blocked)
        counts_out[AT_START] = np.int64(at_start)
        least_toi_out[0] = -highest
    places = sort_out.places
    group_sort(group, n, sort_out.keys, places, sort_out.other_keys, sort_out.other_places)
    for at in range(rank, n_found, size):
        _copy_impact(places[at], contacts_out, at, found_out)
