"""Memory of a GPU, and arrays in it.

Each array has a block of memory of its own from the driver. To give a block or to take it back, the
driver waits until everything that was launched has ended. An array of numba-cuda, which is made in
the same way, takes 26 us on an H200, and 112 us with 10 MB. So arrays are made once a step, some
150 of them. An iteration makes none, and a test holds the code to that
(`validation/study/gpu_limits.py`).
"""

from __future__ import annotations

import math
import threading
from contextlib import suppress
from importlib import import_module
from typing import Any

import numpy as np
from numba import cuda
from numba.cuda.core import config
from numba.cuda.cudadrv.driver import CudaAPIError
from numpy.typing import DTypeLike

from izo_ref.base.arrays import GpuArray
from izo_ref.base.cuda.simulated import Driver
from izo_ref.base.errors import DeviceMemoryError

# cuda.bindings is installed with numba-cuda
driver: Any = Driver() if config.ENABLE_CUDASIM else import_module("cuda.bindings.driver")

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


# Addresses of blocks that nothing uses any more. Python may delete an array at any moment, also
# while launches are recorded, when the driver takes no memory back. So the driver gets these blocks
# back when it is asked for the next one.
unused_blocks: list[int] = []


class Block:
    """A block of memory, which is one of the unused blocks when the last array in it is gone.

    Args:
        n_bytes: Its size, at least 1 [bytes].

    Attributes:
        address: Where it begins.
    """

    def __init__(self, n_bytes: int) -> None:
        """Give unused blocks back to the driver, and ask it for this one.

        Raises:
            DeviceMemoryError: The GPU has less free memory; says what is needed, and what is free.
        """
        with suppress(IndexError):  # the list is empty, perhaps because of another thread
            while True:
                call_driver(driver.cuMemFree, unused_blocks.pop())
        try:
            self.address = int(call_driver(driver.cuMemAlloc, n_bytes))
        except CudaAPIError as error:
            if "OUT_OF_MEMORY" not in str(error):
                raise
            raise no_memory(n_bytes) from None
        self._unused = unused_blocks

    def __del__(self) -> None:
        """Let the driver have the block back, if it gave one."""
        if hasattr(self, "_unused"):
            self._unused.append(self.address)


def no_memory(n_bytes: int) -> DeviceMemoryError:
    """Return the error that says how much memory is needed and how much is free."""
    free, total = cuda.current_context().get_memory_info()
    return DeviceMemoryError(
        f"device 'cuda': {n_bytes / 2**20:.0f} MiB more are needed, {free / 2**20:.0f} of "
        f"{total / 2**20:.0f} MiB are free; use a larger GPU, or device 'cpu'"
    )


def contiguous_strides(shape: tuple[int, ...], dtype: np.dtype[Any]) -> tuple[int, ...]:
    """Return the strides of an array without gaps, whose last axis is the fastest one [bytes]."""
    return tuple(dtype.itemsize * math.prod(shape[k + 1 :]) for k in range(len(shape)))


class DeviceArray:
    """An array in the memory of a GPU, with those parts of the interface of numba's that we use.

    Args:
        address: Where its first number is.
        shape: The shape.
        dtype: The dtype.
        owner: What keeps the memory alive.
        strides: The distance of neighbours on each axis [bytes]; None if the array is contiguous.

    Attributes:
        address, shape, dtype, strides: As above; `strides` is never None.
        is_contiguous: Whether the array has no gaps, and the last axis is the fastest one.
    """

    __slots__ = ("_owner", "address", "dtype", "is_contiguous", "shape", "strides")

    def __init__(
        self,
        address: int,
        shape: tuple[int, ...],
        dtype: np.dtype[Any],
        owner: object,
        strides: tuple[int, ...] | None = None,
    ) -> None:
        """Describe memory."""
        self.address, self.shape, self.dtype, self._owner = address, shape, dtype, owner
        without_gaps = contiguous_strides(shape, dtype)
        self.strides = without_gaps if strides is None else strides
        self.is_contiguous = self.strides == without_gaps

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.shape[0]

    @property
    def size(self) -> int:
        """Number of values."""
        return math.prod(self.shape)

    @property
    def nbytes(self) -> int:
        """Size of all values [bytes]."""
        return self.size * self.dtype.itemsize

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
            "strides": None if self.is_contiguous else self.strides,
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
        if self.size:
            call_driver(driver.cuMemsetD8Async, self.address, byte, self.nbytes, 0)

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
        if self.size and isinstance(values, np.ndarray):
            call_driver(driver.cuMemcpyHtoD, self.address, values.ctypes.data, self.nbytes)
        elif self.size:
            call_driver(driver.cuMemcpyDtoDAsync, self.address, values.address, self.nbytes, 0)


def empty(shape: int | tuple[int, ...], dtype: DTypeLike) -> GpuArray:
    """Return an array on the GPU that is not written to.

    Args:
        shape: The shape, or the length of an array with one axis.
        dtype: The dtype.

    Raises:
        DeviceMemoryError: The GPU has less free memory; says what is needed, and what is free.
    """
    own, sizes = np.dtype(dtype), shape if isinstance(shape, tuple) else (shape,)
    block = Block(max(own.itemsize * math.prod(sizes), 1))
    return DeviceArray(block.address, sizes, own, block)
