"""Prepared launches of a fixed number of blocks, whatever the amount of work is."""

from __future__ import annotations

from typing import Any

import numpy as np

from izo_ref.base.cuda.compile import Kernel
from izo_ref.base.cuda.thread_group import PARTS, shared_bytes
from izo_ref.base.devices import fixed_launch
from izo_ref.base.gpu_arrays import zeros

# Threads of a block whose blocks wait for each other. With more, a thread has fewer registers than
# most kernels use.
THREADS = 256


def by_grid(kernel: Kernel, *arguments: Any, n_threads: int = THREADS) -> Any:
    """Return a prepared launch of blocks that wait for each other.

    Args:
        kernel: A kernel whose last parameter is the work space of `base/cuda/thread_group.py:grid`.
        arguments: Its other arguments.
        n_threads: Threads of a block, for which each multiprocessor has enough registers.
    """
    n_blocks, size = fixed_launch(1, n_threads)
    parts = zeros((n_blocks, PARTS), np.float64)
    return kernel.prepare(n_blocks, size, *arguments, parts, shared_bytes=shared_bytes(size))


def by_blocks(kernel: Kernel, blocks_each: int, n_threads: int, *arguments: Any) -> Any:
    """Return a prepared launch of blocks that do not wait for each other.

    Args:
        kernel: A kernel whose blocks may be thread groups.
        blocks_each: Blocks for each multiprocessor.
        n_threads: Threads of a block.
        arguments: All arguments of the kernel.
    """
    n_blocks, size = fixed_launch(blocks_each, n_threads)
    return kernel.prepare(n_blocks, size, *arguments, shared_bytes=shared_bytes(size))
