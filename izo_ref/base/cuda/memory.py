"""Memory of a GPU, and arrays in it that are made in a few microseconds.

An array of numba-cuda takes 26 us of Python on an H200, and 112 us with 10 MB. A step of a hundred
thousand triangles made four thousand of them. So memory that is no longer used is kept here in a
pool, sorted by size, and given to the next array of that size. All launches and copies go to the
default stream, so they run in the order in which Python asks for them, and memory can be used again
at once.
"""

from __future__ import annotations

import math
import sys
import threading
from contextlib import suppress
from functools import lru_cache
from importlib import import_module
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numba import cuda
from numba.cuda.core import config
from numba.cuda.cudadrv.driver import CudaAPIError
from numpy.typing import DTypeLike

from izo_ref.base.cuda.simulated import Driver, address_of
from izo_ref.base.errors import DeviceMemoryError

LEAST = 512  # bytes; smaller arrays get as many, and the driver aligns to 256
STEPS = 4  # sizes of the pool between two powers of 2, so that at most a fifth of a block is unused

# cuda.bindings is installed with numba-cuda
driver: Any = Driver() if config.ENABLE_CUDASIM else import_module("cuda.bindings.driver")

Kind: TypeAlias = tuple[np.dtype[Any], int, bool]  # dtype, number of axes, whether contiguous

_thread = threading.local()


def call_driver(function: Any, *arguments: Any) -> Any:
    """Call a function of the CUDA driver, and return what it returns besides the error code.

    Raises:
        CudaAPIError: The driver reports an error, perhaps one of an earlier launch.
    """
    if not hasattr(_thread, "ready"):  # the driver needs a context, in each thread
        cuda.current_context()
        _thread.ready = True
    error, *returned = function(*arguments)
    if error:
        raise CudaAPIError(int(error), f"{function.__name__}: {error.name}")
    return returned[0] if returned else None


def synchronize() -> None:
    """Wait until everything that was launched on the default stream has ended."""
    call_driver(driver.cuStreamSynchronize, 0)


