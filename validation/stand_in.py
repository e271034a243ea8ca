"""A driver of CUDA that stands in for one of a GPU: its memory is that of the CPU, or none.

With it the host code that runs on a GPU runs on a machine without one: numba-cuda's types, our own
packing of arguments, programs and copies. Kernels do not run.
"""

import ctypes
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

from validation import ptx

OUT_OF_MEMORY, ILLEGAL_ADDRESS, NOT_SUPPORTED = 2, 700, 801
STREAM = 5
ALIGNMENT = 512  # bytes, of addresses of memory that is not there
BYTES = 1 << 40
# The GPU that the host code sees. The numbers are those of an H200.
GPU = SimpleNamespace(
    name=b"stand-in",
    compute_capability=(9, 0),
    MULTIPROCESSOR_COUNT=132,
    MAX_SHARED_MEMORY_PER_BLOCK_OPTIN=227 << 10,
)


class Code(int):
    """An error code of the driver."""

    name = property(
        lambda self: {OUT_OF_MEMORY: "CUDA_ERROR_OUT_OF_MEMORY"}.get(self, "CUDA_ERROR_OTHER")
    )


class Driver:
    """A driver whose memory is that of the CPU; it notes what it is asked for.

    The names of the methods and the order of their arguments are those of `cuda.bindings.driver`.

    Attributes:
        left: Free memory [bytes].
        blocks: Memory that was given, by its address.
        launches: (kernel, sizes, address of the addresses of arguments) of each kernel that ran.
        asked: Shared memory that kernels were allowed [bytes].
        graphs: Graphs that were made and not destroyed: the launches of each.
        started: Graphs that ran.
        can_record: Whether launches can be recorded as a graph.
    """

    CUstreamCaptureMode = SimpleNamespace(CU_STREAM_CAPTURE_MODE_THREAD_LOCAL=1)
    CUfunction = CUkernel = int
    CUfunction_attribute = SimpleNamespace(CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES=8)

    def __init__(self, n_bytes: int = 1 << 20) -> None:
        """Begin with some free memory."""
        self.left, self.blocks = n_bytes, dict[int, Any]()
        self.launches, self.asked = list[Any](), list[int]()
        self.graphs, self.started = dict[int, Any](), list[int]()
        self.can_record = True
        self._recording: list[Any] | None = None

    def cuMemAlloc(self, n: int, /) -> Any:
        """Give memory."""
        if n > self.left:
            return Code(OUT_OF_MEMORY), None
        self.left -= n
        block = ctypes.create_string_buffer(n)
        self.blocks[ctypes.addressof(block)] = block
        return Code(0), ctypes.addressof(block)

    def cuMemFree(self, address: int, /) -> Any:
        """Take memory back."""
        self.left += len(self.blocks.pop(address))
        return (Code(0),)

    def cuMemcpyHtoD(self, target: int, source: int, n: int, /) -> Any:
        """Copy some bytes to the GPU."""
        ctypes.memmove(target, source, n)
        return (Code(0),)

    def cuMemcpyDtoH(self, target: int, source: int, n: int, /) -> Any:
        """Copy some bytes to the host."""
        ctypes.memmove(target, source, n)
        return (Code(0),)

    def cuMemcpyDtoDAsync(self, target: int, source: int, n: int, _stream: Any, /) -> Any:
        """Copy some bytes inside the memory of the GPU."""
        ctypes.memmove(target, source, n)
        return (Code(0),)

    def cuMemsetD8Async(self, target: int, value: int, n: int, _stream: Any, /) -> Any:
        """Set some bytes."""
        ctypes.memset(target, value, n)
        return (Code(0),)

    def cuLaunchKernel(self, handle: Any, /, *rest: Any) -> Any:
        """Note a launch, or record it."""
        sizes, places = rest[:8], rest[8]
        own = self.launches
        if self._recording is not None and sizes[7] == STREAM:
            own = self._recording
        own.append((handle, sizes, places))
        return (Code(0),)

    def cuLaunchCooperativeKernel(self, handle: Any, /, *rest: Any) -> Any:
        """Note a launch whose blocks wait for each other."""
        return self.cuLaunchKernel(("cooperative", handle), *rest)

    def cuCtxGetDevice(self) -> Any:
        """Return the number of the GPU."""
        return Code(0), 0

    def cuKernelSetAttribute(self, _name: Any, value: int, _kernel: Any, _device: Any, /) -> Any:
        """Note the shared memory that a kernel is allowed."""
        self.asked.append(value)
        return (Code(0),)

    def cuStreamSynchronize(self, _stream: Any, /) -> Any:
        """Wait for nothing."""
        return (Code(0),)

    def cuStreamCreate(self, _flags: int, /) -> Any:
        """Make a stream."""
        return Code(0), STREAM

    def cuStreamDestroy(self, _stream: Any, /) -> Any:
        """Destroy a stream."""
        return (Code(0),)

    def cuStreamBeginCapture(self, _stream: Any, _mode: Any, /) -> Any:
        """Begin to record launches."""
        if not self.can_record:
            return (Code(NOT_SUPPORTED),)
        self._recording = []
        return (Code(0),)

    def cuStreamEndCapture(self, _stream: Any, /) -> Any:
        """Return the recorded launches."""
        recorded, self._recording = self._recording, None
        return Code(0), recorded

    def cuGraphInstantiate(self, graph: Any, _flags: int, /) -> Any:
        """Return a graph that can run."""
        self.graphs[len(self.graphs)] = graph
        return Code(0), len(self.graphs) - 1

    def cuGraphDestroy(self, _graph: Any, /) -> Any:
        """Forget the recorded launches."""
        return (Code(0),)

    def cuGraphExecDestroy(self, graph: int, /) -> Any:
        """Forget a graph."""
        del self.graphs[graph]
        return (Code(0),)

    def cuGraphLaunch(self, graph: int, _stream: Any, /) -> Any:
        """Note the launches of a graph."""
        self.started.append(graph)
        self.launches.extend(self.graphs[graph])
        return (Code(0),)


