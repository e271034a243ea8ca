"""First contacts of candidate pairs, which of them are certain, and their frames."""

from numba import prange

from izo_ref._jit import compiled, cpu_kernel, light_kernel
from izo_ref.scalar.advance import APART, advance
from izo_ref.scalar.frame import closest_frame, impact_frame
from izo_ref.scalar.meeting import certainly_meets
from izo_ref.scalar.vec3 import sub3


@compiled
def row3(array, i):
    return (array[i, 0], array[i, 1], array[i, 2])


@compiled
def row4(array, i):
    return (array[i, 0], array[i, 1], array[i, 2], array[i, 3])


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
def candidate_nodes(pairs, i, first_order, first_nodes, second_order, second_nodes):
    """The four vertices of candidate i; of two edges the one with the lower index first."""
    a, b = pairs[i, 0], pairs[i, 1]
    if first_nodes.shape[1] == 1:
        return (first_nodes[a, 0], second_nodes[b, 0], second_nodes[b, 1], second_nodes[b, 2])
    if first_order[a] > second_order[b]:
        return (second_nodes[b, 0], second_nodes[b, 1], first_nodes[a, 0], first_nodes[a, 1])
    return (first_nodes[a, 0], first_nodes[a, 1], second_nodes[b, 0], second_nodes[b, 1])


@cpu_kernel
def first_contacts(
    # In:
    positions_t0,  # (n_vertices, 3) f8  [m]
    positions_t1,  # (n_vertices, 3) f8  [m]
    pairs,  # (n_pairs, 2) i4, places of the first and the second element
    first_order,  # (n_first,) i8, index of the element in each place
    first_nodes,  # (n_first, 1 or 2) i4, vertices or edges
    second_order,  # (n_second,) i8
    second_nodes,  # (n_second, 3 or 2) i4, faces or edges
    # Out:
    nodes_out,  # (n_pairs, 4) i4, written unless the pair is apart, as are those below
    statuses_out,  # (n_pairs,) i1, of scalar/advance.py, always written
    toi_out,  # (n_pairs,) f8
    directions_out,  # (n_pairs, 3) f8
    steps_out,  # (n_pairs,) i4, always written
):
    for i in prange(pairs.shape[0]):
        nodes = candidate_nodes(pairs, i, first_order, first_nodes, second_order, second_nodes)
        a1, a2, a3 = relative_nodes(positions_t0, nodes)
        b1, b2, b3 = relative_nodes(positions_t1, nodes)
        status, toi, direction, steps = advance(first_nodes.shape[1] == 2, a1, a2, a3, b1, b2, b3)
        statuses_out[i] = status
        steps_out[i] = steps
        if status != APART:
            toi_out[i] = toi
            for k in range(4):
                nodes_out[i, k] = nodes[k]
            for axis in range(3):
                directions_out[i, axis] = direction[axis]


@light_kernel
def certain_meetings(
    # In:
    positions_t0,  # (n_vertices, 3) f8  [m]
    positions_t1,  # (n_vertices, 3) f8  [m]
    nodes,  # (n_pairs, 4) i4
    is_edge_edge,  # (n_pairs,) b1
    toi,  # (n_pairs,) f8, until when each is proved apart
    # Out:
    meets_out,  # (n_pairs,) b1, True if the pair meets, False if that is not certain
):
    for i in prange(nodes.shape[0]):
        a1, a2, a3 = relative_nodes(positions_t0, row4(nodes, i))
        b1, b2, b3 = relative_nodes(positions_t1, row4(nodes, i))
        meets_out[i] = certainly_meets(is_edge_edge[i], a1, a2, a3, b1, b2, b3, toi[i])


@light_kernel
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
        a1, a2, a3 = relative_nodes(positions_t0, row4(nodes, i))
        b1, b2, b3 = relative_nodes(positions_t1, row4(nodes, i))
        weights, normal = impact_frame(
            is_edge_edge[i], a1, a2, a3, b1, b2, b3, toi[i], row3(directions, i)
        )
        for k in range(4):
            weights_out[i, k] = weights[k]
        for axis in range(3):
            normals_out[i, axis] = normal[axis]


@light_kernel
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
        q1, q2, q3 = relative_nodes(positions, row4(nodes, i))
        weights, normal = closest_frame(is_edge_edge[i], q1, q2, q3)
        for k in range(4):
            weights_out[i, k] = weights[k]
        for axis in range(3):
            normals_out[i, axis] = normal[axis]
