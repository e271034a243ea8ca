"""The augmented-Lagrangian methods on the device: a zone a block, or a large one by all blocks."""

import numpy as np

from izo_ref.base.cuda.thread_group import PARTS, WARP, shared_bytes
from izo_ref.base.devices import count_resident_blocks
from izo_ref.base.gpu_arrays import empty, flatnonzero, last_of, take, to_cpu, to_gpu, zeros
from izo_ref.solvers.augmented_lagrangian import Inputs, Results, work_space
from izo_ref.solvers.cuda import lagrangian as kernels
from izo_ref.solvers.gpu_variables import Variables

# Threads of a block: for zones of a few impacts, and for others. More than 256 would leave each
# fewer registers than the kernel has.
FEW, MANY = WARP, 256
# Impacts of a zone that one block solves, in float64: with more, each of its threads would have
# more than 16 rows. Not measured yet.
LARGE = 4096
MOST = np.iinfo(np.int64).max


def solve_on_gpu(inputs: Inputs, results: Results, n_threads: int, timed=lambda call: call()):
    """Run the kernels on arrays of the device: a block a zone, or all blocks if it is large.

    `timed` makes the call that runs them; what it returns is returned.
    """
    is_double = inputs.curvatures.dtype == np.float64
    most = LARGE if is_double else MOST
    offsets, bounds = inputs.impact_offsets, ((0, most), (most, MOST))
    small, large = (
        take(inputs.zones, flatnonzero(flag_zones_of_size(inputs.zones, offsets, *sizes)))
        for sizes in bounds
    )
    inputs, n_memory = inputs._replace(zones=small), last_of(inputs.memory_offsets)
    *shared, states = (zeros(*array) for array in work_space(inputs, n_memory, n_threads))
    n_blocks, n_bytes = count_resident_blocks(), shared_bytes(n_threads)
    in_blocks = kernels.solve_lagrangian.in_blocks(small.shape[0], n_threads, n_bytes)
    by_grid = []
    for i in range(large.shape[0]):
        one = inputs._replace(zones=large[i : i + 1])
        *_, own = work_space(one, n_memory, n_blocks * n_threads)
        launch = kernels.solve_lagrangian_by_grid.in_blocks(n_blocks, n_threads, n_bytes)
        parts = zeros((n_blocks, PARTS), np.float64)
        by_grid.append((launch, one, zeros(*own), parts))

    def run():
        in_blocks(*inputs, *results, *shared, states)
        for launch, one, own, parts in by_grid:
            launch(*one, *results, *shared, own, parts)

    return timed(run)


def flag_zones_of_size(zones, impact_offsets, more_than, at_most):
    """(n,) b1, which of the zones have more impacts than one number, and at most another."""
    n = zones.shape[0]
    flags = empty(n, np.bool_)
    kernels.flag_zones_of_size[n](zones, impact_offsets, more_than, at_most, flags)
    return flags


def solve_chosen(rows, members, chosen, thickness, options, solution):
    """Solve some of the zones, and judge which are solved.

    Args:
        rows: `Rows`, of the device.
        members: `Members` of the zones.
        chosen: (n_zones,) b1, those to solve.
        thickness: [m].
        options: `Options`, with one of the methods here, or a preset.
        solution: `Solution`, written.
    """
    zones = flatnonzero(chosen)
    if zones.shape[0] == 0:
        return
    variables = Variables(rows, members, chosen, zones, thickness, options, MANY)
    inputs, n_zones = variables.inputs, chosen.shape[0]
    results = Results(
        zeros((inputs.curvatures.shape[0],), np.float64),
        zeros((rows.rhs.shape[0],), np.float64),
        *(empty(n_zones, dtype) for dtype in (np.int32, np.float64, np.float64)),
        empty((n_zones, 0, 2), np.float64),
    )
    solve_on_gpu(inputs, results, MANY)
    variables.take_answers(results, solution)
    tolerances = options.gap_tolerance, options.violation_tolerance * thickness
    kernels.judge_zones[inputs.zones.shape[0]](
        inputs.zones, results.gaps, results.violations, *tolerances, solution.solved
    )


def run_on_gpu(inputs: Inputs, results: Results, timed=lambda call: call()):
    """The same on arrays of the processor, called as the processor's own is."""
    own = Inputs(*(to_gpu(column) for column in inputs[:-1]), inputs.settings)
    device_results = Results(*(to_gpu(column) for column in results))
    largest = np.diff(inputs.impact_offsets).max()
    n_threads = FEW if largest <= FEW else MANY
    said = solve_on_gpu(own, device_results, n_threads, timed)
    for result, array in zip(results, device_results, strict=True):
        result[...] = to_cpu(array)
    return said
