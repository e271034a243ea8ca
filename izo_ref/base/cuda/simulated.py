"""Memory and launches of numba's simulator, in which a GPU is Python on the CPU.

The arrays of `base/cuda/memory.py` are the same as on a GPU; their addresses are those of the CPU.
"""

import ctypes
from types import SimpleNamespace
from typing import Any

import numpy as np

UNWRITTEN = 0xFF  # in every byte of new memory, so floats that nobody wrote are NaN


class Driver:
    """The functions of the CUDA driver for memory, in the memory of the CPU; no stream matters."""

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

    def cuMemcpyDtoDAsync(self, target: int, source: int, n_bytes: int, _: int) -> tuple[int]:
        """Copy some bytes, and return 0."""
        return self.cuMemcpyHtoD(target, source, n_bytes)

    def cuMemsetD8Async(self, target: int, value: int, n: int, _: int) -> tuple[int]:
        """Set some bytes, and return 0."""
        ctypes.memset(target, value, n)
        return (0,)

    def cuStreamSynchronize(self, _: int) -> tuple[int]:
        """Return 0; everything has ended already."""
        return (0,)


class Launch:
    """A launch with fixed arguments; parameters as of `base/cuda/launch.py:Launch`."""

    def __init__(
        self, dispatcher: Any, n_blocks: int, size: int, shared_bytes: int, arguments: Any
    ) -> None:
        """Keep the arguments."""
        self._dispatcher, self._sizes = dispatcher, (n_blocks, size, 0, shared_bytes)
        self._arguments = arguments

    def __call__(self, _stream: Any = 0) -> None:
        """Run the kernel."""
        self._dispatcher[self._sizes](*map(as_simulated, self._arguments))


def as_simulated(argument: Any) -> Any:
    """Return an argument of a kernel as the simulator takes it, with the same memory."""
    if hasattr(argument, "address"):
        return array_of(argument)
    if isinstance(argument, tuple):
        values = map(as_simulated, argument)
        return argument.__class__(*values) if hasattr(argument, "_fields") else tuple(values)
    return argument


def array_of(array: Any) -> Any:
    """Return the memory of an array as the simulator takes it."""
    from numba.cuda.cudadrv.devicearray import FakeCUDAArray  # pyright: ignore

    # numpy reads the same description as other libraries do on a GPU, and keeps the array alive
    own = SimpleNamespace(__array_interface__=array.__cuda_array_interface__, array=array)
    return FakeCUDAArray(np.asarray(own))
