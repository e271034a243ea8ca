"""A numbering of the vertices that follows from the geometry alone.

Steps have ties: in regular meshes, impacts at equal times. Whatever decides them must not
depend on how the vertices happen to be numbered, so `resolve` works in this numbering,
along a Morton curve, which also keeps neighbours close in memory.
"""

import copy

import numpy as np

from izo_ref.base.mesh import edges_of
from izo_ref.base.records import Impacts, Pairs
from izo_ref.detection.trees import morton_codes_of

LARGEST_CORNER = (1 << 21) - 1  # of which three go into one number


def geometric_order(scene):
    """(n,) i8, vertex of each place: by Morton code, then by coordinates."""
    vertices = np.arange(len(scene.pinned), dtype=np.int32)[:, None]
    codes = morton_codes_of(scene.positions_t0, vertices)
    order = np.argsort(codes, kind="stable")
    if (np.diff(codes[order]) > 0).all():
        return order
    both = np.hstack((scene.positions_t0, scene.positions_t1))
    return np.lexsort((*both.T[::-1], codes))


def renumbered(scene, order):
    """The same scene with vertex order[i] as number i, and faces and edges to match."""
    place = np.empty(len(order), np.int32)
    place[order] = np.arange(len(order))
    result = copy.copy(scene)
    for name in ("positions_t0", "positions_t1", "masses", "pinned"):
        setattr(result, name, np.ascontiguousarray(getattr(scene, name)[order]))
    result.on_gpu = {name: (array, order) for name, (array, _) in scene.on_gpu.items()}
    result.faces = _canonical_faces(place[scene.faces])
    result.edges = edges_of(result.faces)
    if scene.excluded is not None:
        result.excluded = Pairs(place[scene.excluded.nodes], scene.excluded.is_edge_edge)
    return result


def _canonical_faces(faces):
    """Smallest corner first, orientation kept; rows sorted."""
    first = np.argmin(faces, axis=1)
    rows = np.arange(len(faces))[:, None]
    faces = faces[rows, (first[:, None] + np.arange(3)) % 3]
    if faces.max(initial=0) > LARGEST_CORNER:
        return np.ascontiguousarray(faces[np.lexsort(faces.T[::-1])])
    # all three in one number, for rows take longer to sort
    a, b, c = faces.T.astype(np.int64)
    keys = np.sort(a << 42 | b << 21 | c)
    corners = keys >> 42, keys >> 21 & LARGEST_CORNER, keys & LARGEST_CORNER
    return np.column_stack(corners).astype(np.int32)


def impacts_back(impacts: Impacts, order, faces):
    """Impacts of the renumbered scene in the numbering of the caller.

    Corners come in the order of the caller's faces, edges with the lower vertex first and
    the lower edge on the first side; sorted by kind and nodes.

    Returns:
        `Impacts`, and (n,) i8, the index each had before.
    """
    nodes = order[impacts.nodes].astype(np.int32)
    weights, normals = impacts.weights.copy(), impacts.normals.copy()
    vf, ee = ~impacts.is_edge_edge, impacts.is_edge_edge

    corners = _corner_order(nodes[vf, 1:], faces)
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


def _corner_order(corners, faces):
    """(n, 3), how to permute each row of corners so that it is a row of faces."""
    if len(corners) == 0:
        return np.empty((0, 3), np.int64)
    sorted_faces = np.sort(faces, axis=1)
    by_row = np.lexsort(sorted_faces.T[::-1])
    keys = np.ascontiguousarray(sorted_faces[by_row]).view([("", np.int32)] * 3).ravel()
    wanted = np.ascontiguousarray(np.sort(corners, axis=1)).view(keys.dtype).ravel()
    rows = faces[by_row[np.searchsorted(keys, wanted)]]
    return np.argmax(rows[:, :, None] == corners[:, None, :], axis=2)


def pairs_back(pairs: Pairs, order):
    """Pairs of the renumbered scene in the numbering of the caller."""
    return Pairs(order[pairs.nodes].astype(np.int32), pairs.is_edge_edge)
