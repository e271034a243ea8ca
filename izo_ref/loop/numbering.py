"""A numbering of the vertices that follows from the geometry alone.

Steps have ties: in regular meshes, impacts happen at equal times. What decides between them must
not depend on how the caller numbered the vertices, so `resolve` renumbers the scene along a Morton
curve. That also keeps neighbours close in memory.
"""

from __future__ import annotations

import copy

import numpy as np

from izo_ref.base.arrays import AnyInts, Edges, Faces, Indices
from izo_ref.base.records import Impacts, Pairs
from izo_ref.detection.trees import morton_codes_of
from izo_ref.scene import Scene

LARGEST_CORNER = (1 << 21) - 1  # three numbers up to this one fit into one of 63 bits


def geometric_order(scene: Scene) -> Indices:
    """Sort the vertices by Morton code, and vertices of one code by their coordinates.

    Args:
        scene: The scene in the numbering of the caller.

    Returns:
        (n_vertices,) i8, the caller's vertex at each place.
    """
    vertices = np.arange(len(scene.pinned), dtype=np.int32)[:, None]
    codes = morton_codes_of(scene.positions_t0, vertices)
    nearly = scene.tree_orders[0]  # so that sorting takes a quarter of the time
    order = nearly[np.argsort(codes[nearly], kind="stable")].astype(np.int64)
    if (np.diff(codes[order]) > 0).all():
        return order
    both = np.hstack((scene.positions_t0, scene.positions_t1))
    return np.lexsort((*both.T[::-1], codes))


def renumber_scene(scene: Scene, order: Indices) -> Scene:
    """Return the same scene with vertex `order[i]` as number i, and faces and edges to match.

    Args:
        scene: The scene in the numbering of the caller.
        order: (n_vertices,) i8, the caller's vertex at each place.
    """
    place = np.empty(len(order), np.int32)
    place[order] = np.arange(len(order))
    result = copy.copy(scene)
    for name in ("positions_t0", "positions_t1", "masses", "pinned"):
        setattr(result, name, np.ascontiguousarray(getattr(scene, name)[order]))
    result.on_gpu = {name: (array, order) for name, (array, _) in scene.on_gpu.items()}
    # In the order of the trees the keys are nearly sorted, and sorting takes a third of the time.
    _, edges, faces = scene.tree_orders
    result.faces = _canonical_faces(place[scene.faces[faces]])
    result.edges = _canonical_edges(place[scene.edges[edges]])
    # Elements that are sorted by their vertices on the curve are sorted in space: queries of the
    # trees take as long as with an order of their own.
    vertices, edges, faces = (
        np.arange(len(part), dtype=np.int32) for part in (order, result.edges, result.faces)
    )
    result.tree_orders = vertices, edges, faces
    result.components = scene.components.renumbered(order)
    if scene.excluded is not None:
        result.excluded = Pairs(place[scene.excluded.nodes], scene.excluded.is_edge_edge)
    return result


def _canonical_faces(faces: Faces) -> Faces:
    """Rotate each face until its smallest corner is first, and sort the faces."""
    a, b, c = faces.T.astype(np.int64)
    b_first, c_first = (b < a) & (b < c), (c < a) & (c < b)
    a, b, c = (
        np.where(b_first, y, np.where(c_first, z, x))
        for x, y, z in ((a, b, c), (b, c, a), (c, a, b))
    )
    if faces.max(initial=0) > LARGEST_CORNER:
        return np.column_stack((a, b, c))[np.lexsort((c, b, a))].astype(np.int32)
    # all three corners in one number, because sorting rows takes longer
    keys = np.sort(a << 42 | b << 21 | c, kind="stable")
    corners = keys >> 42, keys >> 21 & LARGEST_CORNER, keys & LARGEST_CORNER
    return np.column_stack(corners).astype(np.int32)


def _canonical_edges(edges: Edges) -> Edges:
    """Put the lower vertex of each edge first, and sort the edges."""
    a, b = edges.T
    keys = np.sort(np.minimum(a, b).astype(np.int64) << 32 | np.maximum(a, b), kind="stable")
    return np.column_stack((keys >> 32, keys & 0xFFFFFFFF)).astype(np.int32)


def restore_numbering(impacts: Impacts, order: Indices, faces: Faces) -> tuple[Impacts, Indices]:
    """Return impacts of the renumbered scene in the numbering of the caller.

    Corners come in the order of the caller's faces. Edges come with the lower vertex first, and
    the lower edge is on the first side. The impacts are sorted by kind and nodes.

    Args:
        impacts: Impacts of the renumbered scene.
        order: (n_vertices,) i8, the caller's vertex at each place.
        faces: (m, 3) i4, in the numbering of the caller.

    Returns:
        The impacts, and (n_impacts,) i8, the index that each had before.
    """
    nodes = order[impacts.nodes].astype(np.int32)
    weights, normals = impacts.weights.copy(), impacts.normals.copy()
    vf, ee = ~impacts.is_edge_edge, impacts.is_edge_edge

    corners = _corner_order(nodes[vf, 1:], faces, len(order))
    nodes[vf, 1:] = np.take_along_axis(nodes[vf, 1:], corners, 1)
    weights[vf, 1:] = np.take_along_axis(weights[vf, 1:], corners, 1)

    for side in (slice(0, 2), slice(2, 4)):
        ends = np.argsort(nodes[ee, side], axis=1)
        nodes[ee, side] = np.take_along_axis(nodes[ee, side], ends, 1)
        weights[ee, side] = np.take_along_axis(weights[ee, side], ends, 1)
    swap = ee & (
        (nodes[:, 0] > nodes[:, 2]) | ((nodes[:, 0] == nodes[:, 2]) & (nodes[:, 1] > nodes[:, 3]))
    )
    nodes[swap] = nodes[swap][:, [2, 3, 0, 1]]
    weights[swap] = -weights[swap][:, [2, 3, 0, 1]]
    normals[swap] = -normals[swap]

    index = np.lexsort((impacts.toi, *nodes.T[::-1], impacts.is_edge_edge))
    result = Impacts(nodes, impacts.is_edge_edge, impacts.toi, weights, normals)
    return result.take(index), index


def _corner_order(corners: AnyInts, faces: Faces, n_vertices: int) -> Indices:
    """Return (n, 3) i8, how to permute each row of corners to make it a row of faces."""
    if len(corners) == 0:
        return np.empty((0, 3), np.int64)
    wanted = np.zeros(n_vertices, bool)
    wanted[corners] = True
    a, b, c = faces.T
    faces = faces[wanted[a] & wanted[b] & wanted[c]]  # few faces are left to be sorted
    sorted_faces = np.sort(faces, axis=1)
    by_row = np.lexsort(sorted_faces.T[::-1])
    keys = np.ascontiguousarray(sorted_faces[by_row]).view([("", np.int32)] * 3).ravel()
    own = np.ascontiguousarray(np.sort(corners, axis=1)).view(keys.dtype).ravel()
    rows = faces[by_row[np.searchsorted(keys, own)]]
    return np.argmax(rows[:, :, None] == corners[:, None, :], axis=2)
