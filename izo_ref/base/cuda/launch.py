"""Launch kernels by the driver, with arguments packed by ourselves.

A launch by numba-cuda takes 16 us of Python on an H200 without arguments, 63 with 12 arrays, and
85 with a record of 10. So numba compiles kernels here, and our own
arrays, which know how they are handed to a kernel, are packed into memory that is ready.
"""

import ctypes
import struct
import threading
from collections.abc import Hashable
from typing import Any, NamedTuple

import numba
from numba.core import types
from numba.np.numpy_support import from_dtype

from izo_ref.base.cuda.memory import DeviceArray, call_driver, driver

# Codes of `struct` for scalars, by numba's name of their type.
CODES = {"bool": "?", "int8": "b", "int32": "i", "int64": "q", "float32": "f", "float64": "d"}
FIXED_SHARED = 48 << 10  # bytes of shared memory that a block gets without asking the driver


class Ready(NamedTuple):
    """A compiled kernel, and memory for its arguments.

    Attributes:
        handle: The kernel, of the driver.
        launch: The driver's function that launches it.
        pack: Packs all numbers of the arguments into memory.
        offsets: Where each number is in that memory [bytes].
        memory: That memory.
        places: The addresses of the arguments in that memory, for the driver.
    """

    handle: Any
    launch: Any
    pack: struct.Struct
    offsets: tuple[int, ...]
    memory: Any
    places: Any


class Prepared:
    """A launch whose arguments are packed once; to repeat it takes one call of the driver.

    The arrays are alive as long as this is.

    Args:
        ready: The compiled kernel, with memory of its own for these arguments.
        sizes: Blocks, threads and shared memory, as the driver takes them.
        arguments: The arguments.
    """

    def __init__(self, ready: Ready, sizes: tuple[int, ...], arguments: Any) -> None:
        """Keep what the driver needs."""
        self._ready, self._sizes, self._arguments = ready, sizes, arguments
        self._places = ctypes.addressof(ready.places)

    def __call__(self, stream: Any = 0) -> None:
        """Launch the kernel on a stream of the driver; on the default stream if none is given."""
        start(self._ready, self._sizes, self._places, stream)


class Launcher:
    """Launches a kernel on the default stream; it is compiled for each new combination of types.

    Args:
        dispatcher: The kernel, of numba-cuda.
    """

    def __init__(self, dispatcher: Any) -> None:
        """Compile nothing yet."""
        self._dispatcher = dispatcher
        self._ready: dict[Hashable, Ready] = {}
        self._shared: dict[Hashable, int] = {}
        self._lock = threading.Lock()

    def __call__(self, n_blocks: int, size: int, shared_bytes: int, arguments: Any) -> None:
        """Launch the kernel.

        Args:
            n_blocks: Blocks.
            size: Threads of a block.
            shared_bytes: Dynamic shared memory of a block [bytes].
            arguments: Arrays of the GPU, numbers, and records of these.
        """
        kinds: list[Hashable] = []
        numbers: list[Any] = []
        flatten(arguments, kinds, numbers)
        with self._lock:  # the driver copies the arguments before it returns
            ready = self._compiled(tuple(kinds), arguments, len(numbers), shared_bytes)
            ready.pack.pack_into(ready.memory, 0, *numbers)
            sizes = n_blocks, 1, 1, size, 1, 1, shared_bytes
            start(ready, sizes, ctypes.addressof(ready.places), 0)

    def prepare(self, n_blocks: int, size: int, shared_bytes: int, arguments: Any) -> Prepared:
        """Return a launch with these arguments that can be repeated; parameters as for a launch."""
        kinds: list[Hashable] = []
        numbers: list[Any] = []
        flatten(arguments, kinds, numbers)
        with self._lock:
            ready = self._compiled(tuple(kinds), arguments, len(numbers), shared_bytes)
        own = with_own_memory(ready)
        own.pack.pack_into(own.memory, 0, *numbers)
        return Prepared(own, (n_blocks, 1, 1, size, 1, 1, shared_bytes), arguments)

    def _compiled(self, key: Hashable, arguments: Any, n_numbers: int, shared_bytes: int) -> Ready:
        """Return the kernel for the types of some arguments; compile it if they are new."""
        ready = self._ready.get(key)
        if ready is None:
            ready = self._ready[key] = prepare(self._dispatcher, arguments, n_numbers)
        if shared_bytes > self._shared.get(key, FIXED_SHARED):
            self._allow(ready, shared_bytes)
            self._shared[key] = shared_bytes
        return ready

    @staticmethod
    def _allow(ready: Ready, shared_bytes: int) -> None:
        """Ask the driver for more shared memory than a block gets by itself."""
        name = driver.CUfunction_attribute.CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES
        device = call_driver(driver.cuCtxGetDevice)
        kernel = driver.CUkernel(int(ready.handle))
        call_driver(driver.cuKernelSetAttribute, name, shared_bytes, kernel, device)


