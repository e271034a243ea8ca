"""Memory and launches of numba's simulator, in which a GPU is Python on the CPU.

The arrays of `base/cuda/memory.py` are the same as on a GPU; their addresses are those of the CPU.
"""

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

UNWRITTEN = 0xFF  # in every byte of new memory, so floats that nobody wrote are NaN


class Driver:
    """The functions of the CUDA driver for memory, in the memory of the CPU."""

    def __init__(self) -> None:
        """Begin without memory."""
        self._blocks: dict[int, Any] = {}

    def cuMemAlloc(self, n_bytes: int) -> tuple[int, int]:  # the driver's name
        """Return 0 and the address of new memory."""
        block = np.full(n_bytes, UNWRITTEN, np.uint8)
        address = block.ctypes.data
        self._blocks[address] = block
        return 0, address

    def cuMemFree(self, address: int) -> tuple[int]:
        """Give memory back, and return 0."""
        del self._blocks[address]
        return (0,)

    def cuMemcpyHtoD(self, target: int, source: int, n_bytes: int) -> tuple[int]:
        """Copy some bytes, and return 0."""
        ctypes.memmove(target, source, n_bytes)
        return (0,)

    def cuMemcpyDtoH(self, target: int, source: int, n_bytes: int) -> tuple[int]:
        """Copy some bytes, and return 0."""
        return self.cuMemcpyHtoD(target, source, n_bytes)

    def cuMemsetD8Async(self, target: int, value: int, n: int, _: int) -> tuple[int]:
        """Set some bytes, and return 0; the stream does not matter."""
        ctypes.memset(target, value, n)
        return (0,)

    def cuStreamSynchronize(self, _: int) -> tuple[int]:
        """Return 0; everything has ended already."""
        return (0,)

    def cuMemcpyDtoDAsync(self, target: int, source: int, n: int, _: int) -> tuple[int]:
        """Copy some bytes, and return 0; the stream does not matter."""
        return self.cuMemcpyHtoD(target, source, n)


class Described:
    """An array of `base/cuda/memory.py`, described as numpy reads it; keeps the array alive.

    Args:
        array: The array.
    """

    def __init__(self, array: Any) -> None:
        """Describe the array."""
        self.array = array
        self.__array_interface__ = {
            "shape": array.shape,
            "typestr": array.dtype.str,
            "data": (array.address, False),
            "strides": array.strides,
            "version": 3,
        }


def array_of(array: Any) -> Any:
    """Return the memory of an array as the simulator takes it."""
    from numba.cuda.cudadrv.devicearray import FakeCUDAArray  # pyright: ignore

    return FakeCUDAArray(np.asarray(Described(array)))


def address_of(array: Any) -> int:
    """Return where the first number of an array of the simulator is."""
    return array.ctypes.data


def launch(dispatcher: Any, n_blocks: int, size: int, shared_bytes: int, arguments: Any) -> None:
    """Run a kernel of the simulator.

    Args:
        dispatcher: The kernel, of the simulator.
        n_blocks: Blocks.
        size: Threads of a block.
        shared_bytes: Dynamic shared memory of a block [bytes].
        arguments: Arrays of `base/cuda/memory.py`, numbers, and records of these.
    """
    dispatcher[n_blocks, size, 0, shared_bytes](*map(_as_simulated, arguments))


class Launcher:
    """Launches a kernel of the simulator, with the methods of the launcher of a GPU.

    Args:
        dispatcher: The kernel, of the simulator.
    """

    def __init__(self, dispatcher: Any) -> None:
        """Keep the kernel."""
        self._dispatcher = dispatcher

    def __call__(self, n_blocks: int, size: int, shared_bytes: int, arguments: Any) -> None:
        """Run the kernel; parameters as of `launch`."""
        launch(self._dispatcher, n_blocks, size, shared_bytes, arguments)

    def prepare(
        self, n_blocks: int, size: int, shared_bytes: int, arguments: Any
    ) -> Callable[..., None]:
        """Return a launch that can be repeated with the same arguments."""

        def again(_stream: Any = 0) -> None:
            self(n_blocks, size, shared_bytes, arguments)

        return again


def _as_simulated(argument: Any) -> Any:
    if hasattr(argument, "address"):
        return array_of(argument)
    if isinstance(argument, tuple):
        values = map(_as_simulated, argument)
        return argument.__class__(*values) if hasattr(argument, "_fields") else tuple(values)
    return argument
