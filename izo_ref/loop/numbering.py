"""A numbering of the vertices that follows from the geometry alone.

Steps have ties: in regular meshes, impacts happen at equal times. What decides between them must
not depend on how the caller numbered the vertices, so `resolve` renumbers the scene along a Morton
curve. That also keeps neighbours close in memory.
"""

from __future__ import annotations

import copy

import numpy as np

from izo_ref.base.arrays import Faces, Indices, Ints
from izo_ref.base.records import Impacts
from izo_ref.base.sizes import near_mesh
from izo_ref.detection.serial.mesh import renumbered_rows, sort_rows
from izo_ref.detection.trees import morton_codes_of
from izo_ref.loop.serial.numbering import order_sides
from izo_ref.scene import Scene


def geometric_order(scene: Scene) -> Indices:
    """Sort the vertices by Morton code, and vertices of one code by their coordinates.

    Copies of vertices are left out, so the loop knows nothing of them.

    Args:
        scene: The scene in the numbering of the caller.

    Returns:
        (n_vertices,) i8, the caller's vertex at each place.
    """
    vertices = np.arange(len(scene.pinned), dtype=np.int32)[:, None]
    codes = morton_codes_of(near_mesh(scene), vertices)
    nearly = scene.tree_orders[0]  # so that sorting takes a quarter of the time
    order = nearly[np.argsort(codes[nearly], kind="stable")].astype(np.int64)
    if (np.diff(codes[order]) > 0).all():
        return order
    order.sort()
    both = np.hstack((scene.positions_t0, scene.positions_t1))[order]
    return order[np.lexsort((*both.T[::-1], codes[order]))]


def renumber_scene(scene: Scene, order: Indices) -> Scene:
    """Return the same scene with vertex `order[i]` as number i, and faces and edges to match.

    Args:
        scene: The scene in the numbering of the caller.
        order: (n_vertices,) i8, the caller's vertex at each place.
    """
    place = np.empty(len(scene.pinned), np.int32)  # not set for copies: no element has one
    place[order] = np.arange(len(order))
    result = copy.copy(scene)
    result.copies = None
    for name in ("positions_t0", "positions_t1", "masses", "pinned"):
        setattr(result, name, getattr(scene, name).take(order, axis=0))
    result.on_gpu = {name: (array, order) for name, (array, _) in scene.on_gpu.items()}
    _, edges, faces = scene.tree_orders  # an order in which what is sorted is close in memory
    result.faces = _sorted_elements(place, scene.faces, faces)
    result.edges = _sorted_elements(place, scene.edges, edges)
    # Elements that are sorted by their vertices on the curve are sorted in space: queries of the
    # trees take as long as with an order of their own.
    vertices, edges, faces = (
        np.arange(len(part), dtype=np.int32) for part in (order, result.edges, result.faces)
    )
    result.tree_orders = vertices, edges, faces
    result.components = scene.components.renumbered(order)
    if scene.excluded is not None:
        result.excluded = scene.excluded._replace(nodes=place[scene.excluded.nodes])
    if scene.touching is not None:
        nodes, edge_faces = place[scene.touching.nodes], place[scene.touching.edge_faces]
        result.touching = scene.touching._replace(nodes=nodes, edge_faces=edge_faces)
    return result


def _sorted_elements(place: Ints, nodes: Ints, order: Ints) -> Ints:
    """Return elements with other numbers, each with its lowest vertex first, sorted."""
    rows = renumbered_rows(place, nodes, order)
    return rows.take(sort_rows(rows, len(place)), axis=0)


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
    impacts = restore_sides(impacts, order, faces)
    index = np.lexsort((impacts.toi, *impacts.nodes.T[::-1], impacts.is_edge_edge))
    return impacts.take(index), index


def restore_sides(impacts: Impacts, order: Indices, faces: Faces) -> Impacts:
    """Return impacts of the renumbered scene in the numbering of the caller, as they are sorted.

    The arguments and the order of corners and edges are those of `restore_numbering`.
    """
    nodes, kinds, toi, weights, normals = Impacts._make(column.copy() for column in impacts)
    order_sides(order, faces, kinds, nodes, weights, normals)
    return Impacts(nodes, kinds, toi, weights, normals)
