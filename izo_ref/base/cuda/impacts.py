"""Impacts on the device."""

from numba import cuda

from izo_ref.base.cuda.compile import cuda_kernel


@cuda_kernel
def take_impacts(
    # In:
    nodes,  # (n, 4) i4
    is_edge_edge,  # (n,) b1
    toi,  # (n,) f8
    weights,  # (n, 4) f8
    normals,  # (n, 3) f8
    index,  # (m,) i8
    # Out:
    nodes_out,  # (m, 4) i4
    is_edge_edge_out,  # (m,) b1
    toi_out,  # (m,) f8
    weights_out,  # (m, 4) f8
    normals_out,  # (m, 3) f8
):
    i = cuda.grid(1)
    if i < index.shape[0]:
        j = index[i]
        is_edge_edge_out[i], toi_out[i] = is_edge_edge[j], toi[j]
        for k in range(4):
            nodes_out[i, k], weights_out[i, k] = nodes[j, k], weights[j, k]
        for axis in range(3):
            normals_out[i, axis] = normals[j, axis]
