"""The sparse matrices of a large zone: values, and factors."""

from numba import prange

from izo_ref.base.compile import cpu_kernel, light_kernel
from izo_ref.solvers.serial.fronts import eliminate, solve_downwards, solve_upwards


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
                    value = both * normals[j, row]
                    for column in range(3):
                        values_out[slot, row, column] += value * normals[j, column]


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


@cpu_kernel
def solve(
    # In:
    fronts,  # Fronts
    run_starts,  # as of factorize
    runs,  # as of factorize
    factor,  # (fronts.factor_starts[-1],) f8
    # Out:
    x_out,  # (n_blocks * size,) f8, the right-hand side on entry
    rests_out,  # (size * fronts.starts[-1],) f8, scratch
):
    last = run_starts.shape[0] - 2
    for run in prange(last):
        chosen = runs[run_starts[run] : run_starts[run + 1]]
        solve_upwards(fronts, chosen, factor, x_out, rests_out)
    solve_upwards(fronts, runs[run_starts[last] :], factor, x_out, rests_out)
    solve_downwards(fronts, runs[run_starts[last] :], factor, x_out)
    for run in prange(last):
        chosen = runs[run_starts[run] : run_starts[run + 1]]
        solve_downwards(fronts, chosen, factor, x_out)
