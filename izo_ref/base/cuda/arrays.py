"""Kernels that sort, take and fill arrays on a GPU; on the CPU numpy does it."""

from typing import Any

from numba import cuda

from izo_ref.base.arrays import AnyArray, Floats, Indices
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import grid
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


@cuda_kernel
def take_rows(
    # In:
    values: AnyArray,  # (n, k) i4 or f8 or i8 or b1 or i1
    index: Indices,  # (m,) i8
    # Out:
    rows_out: AnyArray,  # (m, k) i4 or f8 or i8 or b1 or i1
) -> None:
    """Copy the rows of an index."""
    i = cuda.grid(1)
    if i < index.shape[0]:
        for k in range(values.shape[1]):
            rows_out[i, k] = values[index[i], k]


@cuda_kernel
def fill(
    # In:
    value: Any,  # f8 or f4 or i8 or i4 or b1 or i1
    # Out:
    values_out: AnyArray,  # (n,) f8 or f4 or i8 or i4 or b1 or i1
) -> None:
    """Write one value everywhere."""
    i = cuda.grid(1)
    if i < values_out.shape[0]:
        values_out[i] = value
