"""The augmented-Lagrangian methods on the device, one zone a block."""

import numpy as np

from izo_ref.cuda import lagrangian as kernels
from izo_ref.cuda.team import WARP, shared_bytes
from izo_ref.descent import Inputs, Results, work_space
from izo_ref.gpu.arrays import on_device, on_host, total_of, zeros

# Threads of a block: for zones of a few impacts, and for others. More than 256 would leave each
# fewer registers than the kernel has.
FEW, MANY = WARP, 256


def solve_on_device(inputs: Inputs, results: Results, n_threads: int):
    """Run the kernel on arrays of the device."""
    work = work_space(inputs, total_of(inputs.memory_offsets), n_threads)
    kernels.solve_lagrangian.in_blocks(inputs.zones.shape[0], n_threads, shared_bytes(n_threads))(
        *inputs, *results, *(zeros(*array) for array in work)
    )


def solve_lagrangian(inputs: Inputs, results: Results):
    """The same on arrays of the processor, called as the processor's own is."""
    own = Inputs(*(on_device(column) for column in inputs[:-1]), inputs.settings)
    device_results = Results(*(on_device(column) for column in results))
    largest = np.diff(inputs.impact_offsets).max()
    solve_on_device(own, device_results, FEW if largest <= FEW else MANY)
    for result, array in zip(results, device_results, strict=True):
        result[...] = on_host(array)
