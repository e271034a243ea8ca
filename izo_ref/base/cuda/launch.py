"""Launch kernels by the driver, with arguments packed by ourselves.

A launch by numba-cuda takes 16 us of Python on an H200 without arguments, 63 with 12 arrays, and
85 with a record of 10. So numba compiles kernels here, and the arguments of a launch are packed
once. To repeat the launch takes one call of the driver.
"""

import ctypes
import threading
from collections.abc import Iterator
from typing import Any

import numba
from numba.core import types
from numba.np.numpy_support import from_dtype

from izo_ref.base.cuda.memory import DeviceArray, call_driver, driver

# C types of scalars, by numba's name of their type.
C_TYPES = {
    "bool": ctypes.c_bool,
    "int8": ctypes.c_int8,
    "int32": ctypes.c_int32,
    "int64": ctypes.c_int64,
    "float32": ctypes.c_float,
    "float64": ctypes.c_double,
}
FIXED_SHARED = 48 << 10  # bytes of shared memory that a block gets without asking the driver

_one_compiles = threading.Lock()


class Launch:
    """A launch with fixed arguments; it is compiled for each new combination of their types.

    The arrays are alive as long as this is.

    Args:
        dispatcher: The kernel, of numba-cuda.
        n_blocks: Blocks, at least one.
        size: Threads of a block.
        shared_bytes: Dynamic shared memory of a block [bytes].
        arguments: Arrays of the GPU, numbers, and records of these.
    """

    def __init__(
        self, dispatcher: Any, n_blocks: int, size: int, shared_bytes: int, arguments: Any
    ) -> None:
        """Compile the kernel, or read it from disk, and pack the arguments."""
        with _one_compiles:
            kernel = dispatcher.compile(tuple(map(type_of, arguments)))
            kernel.bind()
            if shared_bytes > getattr(kernel, "allowed_bytes", FIXED_SHARED):
                kernel.allowed_bytes = shared_bytes
                allow(kernel, shared_bytes)
        handle = driver.CUfunction(int(kernel._codelibrary.get_cufunc().handle))
        sizes = n_blocks, 1, 1, size, 1, 1, shared_bytes
        numbers = list(numbers_of(arguments))
        places = (ctypes.c_void_p * max(len(numbers), 1))(*map(ctypes.addressof, numbers))
        self._kept_alive = arguments, numbers, places
        self._is_cooperative, self._call = kernel.cooperative, (handle, *sizes)
        self._places = ctypes.addressof(places)

    def __call__(self, stream: Any = 0) -> None:
        """Launch the kernel on a stream of the driver; on the default stream if none is given."""
        if self._is_cooperative:
            call_driver(driver.cuLaunchCooperativeKernel, *self._call, stream, self._places)
        else:
            call_driver(driver.cuLaunchKernel, *self._call, stream, self._places, 0)


def allow(kernel: Any, shared_bytes: int) -> None:
    """Ask the driver for more shared memory than a block of a kernel gets by itself."""
    name = driver.CUfunction_attribute.CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES
    device = call_driver(driver.cuCtxGetDevice)
    own = driver.CUkernel(int(kernel._codelibrary.get_cufunc().handle))
    call_driver(driver.cuKernelSetAttribute, name, shared_bytes, own, device)


def type_of(argument: Any) -> Any:
    """Return numba's type of an argument."""
    if isinstance(argument, DeviceArray):
        layout = "C" if argument.is_contiguous else "A"
        return types.Array(from_dtype(argument.dtype), argument.ndim, layout)
    if isinstance(argument, tuple):
        own = argument.__class__ if hasattr(argument, "_fields") else None
        return types.BaseTuple.from_types(tuple(map(type_of, argument)), own)
    return numba.typeof(argument)


def numbers_of(argument: Any) -> Iterator[Any]:
    """Yield the numbers, of types of C, by which an argument is handed to a kernel of numba."""
    if isinstance(argument, DeviceArray):
        # two pointers that are not used on a GPU, the number of values, and the size of one
        head = 0, 0, argument.size, argument.dtype.itemsize
        yield from map(
            ctypes.c_int64, (*head, argument.address, *argument.shape, *argument.strides)
        )
    elif isinstance(argument, tuple):
        for part in argument:
            yield from numbers_of(part)
    else:
        yield C_TYPES[str(numba.typeof(argument))](argument)