def start(ready: Ready, sizes: tuple[int, ...], places: int, stream: Any) -> None:
    """Launch a kernel by the driver.

    Args:
        ready: The kernel.
        sizes: Blocks and threads on three axes each, and the shared memory [bytes].
        places: Address of the addresses of the arguments.
        stream: A stream of the driver, or 0.
    """
    more = () if ready.launch is driver.cuLaunchCooperativeKernel else (0,)
    call_driver(ready.launch, ready.handle, *sizes, stream, places, *more)


def flatten(arguments: Any, kinds_out: list[Hashable], numbers_out: list[Any]) -> None:
    """Collect the types of arguments, and the numbers by which they are handed to a kernel."""
    for argument in arguments:
        if argument.__class__ is DeviceArray:
            kinds_out.append(argument.kind)
            numbers_out.extend(argument.fields)
        elif isinstance(argument, tuple):
            kinds_out.append(argument.__class__)
            flatten(argument, kinds_out, numbers_out)
            kinds_out.append(None)  # the end of the record
        else:
            kinds_out.append(argument.__class__)
            numbers_out.append(argument)


def type_of(argument: Any) -> Any:
    """Return numba's type of an argument."""
    if isinstance(argument, DeviceArray):
        dtype, n_axes, is_contiguous = argument.kind
        return types.Array(from_dtype(dtype), n_axes, "C" if is_contiguous else "A")
    if isinstance(argument, tuple):
        own = argument.__class__ if hasattr(argument, "_fields") else None
        return types.BaseTuple.from_types(tuple(map(type_of, argument)), own)
    return numba.typeof(argument)


def code_of(kind: Any) -> str:
    """Return the codes of `struct` for an argument of a type."""
    if isinstance(kind, types.Array):
        return "q" * (5 + 2 * kind.ndim)
    if isinstance(kind, types.BaseTuple):
        return "".join(map(code_of, kind))
    return CODES[str(kind)]


def prepare(dispatcher: Any, arguments: Any, n_numbers: int) -> Ready:
    """Compile a kernel for the types of some arguments, or read it from disk."""
    own = tuple(map(type_of, arguments))
    kernel = dispatcher.compile(own)
    kernel.bind()
    codes = "".join(map(code_of, own))
    pack = struct.Struct("@" + codes)  # with the alignment of C, as a kernel has it
    ends = [struct.calcsize("@" + codes[: i + 1]) for i in range(n_numbers)]
    sizes = [struct.calcsize(code) for code in codes]
    offsets = tuple(end - size for end, size in zip(ends, sizes, strict=True))
    handle = driver.CUfunction(int(kernel._codelibrary.get_cufunc().handle))
    launch = driver.cuLaunchCooperativeKernel if kernel.cooperative else driver.cuLaunchKernel
    return with_own_memory(Ready(handle, launch, pack, offsets, None, None))


def with_own_memory(ready: Ready) -> Ready:
    """Return the same kernel with new memory for its arguments."""
    memory = ctypes.create_string_buffer(max(ready.pack.size, 1))
    begin = ctypes.addressof(memory)
    places = (ctypes.c_void_p * max(len(ready.offsets), 1))(*(begin + k for k in ready.offsets))
    return ready._replace(memory=memory, places=places)
