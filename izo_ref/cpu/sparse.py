"""Values of the sparse matrices of a large zone."""

from numba import prange

from izo_ref._jit import light_kernel


@light_kernel
def weighted_gram(
    # In:
    slots,  # (n_impacts, 4, 4) i4, the value of each pair of a row's unknowns; -1: none
    coefficients,  # (n_impacts, 4) f8
    normals,  # (n_impacts, 3) f8
    weights,  # (n_impacts,) f8
    # Out:
    values_out,  # (n_values, 3, 3) f8, C^T diag(weights) C is added
):
    for j in prange(weights.shape[0]):
        for k in range(4):
            for i in range(k, 4):
                slot = slots[j, k, i]
                if slot < 0:
                    continue
                both = weights[j] * coefficients[j, k] * coefficients[j, i]
                for row in range(3):
                    for column in range(3):
                        value = both * normals[j, row] * normals[j, column]
                        values_out[slot, row, column] += value