def room_for(n_bytes: int) -> int:
    """Return the size of the block that the pool gives for some bytes [bytes]."""
    if n_bytes <= LEAST:
        return LEAST
    step = 1 << (n_bytes - 1).bit_length() >> STEPS.bit_length()
    return -(-n_bytes // step) * step


def _allocate(n_bytes: int) -> int | None:
    """Return the address of new memory; None if there is too little."""
    try:
        return int(call_driver(driver.cuMemAlloc, n_bytes))
    except CudaAPIError as error:
        if "OUT_OF_MEMORY" not in str(error):
            raise
        return None


class Pool:
    """Blocks of memory that were used and are free again, by their size."""

    def __init__(self) -> None:
        """Begin without blocks."""
        self._free: dict[int, list[int]] = {}

    def take(self, n_bytes: int) -> Block:
        """Return a block of at least this size.

        Raises:
            DeviceMemoryError: The GPU has less free memory; says what is needed, and what is free.
        """
        room = room_for(n_bytes)
        free = self._free.get(room)
        if free:
            with suppress(IndexError):  # another thread took the last one
                return Block(free.pop(), room, self)
        address = _allocate(room)
        if address is None:
            self.release()
            address = _allocate(room)
        if address is None:
            raise no_memory(room)
        return Block(address, room, self)

    def give_back(self, address: int, room: int) -> None:
        """Take back a block that nothing uses any more."""
        self._free.setdefault(room, []).append(address)

    def release(self) -> None:
        """Give all free blocks back to the driver."""
        for blocks in list(self._free.values()):
            while blocks:
                call_driver(driver.cuMemFree, blocks.pop())


class Block:
    """A block of memory, which goes back to its pool when the last array in it is gone.

    Attributes:
        address: Where it begins.
    """

    __slots__ = ("_pool", "_room", "address")

    def __init__(self, address: int, room: int, pool: Pool) -> None:
        """Keep the address."""
        self.address, self._room, self._pool = address, room, pool

    def __del__(self) -> None:
        """Give the block back."""
        if not sys.is_finalizing():
            self._pool.give_back(self.address, self._room)


def no_memory(n_bytes: int) -> DeviceMemoryError:
    """Return the error that says how much memory is needed and how much is free."""
    free, total = cuda.current_context().get_memory_info()
    return DeviceMemoryError(
        f"device 'cuda': {n_bytes / 2**20:.0f} MiB more are needed, {free / 2**20:.0f} of "
        f"{total / 2**20:.0f} MiB are free; use a larger GPU, or device 'cpu'"
    )


POOL = Pool()


class Layout(NamedTuple):
    """What arrays of one shape and dtype have in common.

    Attributes:
        n_bytes: Size of the values [bytes].
        strides: As `DeviceArray.strides`.
        kind: As `DeviceArray.kind`.
        before: `DeviceArray.fields` before the address.
        behind: `DeviceArray.fields` behind the address.
    """

    n_bytes: int
    strides: tuple[int, ...]
    kind: Kind
    before: tuple[int, ...]
    behind: tuple[int, ...]


@lru_cache(maxsize=4096)  # a step makes thousands of arrays, and most have a shape that was there
def layout_of(
    shape: tuple[int, ...], dtype: np.dtype[Any], strides: tuple[int, ...] | None
) -> Layout:
    """Return the layout of an array; without strides, that of a contiguous one."""
    n, size = math.prod(shape), dtype.itemsize
    contiguous = tuple(size * math.prod(shape[k + 1 :]) for k in range(len(shape)))
    own = contiguous if strides is None else strides
    kind = dtype, len(shape), own == contiguous
    return Layout(n * size, own, kind, (0, 0, n, size), (*shape, *own))


class DeviceArray:
    """An array in the memory of a GPU, with those parts of the interface of numba's that we use.

    Attributes:
        address: Where its first number is.
        shape: The shape.
        dtype: The dtype.
        strides: The distance of neighbours on each axis [bytes].
        fields: The array as numba hands it to a kernel: two pointers that are not used on a GPU,
            the number of values, the size of one, the address, the shape and the strides.
        kind: What the compiled code depends on: dtype, number of axes, whether it is contiguous.
    """

    __slots__ = ("_owner", "address", "dtype", "fields", "kind", "shape", "strides")

    def __init__(
        self,
        address: int,
        shape: tuple[int, ...],
        dtype: np.dtype[Any],
        owner: object,
        strides: tuple[int, ...] | None = None,
    ) -> None:
        """Describe memory.

        Args:
            address: Where the first number is.
            shape: The shape.
            dtype: The dtype.
            owner: What keeps the memory alive.
            strides: [bytes]; None if the array is contiguous, with the last axis fastest.
        """
        layout = layout_of(shape, dtype, strides)
        self.address, self.shape, self.dtype, self._owner = address, shape, dtype, owner
        self.strides, self.kind = layout.strides, layout.kind
        self.fields = (*layout.before, address, *layout.behind)

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.shape[0]

    @property
    def size(self) -> int:
        """Number of values."""
        return self.fields[2]

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        """The array as other libraries read it, on the default stream."""
        return {
            "shape": self.shape,
            "typestr": self.dtype.str,
            "data": (self.address if self.size else 0, False),
            "strides": None if self.kind[2] else self.strides,
            "version": 3,
        }

    def __getitem__(self, rows: slice) -> DeviceArray:
        """Return some neighbouring rows, in the same memory."""
        begin, end, step = rows.indices(self.shape[0])
        if step != 1:
            raise ValueError(f"rows: expected neighbours, not a step of {step}")
        address = self.address + begin * self.strides[0]
        shape = (max(end - begin, 0), *self.shape[1:])
        return DeviceArray(address, shape, self.dtype, self._owner, self.strides)

    def reshape(self, *shape: Any) -> DeviceArray:
        """Return the same memory with another shape of the same size; the array is contiguous."""
        shape = shape[0] if isinstance(shape[0], tuple) else shape
        return DeviceArray(self.address, shape, self.dtype, self._owner)

    def view(self, dtype: DTypeLike) -> DeviceArray:
        """Return the same memory, read as numbers of another dtype of the same size."""
        return DeviceArray(self.address, self.shape, np.dtype(dtype), self._owner, self.strides)

    def clear(self, byte: int = 0) -> None:
        """Overwrite every byte; the array is contiguous.

        Args:
            byte: The new value; floats become 0 by 0, and NaN by 255.
        """
        n_bytes = self.size * self.dtype.itemsize
        if n_bytes:
            call_driver(driver.cuMemsetD8Async, self.address, byte, n_bytes, 0)

    def copy_to_host(self) -> Any:
        """Return a copy on the CPU; the array is contiguous."""
        values = np.empty(self.shape, self.dtype)
        if self.size:
            call_driver(driver.cuMemcpyDtoH, values.ctypes.data, self.address, values.nbytes)
        return values

    def copy_to_device(self, values: Any) -> None:
        """Overwrite the numbers by those of an array of the same shape and dtype.

        Args:
            values: A contiguous array on the CPU or on the GPU.
        """
        n_bytes = self.size * self.dtype.itemsize
        if n_bytes and isinstance(values, np.ndarray):
            call_driver(driver.cuMemcpyHtoD, self.address, values.ctypes.data, n_bytes)
        elif n_bytes:
            call_driver(driver.cuMemcpyDtoDAsync, self.address, values.address, n_bytes, 0)


def new_array(shape: tuple[int, ...], dtype: DTypeLike) -> DeviceArray:
    """Return a new array, not written to.

    Raises:
        DeviceMemoryError: The GPU has less free memory; says what is needed, and what is free.
    """
    own = np.dtype(dtype)
    block = POOL.take(layout_of(shape, own, None).n_bytes)
    return DeviceArray(block.address, shape, own, block)


def array_at(array: Any) -> DeviceArray:
    """Return the memory of an array of numba or CuPy."""
    if config.ENABLE_CUDASIM:
        address = address_of(array)
    else:
        address = array.__cuda_array_interface__["data"][0]
    return DeviceArray(address, array.shape, array.dtype, array, array.strides)
