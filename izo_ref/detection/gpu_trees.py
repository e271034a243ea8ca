"""Trees of elements on a GPU, and the keys of the pairs that a detection ignores."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Floats, GpuArray, Indices, Ints
from izo_ref.base.gpu_arrays import empty, stable_argsort, take, to_gpu
from izo_ref.base.records import SceneArrays
from izo_ref.base.sizes import near_mesh
from izo_ref.detection.cuda.tree import compute_morton_codes
from izo_ref.detection.serial.contacts import VERTEX_FACE_OFFSET
from izo_ref.detection.serial.tree import Tree
from izo_ref.detection.trees import bare_tree, box_frame, morton_grid


def make_trees(scene: SceneArrays, positions_t0: GpuArray) -> tuple[Tree, Tree, Tree]:
    """Return the trees of the vertices, edges and faces of a scene, with empty boxes.

    Args:
        scene: The scene.
        positions_t0: (n_vertices, 3) f8 [m], its start, on the GPU.
    """
    if len(scene.positions_t0):
        origin, cells_per_m = morton_grid(near_mesh(scene))
    else:
        origin, cells_per_m = np.zeros(3), 0.0
    grid = to_gpu(origin), cells_per_m
    vertices = np.sort(scene.tree_orders[0])  # without copies
    edges, faces = (np.arange(len(nodes), dtype=np.int32) for nodes in (scene.edges, scene.faces))
    return (
        _tree_over(vertices, vertices.reshape(-1, 1), positions_t0, grid),
        _tree_over(edges, scene.edges, positions_t0, grid),
        _tree_over(faces, scene.faces, positions_t0, grid),
    )


def _tree_over(
    numbers: Ints, nodes: Ints, positions_t0: GpuArray, grid: tuple[GpuArray, float]
) -> Tree:
    """Return a tree over elements, sorted along the Morton curve of a grid.

    Args:
        numbers: (n,) i4, numbers of the elements, on the CPU.
        nodes: (n, k) i4, vertices of the elements, on the CPU.
        positions_t0: (n_vertices, 3) f8 [m], on the GPU.
        grid: Origin (3,) [m], on the GPU, and cells per metre.
    """
    n = len(nodes)
    own_nodes, codes = to_gpu(nodes), empty(n, np.int64)
    compute_morton_codes[n](positions_t0, own_nodes, *grid, codes)
    index = stable_argsort(codes)
    bare = [to_gpu(array) for array in bare_tree(n, np.float32)]
    return Tree(take(to_gpu(numbers), index), take(own_nodes, index), *bare)


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
