"""The sparse matrices of a large zone: values, and factors."""

from numba import prange

from izo_ref._jit import cpu_kernel, light_kernel
from izo_ref.serial.fronts import eliminate


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


@cpu_kernel
def factorize(
    # In:
    fronts,  # Fronts
    run_starts,  # (n_runs + 1,) i8, into runs
    runs,  # (n_fronts,) i4, fronts that one thread takes; the last run follows all others
    values,  # (n_values, size, size) f8
    smallest,  # f8, pivots of this or less are left out
    # Out:
    kept_out,  # (fronts.n_kept,) f8
    factor_out,  # (fronts.factor_starts[-1],) f8
):
    last = run_starts.shape[0] - 2
    for run in prange(last):
        chosen = runs[run_starts[run] : run_starts[run + 1]]
        eliminate(fronts, chosen, values, smallest, kept_out, factor_out)
    eliminate(fronts, runs[run_starts[last] :], values, smallest, kept_out, factor_out)
