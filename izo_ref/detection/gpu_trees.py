"""Trees of elements on a GPU, and the keys of the pairs that a detection ignores."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Floats, Indices, Ints
from izo_ref.base.gpu_arrays import to_gpu
from izo_ref.base.records import SceneArrays
from izo_ref.detection.serial.contacts import VERTEX_FACE_OFFSET
from izo_ref.detection.serial.tree import Tree
from izo_ref.detection.trees import Elements, box_frame


def make_trees(scene: SceneArrays) -> tuple[Tree, Tree, Tree]:
    """Return the trees of the vertices, edges and faces of a scene, with empty boxes."""
    vertices = np.arange(len(scene.pinned), dtype=np.int32)[:, None]
    of_vertices, of_edges, of_faces = scene.tree_orders  # copies of vertices are in none
    return (
        to_gpu(Elements(vertices, of_vertices).tree),
        to_gpu(Elements(scene.edges, of_edges).tree),
        to_gpu(Elements(scene.faces, of_faces).tree),
    )


def frame_of_boxes(scene: SceneArrays) -> Floats:
    """Return the origin [m] and the scale [1/m] of the coordinates of boxes, (4,) f8."""
    if len(scene.positions_t0) == 0:
        return np.array([0.0, 0.0, 0.0, 1.0])
    origin, scale = box_frame(scene.positions_t0, scene.edges)
    return np.append(origin, scale)


def keys_to_ignore(scene: SceneArrays) -> Indices:
    """Return the keys of pairs that are excluded or touch at the start, as contacts have them."""
    parts = [part for part in (scene.excluded, scene.touching) if part is not None]
    if not parts:
        return np.empty(0, np.int64)
    nodes = np.concatenate([part.nodes for part in parts]).astype(np.int64)
    ee = np.concatenate([part.is_edge_edge for part in parts])
    twins = _rows_of(scene.faces)  # faces with the same corners have the same pairs
    vertex_face = [
        vertex << 32 | face
        for vertex, *corners in nodes[~ee].tolist()
        for face in twins[tuple(sorted(corners))]
    ]
    edges = _rows_of(scene.edges)
    edge_edge = []
    for a, b, c, d in nodes[ee].tolist():
        low, high = sorted((*edges[min(a, b), max(a, b)], *edges[min(c, d), max(c, d)]))
        edge_edge.append(low << 32 | high)
    keys = np.array(vertex_face, np.int64) + VERTEX_FACE_OFFSET, np.array(edge_edge, np.int64)
    return np.unique(np.concatenate(keys))


def _rows_of(rows: Ints) -> dict[tuple[int, ...], list[int]]:
    """Return the numbers of the rows that have some nodes, by these nodes in ascending order."""
    numbers: dict[tuple[int, ...], list[int]] = {}
    for i, row in enumerate(rows.tolist()):
        numbers.setdefault(tuple(sorted(row)), []).append(i)
    return numbers
