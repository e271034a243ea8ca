"""Compute the frames of impacts: their weights and normals."""

# The types of numba-cuda say that `cuda.grid` takes other arguments than it does.
# pyright: reportCallIssue=false

from numba import cuda

from izo_ref.base.arrays import Flags, Indices, Nodes, Normals, Positions, Times, Weights
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.detection.formulas.frame import closest_frame, impact_frame
from izo_ref.detection.serial.contacts import relative_nodes, row3, row4
from izo_ref.detection.serial.tight import is_tight


@cuda_kernel
def gather_impacts(
    # In:
    positions_t0: Positions,  # (n_vertices, 3) f8  [m]
    positions_t1: Positions,  # (n_vertices, 3) f8  [m]
    index: Indices,  # (n,) i8, the contact of each impact
    nodes: Nodes,  # (n_contacts, 4) i4
    is_edge_edge: Flags,  # (n_contacts,) b1
    toi: Times,  # (n_contacts,) f8
    directions: Normals,  # (n_contacts, 3) f8, the last ones that separated the sides
    # Out:
    nodes_out: Nodes,  # (n, 4) i4
    is_edge_edge_out: Flags,  # (n,) b1
    toi_out: Times,  # (n,) f8
    weights_out: Weights,  # (n, 4) f8
    normals_out: Normals,  # (n, 3) f8
) -> None:
    """Gather the impacts among the contacts, and compute their frames."""
    i = cuda.grid(1)
    if i < index.shape[0]:
        j = int(index[i])
        own, is_edge_edge_out[i], toi_out[i] = row4(nodes, j), is_edge_edge[j], toi[j]
        a1, a2, a3 = relative_nodes(positions_t0, own)
        b1, b2, b3 = relative_nodes(positions_t1, own)
        weights, normal = impact_frame(
            is_edge_edge[j], a1, a2, a3, b1, b2, b3, toi[j], row3(directions, j)
        )
        for k in range(4):
            nodes_out[i, k], weights_out[i, k] = own[k], weights[k]
        for axis in range(3):
            normals_out[i, axis] = normal[axis]


@cuda_kernel
def renew_tight_frames(
    # In:
    positions: Positions,  # (n_vertices, 3) f8  [m]
    nodes: Nodes,  # (n_impacts, 4) i4
    is_edge_edge: Flags,  # (n_impacts,) b1
    thickness: float,  # f8  [m]
    # Out:
    weights_out: Weights,  # (n_impacts, 4) f8, those of other impacts stay
    normals_out: Normals,  # (n_impacts, 3) f8, those of other impacts stay
) -> None:
    """Give each tight impact the frame at its closest points."""
    i = cuda.grid(1)
    is_one = i < nodes.shape[0]
    if is_one and is_tight(i, positions, nodes, weights_out, normals_out, thickness):
        q1, q2, q3 = relative_nodes(positions, row4(nodes, i))
        weights, normal = closest_frame(is_edge_edge[i], q1, q2, q3)
        for k in range(4):
            weights_out[i, k] = weights[k]
        for axis in range(3):
            normals_out[i, axis] = normal[axis]
