"""Arrays in the memory of a GPU: make, copy, fill, sort."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from izo_ref.base.arrays import AnyArray, GpuArray
from izo_ref.base.cuda import arrays as kernels
from izo_ref.base.cuda import memory
from izo_ref.base.gpu_interop import own_array, shared_array
from izo_ref.base.gpu_launch import by_grid
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


def overwrite(array_out: GpuArray, values: AnyArray | GpuArray) -> None:
    """Overwrite an array on the GPU by one of the same shape and dtype, from either side."""
    if array_out.size:
        array_out.copy_to_device(values)


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
    result = empty(shape, dtype)
    result.clear()
    return result


def stable_argsort(keys: GpuArray) -> GpuArray:
    """Return the stable order that sorts keys: (n,) i8, where each sorted key, (n,) i8, was."""
    n = keys.shape[0]
    places, *others = (empty(n, np.int64) for _ in range(3))
    by_grid(kernels.sort_keys, n, copy(keys), places, *others)()
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
    rows = empty((len(scene.pinned), 3), np.float64)
    copy_positions(scene, name, rows)
    return rows


def copy_positions(scene: SceneArrays, name: str, rows_out: GpuArray) -> None:
    """Write positions of a scene to an array on the GPU; arguments as of `positions_of`.

    Args:
        scene: The scene.
        name: `positions_t0` or `positions_t1`.
        rows_out: (n, 3) f8 [m].
    """
    array, order = scene.on_gpu.get(name, (None, None))
    if array is None:
        rows_out.copy_to_device(np.ascontiguousarray(getattr(scene, name)))
        return
    n = len(scene.pinned)
    index = to_gpu(np.arange(n) if order is None else order)
    kernels.take_rows[n](own_array(array), index, rows_out)


def as_column(array: Any) -> Any:
    """Return an array (n,) as (n, 1), with the same memory; it may be on the CPU or on a GPU."""
    return array.reshape(array.shape[0], 1)
