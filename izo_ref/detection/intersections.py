"""Find the elements of a mesh that intersect at rest, exactly.

A filter in floats decides almost all pairs; rational arithmetic decides the others.
"""

from collections.abc import Sequence

import numpy as np

from izo_ref.base.arrays import Edges, Faces, Ints, Positions
from izo_ref.base.exact import simplices_meet
from izo_ref.base.records import Pairs
from izo_ref.detection.cpu.contacts import find_crossings
from izo_ref.detection.detector import Detector
from izo_ref.detection.formulas.advance import APART, CONTACT, UNDECIDED
from izo_ref.detection.trees import Elements, meeting_pairs, vertex_boxes


def intersecting_pairs(
    positions: Positions, edges: Edges, faces: Faces
) -> tuple[list[tuple[str, str]], Pairs]:
    """Find the pairs that intersect at rest; touching is intersecting.

    A mesh intersects itself if an edge meets a face with which it shares no vertex, or if a
    vertex-face or edge-edge pair touches. Where an edge meets a face, each of the five vertex-face
    and edge-edge pairs of the two may start on the wrong side, so all five are returned. Two faces
    with the same three vertices lie on each other however they move; this is no intersection.

    Args:
        positions: (n_vertices, 3) f8 [m].
        edges: (n_edges, 2) i4.
        faces: (n_faces, 3) i4.

    Returns:
        For each intersection, descriptions of its two elements, such as ("edge (0, 1)",
        "face (2, 3, 4)"); and the `Pairs`, each once.
    """
    crossing = _crossing_edges(positions, edges, faces)
    touching = _touching_pairs(positions, edges, faces)
    found = [(f"edge {_ids(edges[e])}", f"face {_ids(faces[f])}") for e, f in crossing]
    for nodes, is_edge_edge in zip(*touching, strict=True):
        split = 2 if is_edge_edge else 1
        names = ("edge", "edge") if is_edge_edge else ("vertex", "face")
        found.append((f"{names[0]} {_ids(nodes[:split])}", f"{names[1]} {_ids(nodes[split:])}"))
    return found, _unique_pairs([_pairs_of_crossings(edges, faces, crossing), touching])


def _ids(nodes: Ints) -> tuple[int, ...]:
    return tuple(int(node) for node in nodes)


def _crossing_edges(positions: Positions, edges: Edges, faces: Faces) -> Ints:
    """Return the edge and the face of each edge that meets a face, (n, 2), sorted."""
    elements = Elements(edges, positions), Elements(faces, positions)
    boxes, every = vertex_boxes(positions, positions, positions), np.ones(len(positions), bool)
    for side in elements:
        side.refit(boxes, every)
    pairs = meeting_pairs(*elements)
    statuses = np.empty(len(pairs), np.int8)
    find_crossings(pairs, *(side.tree.nodes for side in elements), positions, statuses)
    near = statuses != APART
    pairs, statuses = pairs[near], statuses[near]
    found = np.column_stack([side.tree.order[pairs[:, k]] for k, side in enumerate(elements)])
    for i in np.flatnonzero(statuses == UNDECIDED):
        edge, face = found[i]
        if simplices_meet(positions[edges[edge]], positions[faces[face]]):
            statuses[i] = CONTACT
    found = found[statuses == CONTACT]
    return found[np.lexsort((found[:, 1], found[:, 0]))]


def _touching_pairs(positions: Positions, edges: Edges, faces: Faces) -> Pairs:
    """Return the vertex-face and edge-edge pairs that touch.

    The detector finds the pairs that may touch, as far as rounding can tell. Exact arithmetic
    decides which of them do.
    """
    detector = Detector(positions, edges, faces, start_is_free=False)
    near = detector.find(positions)
    sides = np.where(near.is_edge_edge, 2, 1)
    touch = [
        simplices_meet(positions[nodes[:k]], positions[nodes[k:]])
        for nodes, k in zip(near.nodes, sides, strict=True)
    ]
    touch = np.array(touch, bool)
    return Pairs(near.nodes[touch], near.is_edge_edge[touch])


def _pairs_of_crossings(edges: Edges, faces: Faces, crossing: Ints) -> Pairs:
    """Return the five vertex-face and edge-edge pairs of each edge and the face that it meets."""
    edge, face = edges[crossing[:, 0]], faces[crossing[:, 1]]
    parts = [np.column_stack((edge[:, k], face)) for k in range(2)]
    for k in range(3):
        side = np.sort(face[:, [k, (k + 1) % 3]], axis=1)
        swap = (side[:, 0] < edge[:, 0]) | ((side[:, 0] == edge[:, 0]) & (side[:, 1] < edge[:, 1]))
        parts.append(np.where(swap[:, None], np.hstack((side, edge)), np.hstack((edge, side))))
    kinds = np.repeat([False, True], [2 * len(edge), 3 * len(edge)])
    return Pairs(np.concatenate(parts).astype(np.int32), kinds)


def _unique_pairs(parts: Sequence[Pairs]) -> Pairs:
    rows = np.concatenate([np.column_stack((p.is_edge_edge, p.nodes)) for p in parts])
    rows = np.unique(rows, axis=0)
    return Pairs(rows[:, 1:].astype(np.int32), rows[:, 0].astype(bool))
