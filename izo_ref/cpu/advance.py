"""First contacts of candidate pairs, and the frames of the impacts among them."""

from numba import prange

from izo_ref._jit import compiled, cpu_kernel
from izo_ref.scalar.advance import advance
from izo_ref.scalar.frame import closest_frame, impact_frame
from izo_ref.scalar.vec3 import sub3


@compiled
def row3(array, i):
    return (array[i, 0], array[i, 1], array[i, 2])


@compiled
def relative_nodes(positions, nodes, i):
    """Nodes 1..3 of pair i relative to its node 0."""
    p0 = row3(positions, nodes[i, 0])
    return (
        sub3(row3(positions, nodes[i, 1]), p0),
        sub3(row3(positions, nodes[i, 2]), p0),
        sub3(row3(positions, nodes[i, 3]), p0),
    )


@cpu_kernel
def first_contacts(
    # In:
    positions_t0,  # (n_vertices, 3) f8  [m]
    positions_t1,  # (n_vertices, 3) f8  [m]
    nodes,  # (n_pairs, 4) i4
    is_edge_edge,  # b1, the same for all pairs
    # Out:
    statuses_out,  # (n_pairs,) i1, of scalar/advance.py
    toi_out,  # (n_pairs,) f8
    directions_out,  # (n_pairs, 3) f8
    steps_out,  # (n_pairs,) i4
):
    for i in prange(nodes.shape[0]):
        a1, a2, a3 = relative_nodes(positions_t0, nodes, i)
        b1, b2, b3 = relative_nodes(positions_t1, nodes, i)
        status, toi, direction, steps = advance(is_edge_edge, a1, a2, a3, b1, b2, b3)
        statuses_out[i] = status
        toi_out[i] = toi
        steps_out[i] = steps
        for axis in range(3):
            directions_out[i, axis] = direction[axis]


@cpu_kernel
def impact_frames(
    # In:
    positions_t0,  # (n_vertices, 3) f8  [m]
    positions_t1,  # (n_vertices, 3) f8  [m]
    nodes,  # (n_impacts, 4) i4
    is_edge_edge,  # (n_impacts,) b1
    toi,  # (n_impacts,) f8
    directions,  # (n_impacts, 3) f8
    # Out:
    weights_out,  # (n_impacts, 4) f8
    normals_out,  # (n_impacts, 3) f8
):
    for i in prange(nodes.shape[0]):
        a1, a2, a3 = relative_nodes(positions_t0, nodes, i)
        b1, b2, b3 = relative_nodes(positions_t1, nodes, i)
        weights, normal = impact_frame(
            is_edge_edge[i], a1, a2, a3, b1, b2, b3, toi[i], row3(directions, i)
        )
        for k in range(4):
            weights_out[i, k] = weights[k]
        for axis in range(3):
            normals_out[i, axis] = normal[axis]


@cpu_kernel
def closest_frames(
    # In:
    positions,  # (n_vertices, 3) f8  [m]
    nodes,  # (n_impacts, 4) i4
    is_edge_edge,  # (n_impacts,) b1
    # Out:
    weights_out,  # (n_impacts, 4) f8
    normals_out,  # (n_impacts, 3) f8
):
    for i in prange(nodes.shape[0]):
        q1, q2, q3 = relative_nodes(positions, nodes, i)
        weights, normal = closest_frame(is_edge_edge[i], q1, q2, q3)
        for k in range(4):
            weights_out[i, k] = weights[k]
        for axis in range(3):
            normals_out[i, axis] = normal[axis]