class Replay(Driver):
    """A driver without memory; the host reads what was read in an earlier run.

    Attributes:
        reads: The bytes of the copies to the host that are still to come.
    """

    def __init__(self, reads: Sequence[bytes]) -> None:
        """Keep what is to be read."""
        super().__init__(BYTES)
        self.reads, self._next = list(reads), ALIGNMENT

    def cuMemAlloc(self, n: int, /) -> Any:
        """Give an address that nothing else has."""
        address, self._next = self._next, self._next + -(-n // ALIGNMENT) * ALIGNMENT
        return Code(0), address

    def cuMemFree(self, _address: int, /) -> Any:
        """Do nothing."""
        return (Code(0),)

    def cuMemcpyHtoD(self, _target: int, _source: int, _n: int, /) -> Any:
        """Copy nothing."""
        return (Code(0),)

    def cuMemcpyDtoDAsync(self, _target: int, _source: int, _n: int, _stream: Any, /) -> Any:
        """Copy nothing."""
        return (Code(0),)

    def cuMemsetD8Async(self, _target: int, _value: int, _n: int, _stream: Any, /) -> Any:
        """Set nothing."""
        return (Code(0),)

    def cuMemcpyDtoH(self, target: int, _source: int, n: int, /) -> Any:
        """Return the bytes that the earlier run read here.

        Raises:
            ValueError: The earlier run read another number of bytes, or nothing any more.
        """
        expected = self.reads.pop(0) if self.reads else b""
        if len(expected) != n:
            raise ValueError(f"read: expected {len(expected)} bytes as before, got {n}")
        ctypes.memmove(target, expected, n)
        return (Code(0),)

    def cuLaunchKernel(self, _handle: Any, /, *rest: Any) -> Any:
        """Run nothing; keep what is recorded."""
        if self._recording is not None and rest[7] == STREAM:
            self._recording.append(rest)
        return (Code(0),)

    def cuGraphLaunch(self, _graph: int, _stream: Any, /) -> Any:
        """Run nothing."""
        return (Code(0),)


class Checked:
    """A dispatcher that compiles nothing, and checks types.

    Args:
        name: Name of the kernel in messages.
        kernel: The kernel.
    """

    def __init__(self, name: str, kernel: Any) -> None:
        """Read the types of the contract."""
        self._name, self._known = name, list(ptx.signatures(kernel).values())

    def compile(self, signature: tuple[Any, ...]) -> Any:
        """Return what stands in for a compiled kernel.

        Raises:
            TypeError: The types are not those of the contract, which ptxas compiled.
        """
        if signature not in self._known:
            raise TypeError(f"{self._name}: expected types of {self._known}, got {signature}")
        library = SimpleNamespace(get_cufunc=lambda: SimpleNamespace(handle=1))
        return SimpleNamespace(bind=int, cooperative=False, _codelibrary=library)


@contextmanager
def driving(driver: Driver) -> Iterator[None]:
    """Let the host code of this process use a driver that stands in for one of a GPU.

    Nothing is compiled, but every launch checks that the types of all arguments are those of the
    contract of the kernel.

    Args:
        driver: The driver.
    """
    from numba import cuda

    from izo_ref.base.cuda import launch, memory, program

    context = SimpleNamespace(get_memory_info=lambda: (driver.left, BYTES))
    with ExitStack() as stack:
        for module in (memory, launch, program):
            stack.enter_context(patch.object(module, "driver", driver))
        stack.enter_context(patch.object(memory, "unused_blocks", []))
        stack.enter_context(patch.object(memory, "_thread", threading.local()))
        stack.enter_context(patch.object(cuda, "current_context", lambda: context))
        stack.enter_context(patch.object(cuda, "get_current_device", lambda: GPU))
        stack.enter_context(patch.object(cuda, "is_available", lambda: True))
        for name, kernel in ptx.kernels():
            stack.enter_context(patch.object(kernel, "_dispatcher", Checked(name, kernel)))
        yield
