"""The augmented-Lagrangian methods on the device, called as those of the processor are."""

import numpy as np

from izo_ref.cuda import lagrangian as kernels
from izo_ref.gpu.arrays import on_device, on_host

RESULTS = slice(14, 18)  # x, multipliers, steps and trace; behind them only work space


def solve_lagrangian(*arguments):
    """Copy in, run one zone a thread, copy the results out.

    Args:
        arguments: of the kernel; arrays are those of the processor, and the outputs among
            them are written.
    """
    own = [on_device(a) if isinstance(a, np.ndarray) else a for a in arguments]
    n_zones = arguments[0].shape[0] - 1
    kernels.solve_lagrangian[n_zones](*own)
    for result, array in zip(arguments[RESULTS], own[RESULTS], strict=True):
        result[...] = on_host(array)
