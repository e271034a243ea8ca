"""Compute the frames of impacts anew: their weights and normals."""

# The types of numba-cuda say that `cuda.grid` takes other arguments than it does.
# pyright: reportCallIssue=false

from numba import cuda

from izo_ref.base.arrays import Flags, Nodes, Normals, Positions, Weights
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.detection.formulas.frame import closest_frame
from izo_ref.detection.serial.contacts import relative_nodes, row4
from izo_ref.detection.serial.tight import is_tight


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
