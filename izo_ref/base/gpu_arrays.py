"""Arrays that live on the device: sums, choices, orders."""

import math

import numpy as np
from numba import cuda
from numba.cuda.cudadrv.driver import CudaAPIError

from izo_ref.base.cuda import arrays as kernels
from izo_ref.base.cuda.arrays import ITEMS, TILE
from izo_ref.base.cuda.compile import THREADS
from izo_ref.base.errors import DeviceMemoryError
from izo_ref.base.gpu_interop import has_cupy, order_by_cupy, viewed


def empty(shape, dtype):
    """An array on the device, not written to.

    Raises:
        DeviceMemoryError: with what is needed, and what is free.
    """
    shape = shape if isinstance(shape, tuple) else (shape,)
    room = (max(shape[0], 1), *shape[1:])
    try:
        array = cuda.device_array(room, dtype)
        # never else: of an array with a length of 0 behind it a slice has one row
        return array if shape[0] else array[:0]
    except CudaAPIError as error:
        if "OUT_OF_MEMORY" not in str(error):
            raise
        need = math.prod(room) * np.dtype(dtype).itemsize
        free, total = cuda.current_context().get_memory_info()
        raise DeviceMemoryError(
            f"device 'cuda': {need / 2**20:.0f} MiB more are needed, {free / 2**20:.0f} of "
            f"{total / 2**20:.0f} MiB are free; use a larger GPU, or device 'cpu'"
        ) from error


def to_gpu(array):
    """A copy on the device."""
    result = empty(array.shape, array.dtype)
    if array.size:
        result.copy_to_device(np.ascontiguousarray(array))
    return result


def copy(array):
    """Another array of the device with the same content."""
    result = empty(array.shape, array.dtype)
    if array.size:
        result.copy_to_device(array)
    return result


def to_cpu(array):
    """A copy of the processor."""
    if array.size == 0:
        return np.empty(array.shape, array.dtype)
    return array.copy_to_host()


def full(n, value, dtype):
    """(n,) of one value."""
    result = empty(n, dtype)
    kernels.fill[n](np.dtype(dtype).type(value), result)
    return result


def zeros(shape, dtype):
    """An array of zeros."""
    n = math.prod(shape)
    return full(n, 0, dtype).reshape(shape) if n else empty(shape, dtype)


def arange(n, first=0):
    """(n,) i8, first, first + 1, ..."""
    result = empty(n, np.int64)
    kernels.count_up[n](first, result)
    return result


def _in_tiles(kernel, n):
    """The kernel for n values, of which each thread takes some."""
    return kernel.in_blocks(-(-n // TILE), min(-(-n // ITEMS), THREADS))


def offsets_of(values):
    """(n + 1,) i8, the sum of the values before each, and of all; n is not 0."""
    n = values.shape[0]
    totals, starts = empty(-(-n // TILE), np.int64), empty(n + 1, np.int64)
    _in_tiles(kernels.scan_tiles, n)(values, starts, totals)
    if totals.shape[0] > 1:
        kernels.add_tiles[n](offsets_of(totals), starts)
    return starts


def last_of(starts):
    """The last of them, on the processor."""
    return int(to_cpu(starts[starts.shape[0] - 1 :])[0])


def flatnonzero(flags):
    """(n_true,) i8, where flags are true, ascending."""
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


def stable_argsort(keys):
    """(n,) i8, the stable order that sorts keys, (n,) i8, ascending.

    By CuPy where it is installed. Else tiles are sorted by a block each; then runs are merged, of
    one tile, of two, of four: passes in which each key looks for its place among those of the run
    beside it.
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


def take(values, index):
    """values[index] along the first axis."""
    rows = empty((index.shape[0], *values.shape[1:]), values.dtype)
    if rows.ndim == 1:
        kernels.take_rows[index.shape[0]](as_column(values), index, as_column(rows))
    else:
        kernels.take_rows[index.shape[0]](values, index, rows)
    return rows


def positions_of(scene, name):
    """(n, 3) f8 [m], positions of a scene; read where they are if they came from a device."""
    array, order = scene.on_gpu.get(name, (None, None))
    if array is None:
        return to_gpu(getattr(scene, name))
    n = len(scene.pinned)
    rows = empty((n, 3), np.float64)
    kernels.take_rows[n](viewed(array), arange(n) if order is None else to_gpu(order), rows)
    return rows


def as_column(array):
    """(n, 1) of (n,), the same memory."""
    return array.reshape(array.shape[0], 1)


def concatenate(parts):
    """One after the other."""
    n = sum(part.shape[0] for part in parts)
    result = empty((n, *parts[0].shape[1:]), parts[0].dtype)
    at = 0
    for part in parts:
        if part.shape[0]:
            result[at : at + part.shape[0]].copy_to_device(part)
        at += part.shape[0]
    return result


def reduce(values, operation, column=0):
    """SUM, LARGEST or LEAST of a column of (n, k) i8 or f8, n > 0; on the processor.

    In tiles, then tiles of tiles: sums are the same from run to run.
    """
    while True:
        results = empty(-(-values.shape[0] // TILE), values.dtype)
        _in_tiles(kernels.reduce_tiles, values.shape[0])(values, column, operation, results)
        if results.shape[0] == 1:
            return to_cpu(results)[0]
        values, column = as_column(results), 0
