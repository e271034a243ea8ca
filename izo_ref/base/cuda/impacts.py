"""Kernels that gather impacts on a GPU."""

from numba import cuda

from izo_ref.base.arrays import Flags, Indices, Nodes, Normals, Times, Weights
from izo_ref.base.cuda.compile import cuda_kernel


@cuda_kernel
def take_impacts(
    # In:
    nodes: Nodes,  # (n, 4) i4
    is_edge_edge: Flags,  # (n,) b1
    toi: Times,  # (n,) f8
    weights: Weights,  # (n, 4) f8
    normals: Normals,  # (n, 3) f8
    index: Indices,  # (m,) i8
    # Out:
    nodes_out: Nodes,  # (m, 4) i4
    is_edge_edge_out: Flags,  # (m,) b1
    toi_out: Times,  # (m,) f8
    weights_out: Weights,  # (m, 4) f8
    normals_out: Normals,  # (m, 3) f8
) -> None:
    """Copy the impacts of an index."""
    i = cuda.grid(1)
    if i < index.shape[0]:
        j = index[i]
        is_edge_edge_out[i], toi_out[i] = is_edge_edge[j], toi[j]
        for k in range(4):
            nodes_out[i, k], weights_out[i, k] = nodes[j, k], weights[j, k]
        for axis in range(3):
            normals_out[i, axis] = normals[j, axis]
