"""Arrays in the memory of a GPU, and records of them: make, copy, put rows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from izo_ref.base.arrays import AnyArray, GpuArray
from izo_ref.base.cuda import arrays as kernels
from izo_ref.base.cuda.memory import empty
from izo_ref.base.gpu_interop import own_array, shared_array
from izo_ref.base.records import SceneArrays


def zeros(shape: int | tuple[int, ...], dtype: DTypeLike) -> GpuArray:
    """Return an array of zeros; arguments as of `empty`."""
    result = empty(shape, dtype)
    result.clear()
    return result


def full(n: int, value: Any, dtype: Any) -> GpuArray:
    """Return (n,) copies of one value."""
    return to_gpu(np.full(n, value, dtype))


def to_gpu(array: Any) -> Any:
    """Return a copy on the GPU of an array on the CPU, or of a record of such arrays."""
    if isinstance(array, tuple):
        return array.__class__(*map(to_gpu, array))
    return copy(np.ascontiguousarray(array))


def to_cpu(array: Any) -> Any:
    """Return a copy on the CPU of an array on the GPU, or of a record of such arrays."""
    if isinstance(array, tuple):
        return array.__class__(*map(to_cpu, array))
    return array.copy_to_host()


def copy(array: AnyArray | GpuArray) -> GpuArray:
    """Return a copy on the GPU of a contiguous array from either side."""
    result = empty(array.shape, array.dtype)
    result.copy_to_device(array)
    return result


def overwrite(array_out: Any, values: Any) -> None:
    """Overwrite the first rows of an array on the GPU, or of the first arrays of a record.

    Args:
        array_out: The array or the record.
        values: The rows, contiguous and from either side, or a record of them.
    """
    if isinstance(values, tuple):
        for own_out, own in zip(array_out, values, strict=False):
            overwrite(own_out, own)
    else:
        array_out[: values.shape[0]].copy_to_device(values)


def shared_copy(array: AnyArray) -> Any:
    """Return a copy on the GPU of an array on the CPU, as an array of numba, for the user."""
    return shared_array(to_gpu(array))


def put_rows(index: GpuArray, rows: GpuArray, values_out: Any) -> None:
    """Write rows to the places of an index, (n,) i8, which has each place once."""
    kernels.put_rows[index.shape[0]](index, _as_rows(rows), _as_rows(values_out))


def _as_rows(array: GpuArray) -> GpuArray:
    """Return an array (n,) as (n, 1), with the same memory; others stay."""
    return array.reshape(array.shape[0], 1) if array.ndim == 1 else array


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
    rows, index = empty((n, 3), np.float64), np.arange(n) if order is None else order
    kernels.take_rows[n](own_array(array), to_gpu(index), rows)
    return rows
