"""The only place with compile options of a GPU; `base/compile.py` has those of the CPU.

Kernels call the functions of `formulas/` and `serial/`, which numba compiles again for the GPU. The
GPU contracts products and sums to one rounding (FMA), and numba has no switch for that. The bounds
of `formulas/` hold all the same, because each operation still has at most one rounding. The bits
may differ from those of the CPU.
"""

from collections.abc import Callable
from typing import Any

from numba import cuda
from numba.cuda.core import config

from izo_ref.base.compile import CACHE_FOLDER, name_files_by_process, setting

THREADS = 128  # threads of a block, where a kernel asks for no other number


def device_function(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that only kernels of a GPU call."""
    return cuda.jit(function, device=True, fastmath=False)


class Kernel:
    """A kernel of a GPU, launched on the default stream, so that launches run one after the other.

    `kernel[n](...)` runs it on n threads, or on a few more that fill the last block.

    Attributes:
        function: The Python function.
    """

    def __init__(self, function: Callable[..., None]) -> None:
        """Prepare a function; it is compiled when it is first launched."""
        self.function = function
        with setting(config, "CACHE_DIR", str(CACHE_FOLDER / "cuda")):
            self._dispatcher = cuda.jit(function, fastmath=False, cache=True)
        if not config.ENABLE_CUDASIM:  # the simulator compiles nothing
            name_files_by_process(self._dispatcher)

    def __getitem__(self, n_threads: int) -> Callable[..., None]:
        """Return the launch on n threads, in blocks of `THREADS`."""
        return self.in_blocks(-(-int(n_threads) // THREADS), min(int(n_threads), THREADS))

    def in_blocks(self, n_blocks: int, size: int, shared_bytes: int = 0) -> Callable[..., None]:
        """Return the launch in blocks of a chosen size.

        Args:
            n_blocks: Blocks; 0 launches nothing.
            size: Threads of a block.
            shared_bytes: Dynamic shared memory of a block [bytes].
        """

        def launch(*arguments: Any) -> None:
            if n_blocks == 0:
                return
            # a scene with little work has few blocks; numba need not warn of that
            with setting(config, "CUDA_LOW_OCCUPANCY_WARNINGS", 0):
                configured = self._dispatcher[n_blocks, size, 0, shared_bytes]
            configured(*arguments)

        return launch


def cuda_kernel(function: Callable[..., None]) -> Kernel:
    """Compile a kernel; its body begins with the guard of its bounds."""
    return Kernel(function)
