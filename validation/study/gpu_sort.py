"""Sort keys by one launch of a GPU; the launches of a step sort by the same text."""

import numpy as np

from izo_ref.base.arrays import Floats, GpuArray, Indices
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import grid
from izo_ref.base.gpu_arrays import copy, empty
from izo_ref.base.gpu_launch import by_grid
from izo_ref.base.serial.group_sort import group_sort


@cuda_kernel
def sort_keys(
    # In:
    n: int,  # i8, number of keys
    # Out:
    keys_out: Indices,  # (n,) i8, become sorted; equal keys keep their order
    places_out: Indices,  # (n,) i8, where each of the sorted keys was
    other_keys_out: Indices,  # (n,) i8, work space
    other_places_out: Indices,  # (n,) i8, work space
    parts_out: Floats,  # (n_blocks, 7) f8, zeros at first, work space
) -> None:
    """Sort keys by all blocks of a launch."""
    group_sort(grid(parts_out), n, keys_out, places_out, other_keys_out, other_places_out)


def stable_argsort(keys: GpuArray) -> GpuArray:
    """Return the stable order that sorts keys: (n,) i8, where each sorted key, (n,) i8, was."""
    n = keys.shape[0]
    places, *others = (empty(n, np.int64) for _ in range(3))
    by_grid(sort_keys, n, copy(keys), places, *others)()
    return places
