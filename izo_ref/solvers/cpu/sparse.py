"""The sparse matrices of a large zone: values, factors and solutions."""

from izo_ref.base.arrays import Flags, Floats, Ints, Normals, Offsets
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
    for j in range(weights.shape[0]):
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
    # Share:
    begin: int,  # i8, the first run of this share
    end: int,  # i8, behind the last one
    # In:
    fronts: Fronts,  # Fronts
    run_starts: Offsets,  # (n_runs + 1,) i8, where each run begins in runs
    runs: Ints,  # (n_fronts,) i4, fronts of one thread each; the last run waits for the others
    values: Floats,  # (n_values, size, size) f8
    smallest: float,  # f8, pivots of this or less are left out
    stop: Flags,  # (1,) b1, leave the rest out once it is set
    # Out:
    kept_out: Floats,  # (fronts.n_kept,) f8
    factor_out: Floats,  # (fronts.factor_starts[-1],) f8
) -> None:
    """Factor the fronts of some runs."""
    for run in range(begin, end):
        chosen = runs[run_starts[run] : run_starts[run + 1]]
        eliminate(fronts, chosen, values, smallest, stop, kept_out, factor_out)


@cpu_kernel
def solve(
    # Share:
    begin: int,  # i8, the first run of this share
    end: int,  # i8, behind the last one
    # In:
    upwards: bool,  # b1, from the leaves to the roots; else back
    fronts: Fronts,  # Fronts
    run_starts: Offsets,  # (n_runs + 1,) i8, as in factorize
    runs: Ints,  # (n_fronts,) i4, as in factorize
    factor: Floats,  # (fronts.factor_starts[-1],) f8
    # Out:
    x_out: Floats,  # (n_blocks * size,) f8, the right-hand side on entry
    rests_out: Floats,  # (size * fronts.starts[-1],) f8, work space of the way upwards
) -> None:
    """Solve for one right-hand side in the fronts of some runs, on the way upwards or back."""
    for run in range(begin, end):
        chosen = runs[run_starts[run] : run_starts[run + 1]]
        if upwards:
            solve_upwards(fronts, chosen, factor, x_out, rests_out)
        else:
            solve_downwards(fronts, chosen, factor, x_out)
