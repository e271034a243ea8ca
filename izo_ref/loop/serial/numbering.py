"""Put the sides of impacts into the order of the caller's faces and edges."""

import numpy as np

from izo_ref.base.arrays import AnyInt, Faces, Flags, Indices, Nodes, Normals, Weights
from izo_ref.base.compile import compiled


@compiled
def order_sides(
    order: Indices,  # (n_places,) i8, the caller's vertex at each place, of all in faces
    faces: Faces,  # (n_faces, 3) i4, of the caller; the first one of those with the same corners
    is_edge_edge: Flags,  # (n,) b1
    nodes_out: Nodes,  # (n, 4) i4, places of the vertices; changed to vertices of the caller
    weights_out: Weights,  # (n, 4) f8; changed
    normals_out: Normals,  # (n, 3) f8; changed
) -> None:
    """Renumber the vertices of impacts, and put their corners and edges into the caller's order."""
    # impacts of faces with the same lowest vertex are in one list
    n_vertices = np.int64(0)
    for i in range(order.shape[0]):
        n_vertices = max(n_vertices, order[i] + 1)
    first, after = np.full(n_vertices, -1), np.empty(nodes_out.shape[0], np.int64)
    for j in range(nodes_out.shape[0]):
        for k in range(4):
            nodes_out[j, k] = order[nodes_out[j, k]]
        if is_edge_edge[j]:
            _order_edges(j, nodes_out, weights_out, normals_out)
        else:
            lowest = min(nodes_out[j, 1], nodes_out[j, 2], nodes_out[j, 3])
            after[j], first[lowest] = first[lowest], j
    for i in range(faces.shape[0] - 1, -1, -1):
        other = int(first[min(faces[i, 0], faces[i, 1], faces[i, 2])])
        while other >= 0:
            _order_corners(other, faces[i], nodes_out, weights_out)
            other = int(after[other])


@compiled
def _order_edges(j: AnyInt, nodes_out: Nodes, weights_out: Weights, normals_out: Normals) -> None:
    """Put the lower end of each edge first, and the lower edge on the first side."""
    for k in range(0, 4, 2):
        if nodes_out[j, k] > nodes_out[j, k + 1]:
            _swap(j, k, k + 1, nodes_out, weights_out)
    if (nodes_out[j, 0], nodes_out[j, 1]) > (nodes_out[j, 2], nodes_out[j, 3]):
        for k in range(2):
            _swap(j, k, k + 2, nodes_out, weights_out)
        for k in range(4):
            weights_out[j, k] = -weights_out[j, k]
        for axis in range(3):
            normals_out[j, axis] = -normals_out[j, axis]


@compiled
def _order_corners(j: AnyInt, face: Faces, nodes_out: Nodes, weights_out: Weights) -> None:
    """Put the corners into the order of a face, if that has the same corners."""
    for k in range(3):
        if face[k] not in (nodes_out[j, 1], nodes_out[j, 2], nodes_out[j, 3]):
            return
    for k in range(1, 3):
        for m in range(k + 1, 4):
            if nodes_out[j, m] == face[k - 1]:
                _swap(j, k, m, nodes_out, weights_out)


@compiled
def _swap(j: AnyInt, k: int, m: int, nodes_out: Nodes, weights_out: Weights) -> None:
    """Let nodes k and m change places."""
    nodes_out[j, k], nodes_out[j, m] = nodes_out[j, m], nodes_out[j, k]
    weights_out[j, k], weights_out[j, m] = weights_out[j, m], weights_out[j, k]
