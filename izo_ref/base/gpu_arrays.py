"""Arrays in the memory of a GPU: make, copy, choose, sort, sum."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from izo_ref.base.arrays import AnyArray, GpuArray
from izo_ref.base.cuda import arrays as kernels
from izo_ref.base.cuda import memory
from izo_ref.base.cuda.arrays import ITEMS, TILE
from izo_ref.base.cuda.compile import THREADS, Kernel
from izo_ref.base.gpu_interop import has_cupy, order_by_cupy, own_array, shared_array
from izo_ref.base.records import SceneArrays


def empty(shape: int | tuple[int, ...], dtype: DTypeLike) -> GpuArray:
    """Return an array on the GPU that is not written to.

    Args:
        shape: The shape, or the length of an array with one axis.
        dtype: The dtype.

    Raises:
        DeviceMemoryError: The GPU has less free memory; says what is needed, and what is free.
    """
    return memory.new_array(shape if isinstance(shape, tuple) else (shape,), dtype)


def to_gpu(array: AnyArray) -> GpuArray:
    """Return a copy on the GPU of an array on the CPU."""
    result = empty(array.shape, array.dtype)
    if array.size:
        result.copy_to_device(np.ascontiguousarray(array))
    return result


def shared_copy(array: AnyArray) -> Any:
    """Return a copy on the GPU of an array on the CPU, as an array of numba, for the user."""
    return shared_array(to_gpu(array))


def copy(array: GpuArray) -> GpuArray:
    """Return a copy on the GPU of an array on the GPU."""
    result = empty(array.shape, array.dtype)
    if array.size:
        result.copy_to_device(array)
    return result


def to_cpu(array: GpuArray) -> Any:
    """Return a copy on the CPU of an array on the GPU."""
    if array.size == 0:
        return np.empty(array.shape, array.dtype)
    return array.copy_to_host()


def full(n: int, value: Any, dtype: Any) -> GpuArray:
    """Return (n,) copies of one value."""
    result = empty(n, dtype)
    kernels.fill[n](np.dtype(dtype).type(value), result)
    return result


def zeros(shape: tuple[int, ...], dtype: DTypeLike) -> GpuArray:
    """Return an array of zeros."""
    n = math.prod(shape)
    return full(n, 0, dtype).reshape(shape) if n else empty(shape, dtype)


def arange(n: int, first: int = 0) -> GpuArray:
    """Return (n,) i8: first, first + 1, ..."""
    result = empty(n, np.int64)
    kernels.count_up[n](first, result)
    return result


def _in_tiles(kernel: Kernel, n: int) -> Callable[..., None]:
    """Return the launch of a kernel on n values, where each block takes one tile."""
    return kernel.in_blocks(-(-n // TILE), min(-(-n // ITEMS), THREADS))


def offsets_of(values: GpuArray) -> GpuArray:
    """Return the sum of the values before each value, and the sum of all at the end.

    Args:
        values: (n,) i8 or b1, n > 0.

    Returns:
        (n + 1,) i8.
    """
    n = values.shape[0]
    totals, starts = empty(-(-n // TILE), np.int64), empty(n + 1, np.int64)
    _in_tiles(kernels.scan_tiles, n)(values, starts, totals)
    if totals.shape[0] > 1:
        kernels.add_tiles[n](offsets_of(totals), starts)
    return starts


def last_of(offsets: GpuArray) -> int:
    """Return the last number of an array of integers."""
    return int(to_cpu(offsets[offsets.shape[0] - 1 :])[0])


def flatnonzero(flags: GpuArray) -> GpuArray:
    """Return (n_true,) i8, where flags, (n,) b1, are true, ascending."""
    n = flags.shape[0]
    if n == 0:
        return empty(0, np.int64)
    if n <= TILE:
        index, count = empty(n, np.int64), empty(1, np.int64)
        _in_tiles(kernels.choose_in_tile, n)(flags, index, count)
        return index[: last_of(count)]
    starts = offsets_of(flags)
    index = empty(last_of(starts), np.int64)
    kernels.gather_chosen[n](starts, index)
    return index


def stable_argsort(keys: GpuArray) -> GpuArray:
    """Return the stable order that sorts keys.

    CuPy sorts long arrays where it is installed. Else each block sorts one tile; then sorted runs
    are merged in passes: runs of one tile, of two tiles, of four. In a pass, each key looks for its
    place among the keys of the neighbouring run.

    Args:
        keys: (n,) i8.

    Returns:
        (n,) i8, where each sorted key was.
    """
    n, width = keys.shape[0], TILE
    if n > TILE and has_cupy():
        return order_by_cupy(keys)
    own_keys, places = empty(n, np.int64), empty(n, np.int64)
    _in_tiles(kernels.sort_tiles, n)(keys, own_keys, places)
    while width < n:
        merged, merged_places = empty(n, np.int64), empty(n, np.int64)
        kernels.merge_runs[n](width, own_keys, places, merged, merged_places)
        own_keys, places, width = merged, merged_places, 2 * width
    return places


def take(values: GpuArray, index: GpuArray) -> GpuArray:
    """Return values[index] along the first axis."""
    rows = empty((index.shape[0], *values.shape[1:]), values.dtype)
    if rows.ndim == 1:
        kernels.take_rows[index.shape[0]](as_column(values), index, as_column(rows))
    else:
        kernels.take_rows[index.shape[0]](values, index, rows)
    return rows


def positions_of(scene: SceneArrays, name: str) -> GpuArray:
    """Return positions of a scene on the GPU, in the numbering of the scene.

    Positions that came from a GPU are read where they are.

    Args:
        scene: The scene.
        name: `positions_t0` or `positions_t1`.

    Returns:
        (n, 3) f8 [m].
    """
    array, order = scene.on_gpu.get(name, (None, None))
    if array is None:
        return to_gpu(getattr(scene, name))
    n = len(scene.pinned)
    rows = empty((n, 3), np.float64)
    kernels.take_rows[n](own_array(array), arange(n) if order is None else to_gpu(order), rows)
    return rows


def as_column(array: Any) -> Any:
    """Return an array (n,) as (n, 1), with the same memory; it may be on the CPU or on a GPU."""
    return array.reshape(array.shape[0], 1)


def concatenate(arrays: Sequence[GpuArray]) -> GpuArray:
    """Return the rows of several arrays of one dtype, one array after the other."""
    n = sum(array.shape[0] for array in arrays)
    result = empty((n, *arrays[0].shape[1:]), arrays[0].dtype)
    at = 0
    for array in arrays:
        if array.shape[0]:
            result[at : at + array.shape[0]].copy_to_device(array)
        at += array.shape[0]
    return result


def reduce(values: GpuArray, operation: int, column: int = 0) -> Any:
    """Return the sum, the largest or the least of the values of a column, as a number on the CPU.

    Tiles are combined first, then tiles of their results. So sums are the same from run to run.

    Args:
        values: (n, k) i8 or f8, n > 0.
        operation: SUM, LARGEST or LEAST of `base/cuda/arrays.py`.
        column: The column.
    """
    while True:
        results = empty(-(-values.shape[0] // TILE), values.dtype)
        _in_tiles(kernels.reduce_tiles, values.shape[0])(values, column, operation, results)
        if results.shape[0] == 1:
            return to_cpu(results)[0]
        values, column = as_column(results), 0
