"""The augmented-Lagrangian solver: one block a zone, or all blocks of a launch for a large zone.

Source: XRTailor documentation, "Impact Zone Optimization", figure `gpu_architecture`.
"""

from numba import cuda

from izo_ref.base.arrays import Floats
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import block, grid
from izo_ref.solvers.serial.descent import minimise_zone
from izo_ref.solvers.serial.records import Inputs, Results, WorkSpace
from izo_ref.solvers.serial.settings import Settings


@cuda_kernel
def solve_lagrangian(
    # In:
    inputs: Inputs,  # Inputs in f8 or f4, of solvers/serial/records.py
    settings: Settings,  # Settings
    # Out:
    results_out: Results,  # Results in f8 or f4
    work_out: WorkSpace,  # WorkSpace in f8 or f4
) -> None:
    """Solve zones, one block a zone."""
    k = cuda.blockIdx.x
    if k < inputs.zones.shape[0]:
        state = work_out.states[k, cuda.threadIdx.x]
        minimise_zone(inputs.zones[k], state, block(), inputs, settings, results_out, work_out)


@cuda_kernel
def solve_lagrangian_by_grid(
    # In:
    inputs: Inputs,  # Inputs in f8, of solvers/serial/records.py
    settings: Settings,  # Settings
    # Out:
    results_out: Results,  # Results in f8
    work_out: WorkSpace,  # WorkSpace in f8
    parts_out: Floats,  # (n_blocks, 7) f8, zeros, work space
) -> None:
    """Solve one zone with all blocks of the launch."""
    if inputs.zones.shape[0] == 1:
        group = grid(parts_out)
        state = work_out.states[0, group.rank()]
        minimise_zone(inputs.zones[0], state, group, inputs, settings, results_out, work_out)
