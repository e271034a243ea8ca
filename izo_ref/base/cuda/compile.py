"""The only place with compile options of a GPU; `base/compile.py` has those of the CPU.

Kernels call the functions of `formulas/` and `serial/`, which numba compiles again for the GPU. The
GPU contracts products and sums to one rounding (FMA), and numba has no switch for that. The bounds
of `formulas/` hold all the same, because each operation still has at most one rounding. The bits
may differ from those of the CPU.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

from numba import cuda
from numba.cuda.core import config

from izo_ref.base.compile import CACHE_FOLDER, why_not_kept
from izo_ref.base.kept_code import CodeFiles, Place, say_not_kept

if config.ENABLE_CUDASIM:  # the simulator has no driver
    from izo_ref.base.cuda.simulated import Launch
else:
    from izo_ref.base.cuda.launch import Launch

THREADS = 128  # threads of a block, where a kernel asks for no other number


def device_function(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that only kernels of a GPU call."""
    return cuda.jit(function, device=True, fastmath=False)


def keep_on_disk(dispatcher: Any) -> None:
    """Keep the compiled code of a kernel on disk, in the way of the CPU's: `base/kept_code.py`.

    Args:
        dispatcher: The kernel, of numba-cuda.
    """
    reason = why_not_kept()
    if reason is None:
        dispatcher._cache = _cache_class()(dispatcher.py_func)
    else:
        say_not_kept(reason)


@cache
def _cache_class() -> Callable[[Any], Any]:
    """Return numba-cuda's class for kernels on disk, with our folder and our files.

    The simulator has no such class, so it is made when it is first needed.
    """
    from numba.cuda import dispatcher, serialize

    class Implementation(dispatcher.CUDACacheImpl):
        _locator_classes = (Place(CACHE_FOLDER / "cuda"),)

    class KeptKernels(dispatcher.CUDACache):
        _impl_class = Implementation

        def __init__(self, function: Any) -> None:
            super().__init__(function)
            locator, name = self._impl.locator, self._impl.filename_base
            self._cache_file = CodeFiles(
                self.cache_path, name, locator.get_source_stamp(), serialize.dumps
            )

    return KeptKernels


class Kernel:
    """A kernel of a GPU, launched on the default stream, so that launches run one after the other.

    `kernel[n](...)` runs it on n threads, or on a few more that fill the last block.

    Attributes:
        function: The Python function.
    """

    def __init__(self, function: Callable[..., None]) -> None:
        """Prepare a function; it is compiled when it is first launched."""
        self.function, self._dispatcher = function, cuda.jit(function, fastmath=False)
        if not config.ENABLE_CUDASIM:  # the simulator compiles nothing
            keep_on_disk(self._dispatcher)

    def __getitem__(self, n_threads: int) -> Callable[..., None]:
        """Return the launch on n threads, in blocks of `THREADS`; 0 launches nothing."""

        def launch(*arguments: Any) -> None:
            if n_threads:
                n_blocks, size = -(-n_threads // THREADS), min(n_threads, THREADS)
                Launch(self._dispatcher, n_blocks, size, 0, arguments)()

        return launch

    def prepare(self, n_blocks: int, size: int, *arguments: Any, shared_bytes: int = 0) -> Launch:
        """Return a launch that can be repeated with the same arguments, for a `Program`.

        Args:
            n_blocks: Blocks, at least one.
            size: Threads of a block.
            arguments: Arrays of the GPU, numbers, and records of these.
            shared_bytes: Dynamic shared memory of a block [bytes].
        """
        return Launch(self._dispatcher, n_blocks, size, shared_bytes, arguments)


def cuda_kernel(function: Callable[..., None]) -> Kernel:
    """Compile a kernel; its body begins with the guard of its bounds."""
    return Kernel(function)
