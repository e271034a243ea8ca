"""The only place with compile options of the device; of the processor: `izo_ref/base/compile.py`.

Kernels call the functions of `scalar/` and `serial/`, which are compiled once more for the
device. It contracts products and sums to one rounding (FMA), for which there is no switch: the
bounds of `scalar/` hold, because each operation is still off by one rounding at most, but bits
may differ from those of the processor.
"""

from numba import cuda
from numba.cuda.core import config

from izo_ref.base.compile import CACHE_FOLDER, setting

THREADS = 128  # of a block, where a kernel does not say


def device_function(function):
    """Compile what kernels call and the processor has not."""
    return cuda.jit(function, device=True, fastmath=False)


class Kernel:
    """A kernel; `kernel[n](...)` runs it on n threads, or a few more to fill the last block.

    `kernel.in_blocks(n, size, shared_bytes)(...)` runs it in n blocks of as many threads. It is
    launched on the default stream, so launches run one after the other.
    """

    def __init__(self, function):
        self.function = function
        with setting(config, "CACHE_DIR", str(CACHE_FOLDER / "cuda")):
            self._dispatcher = cuda.jit(function, fastmath=False, cache=True)

    def __getitem__(self, n_threads):
        return self.in_blocks(-(-int(n_threads) // THREADS), min(int(n_threads), THREADS))

    def in_blocks(self, n_blocks, size, shared_bytes=0):
        def launch(*arrays):
            if n_blocks == 0:
                return
            # few blocks are what a scene with little to do is: nothing to warn of
            with setting(config, "CUDA_LOW_OCCUPANCY_WARNINGS", 0):
                configured = self._dispatcher[n_blocks, size, 0, shared_bytes]
            configured(*arrays)

        return launch


def cuda_kernel(function):
    """Compile a kernel; it begins with its bounds guard."""
    return Kernel(function)
