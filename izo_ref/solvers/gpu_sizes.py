"""Choose zones on a GPU by their number of impacts."""

import numpy as np

from izo_ref.base.arrays import GpuArray
from izo_ref.base.gpu_arrays import empty, flatnonzero
from izo_ref.solvers.cuda import zones as kernels


def zones_of_size(impact_offsets: GpuArray, more_than: int, at_most: int) -> GpuArray:
    """Return (n,) i8: the zones with more impacts than one number, and at most another.

    Args:
        impact_offsets: (n_zones + 1,) i8.
        more_than: Impacts.
        at_most: Impacts.
    """
    flags = empty(impact_offsets.shape[0] - 1, np.bool_)
    kernels.flag_zones_of_size[flags.shape[0]](impact_offsets, more_than, at_most, flags)
    return flatnonzero(flags)
