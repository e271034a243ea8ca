"""The augmented-Lagrangian methods on a GPU: one block a zone, or all blocks for a large zone."""

from collections.abc import Callable
from typing import Any

import numpy as np

from izo_ref.base.cuda.thread_group import PARTS, WARP, shared_bytes
from izo_ref.base.devices import count_resident_blocks
from izo_ref.base.gpu_arrays import empty, last_of, to_cpu, to_gpu, zeros
from izo_ref.base.options import Options
from izo_ref.solvers.augmented_lagrangian import make_work_space
from izo_ref.solvers.cuda import lagrangian as kernels
from izo_ref.solvers.gpu_constraints import GpuConstraints, GpuSolution, Members
from izo_ref.solvers.gpu_sizes import zones_of_size
from izo_ref.solvers.gpu_variables import VariablesOnGpu
from izo_ref.solvers.serial.lagrangian import N_STATES
from izo_ref.solvers.serial.records import Inputs, Results
from izo_ref.solvers.serial.settings import Settings

# Threads of a block for zones of few impacts, and for other zones. With more than 256 threads, a
# thread has fewer registers than the kernel uses.
FEW, MANY = WARP, 256
# Most impacts of a zone that one block solves in float64. With more impacts, each thread of the
# block has more than 16 of them. Not measured yet.
LARGE = 4096
MOST = np.iinfo(np.int64).max


def solve_on_gpu(
    inputs: Inputs,
    settings: Settings,
    results: Results,
    n_threads: int,
    timed: Callable[[Callable[[], None]], Any] = lambda call: call(),
) -> Any:
    """Run the kernels on arrays of the GPU: one block a zone, or all blocks for a large zone.

    Args:
        inputs: Arrays of the GPU; all zones are solved.
        settings: Parameters of the loop.
        results: Arrays of the GPU, which are written.
        n_threads: Threads of a block.
        timed: Calls the function that launches the kernels, and may measure its time.

    Returns:
        What `timed` returns.
    """
    is_double = inputs.curvatures.dtype == np.float64
    most = LARGE if is_double else MOST
    bounds = (0, most), (most, MOST)
    small, large = (zones_of_size(inputs.impact_offsets, *sizes) for sizes in bounds)
    inputs, n_memory = inputs._replace(zones=small), last_of(inputs.memory_offsets)
    work = make_work_space(inputs, n_memory, n_threads, zeros)
    n_blocks, n_bytes = count_resident_blocks(), shared_bytes(n_threads)
    in_blocks = kernels.solve_lagrangian.in_blocks(small.shape[0], n_threads, n_bytes)
    by_grid = []
    for i in range(large.shape[0]):
        one = inputs._replace(zones=large[i : i + 1])
        states = zeros((1, n_blocks * n_threads, N_STATES), np.float64)
        launch = kernels.solve_lagrangian_by_grid.in_blocks(n_blocks, n_threads, n_bytes)
        parts = zeros((n_blocks, PARTS), np.float64)
        by_grid.append((launch, one, work._replace(states=states), parts))

    def run() -> None:
        in_blocks(inputs, settings, results, work)
        for launch, one, own, parts in by_grid:
            launch(one, settings, results, own, parts)

    return timed(run)


def solve_all(
    constraints: GpuConstraints,
    members: Members,
    thickness: float,
    options: Options,
    solution: GpuSolution,
) -> None:
    """Solve all zones.

    Args:
        constraints: The constraints of the zones.
        members: Which zones the impacts and vertices belong to.
        thickness: [m].
        options: An augmented-Lagrangian method or a preset, and the tolerances.
        solution: Its multipliers and z are written.
    """
    n_zones = solution.solved.shape[0]
    variables = VariablesOnGpu(constraints, members, thickness, options, MANY)
    results = Results(
        x=zeros((variables.inputs.curvatures.shape[0],), np.float64),
        multipliers=zeros((constraints.rhs.shape[0],), np.float64),
        steps=empty(n_zones, np.int32),
        gaps=empty(n_zones, np.float64),
        violations=empty(n_zones, np.float64),
        trace=empty((n_zones, 0, 2), np.float64),
    )
    solve_on_gpu(variables.inputs, variables.settings, results, MANY)
    variables.take_answers(results, solution)


def run_on_gpu(
    inputs: Inputs,
    settings: Settings,
    results: Results,
    timed: Callable[[Callable[[], None]], Any] = lambda call: call(),
) -> Any:
    """Run the kernels on arrays of the CPU; `run_on_cpu` has the same first three arguments.

    Args:
        inputs: Arrays of the CPU.
        settings: Parameters of the loop.
        results: Arrays of the CPU, which are written.
        timed: Calls the function that launches the kernels, and may measure its time.

    Returns:
        What `timed` returns.
    """
    own = Inputs._make(map(to_gpu, inputs))
    own_results = Results._make(map(to_gpu, results))
    largest = np.diff(inputs.impact_offsets).max()
    n_threads = FEW if largest <= FEW else MANY
    returned = solve_on_gpu(own, settings, own_results, n_threads, timed)
    for result, array in zip(results, own_results, strict=True):
        result[...] = to_cpu(array)
    return returned
