"""The augmented-Lagrangian methods on a GPU: one block a zone, or all blocks for a large zone."""

from collections.abc import Callable
from typing import Any

import numpy as np

from izo_ref.base.cuda.thread_group import PARTS, WARP, shared_bytes
from izo_ref.base.devices import count_resident_blocks
from izo_ref.base.gpu_arrays import to_cpu, to_gpu, zeros
from izo_ref.solvers.augmented_lagrangian import make_work_space
from izo_ref.solvers.cuda import lagrangian as kernels
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
    sizes = np.diff(inputs.impact_offsets)
    n_threads = FEW if sizes.max() <= FEW else MANY
    is_large = sizes > (LARGE if inputs.curvatures.dtype == np.float64 else MOST)
    small, large = (inputs.zones[own[inputs.zones]] for own in (~is_large, is_large))
    own, own_results = to_gpu(inputs._replace(zones=small)), to_gpu(results)
    work = make_work_space(own, int(inputs.memory_offsets[-1]), n_threads, zeros)
    n_blocks, n_bytes = count_resident_blocks(), shared_bytes(n_threads)
    launches = []
    if len(small):
        in_blocks = len(small), n_threads, own, settings, own_results, work
        launches.append(kernels.solve_lagrangian.prepare(*in_blocks, shared_bytes=n_bytes))
    for zone in large:
        states = zeros((1, n_blocks * n_threads, N_STATES), np.float64)
        parts, one = zeros((n_blocks, PARTS), np.float64), own._replace(zones=to_gpu(zone[None]))
        by_grid = n_blocks, n_threads, one, settings, own_results, work._replace(states=states)
        launches.append(
            kernels.solve_lagrangian_by_grid.prepare(*by_grid, parts, shared_bytes=n_bytes)
        )

    def run() -> None:
        for launch in launches:
            launch()

    returned = timed(run)
    for result, array in zip(results, own_results, strict=True):
        result[...] = to_cpu(array)
    return returned
