"""The sparse matrices of a large zone: values, factors and solutions."""

from numba import prange

from izo_ref.base.arrays import Floats, Ints, Normals, Offsets
from izo_ref.base.compile import cpu_kernel, light_kernel
from izo_ref.solvers.serial.fronts import Fronts, eliminate, solve_downwards, solve_upwards


@light_kernel
def weighted_gram(
    # In:
    slots: Ints,  # (n_impacts, 4, 4) i4, the value that each pair of vertices adds to; -1: none
    coefficients: Floats,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    weights: Floats,  # (n_impacts,) f8
    # Out:
    values_out: Floats,  # (n_values, 3, 3) f8, C^T diag(weights) C is added
) -> None:
    """Add C^T diag(weights) C to the values of a matrix."""
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
    fronts: Fronts,  # Fronts
    run_starts: Offsets,  # (n_runs + 1,) i8, where each run begins in runs
    runs: Ints,  # (n_fronts,) i4, fronts of one thread each; the last run waits for the others
    values: Floats,  # (n_values, size, size) f8
    smallest: float,  # f8, pivots of this or less are left out
    # Out:
    kept_out: Floats,  # (fronts.n_kept,) f8
    factor_out: Floats,  # (fronts.factor_starts[-1],) f8
) -> None:
    """Factor a matrix: all runs but the last at the same time, then the last run."""
    last = run_starts.shape[0] - 2
    for run in prange(last):
        chosen = runs[run_starts[run] : run_starts[run + 1]]
        eliminate(fronts, chosen, values, smallest, kept_out, factor_out)
    eliminate(fronts, runs[run_starts[last] :], values, smallest, kept_out, factor_out)


@cpu_kernel
def solve(
    # In:
    fronts: Fronts,  # Fronts
    run_starts: Offsets,  # (n_runs + 1,) i8, as in factorize
    runs: Ints,  # (n_fronts,) i4, as in factorize
    factor: Floats,  # (fronts.factor_starts[-1],) f8
    # Out:
    x_out: Floats,  # (n_blocks * size,) f8, the right-hand side on entry
    rests_out: Floats,  # (size * fronts.starts[-1],) f8, work space
) -> None:
    """Solve for one right-hand side with the factor of a matrix."""
    last = run_starts.shape[0] - 2
    for run in prange(last):
        chosen = runs[run_starts[run] : run_starts[run + 1]]
        solve_upwards(fronts, chosen, factor, x_out, rests_out)
    solve_upwards(fronts, runs[run_starts[last] :], factor, x_out, rests_out)
    solve_downwards(fronts, runs[run_starts[last] :], factor, x_out)
    for run in prange(last):
        chosen = runs[run_starts[run] : run_starts[run + 1]]
        solve_downwards(fronts, chosen, factor, x_out)
