"""Time work on a GPU by its own events, and count launches and arrays."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np


def once_ms(call: Callable[[], object]) -> float:
    """Measure the time of one call between two events of the GPU [ms]."""
    from numba import cuda

    begin, end = cuda.event(), cuda.event()
    begin.record()
    call()
    end.record()
    end.synchronize()
    return begin.elapsed_time(end)


def event_ms(call: Callable[[], object], repeats: int) -> float:
    """Measure the median time of some calls [ms], after a first call that does not count."""
    call()
    return float(np.median([once_ms(call) for _ in range(repeats)]))


def copied_bytes_per_ms(n_bytes: int, repeats: int) -> float:
    """Measure the bandwidth of a copy from the memory of the GPU to the same memory.

    Args:
        n_bytes: Size of the copy.
        repeats: Number of copies that are timed.

    Returns:
        Bytes read and written in a millisecond.
    """
    from izo_ref.base.gpu_arrays import copy, full

    values = full(n_bytes // 8, 0.0, np.float64)
    target = copy(values)
    return 2 * n_bytes / event_ms(lambda: target.copy_to_device(values), repeats)


@contextmanager
def counted_launches() -> Iterator[dict[str, int]]:
    """Count the launches of kernels and the arrays made on the GPU inside the block.

    Yields:
        `{"launches": ..., "arrays": ...}`, complete at the end of the block.
    """
    from izo_ref.base.cuda import memory
    from izo_ref.base.cuda.compile import Kernel

    counts, in_blocks, make = {"launches": 0, "arrays": 0}, Kernel.in_blocks, memory.new_array

    def counting_blocks(kernel: Kernel, n_blocks: int, *sizes: Any) -> Any:
        counts["launches"] += n_blocks > 0
        return in_blocks(kernel, n_blocks, *sizes)

    def counting_arrays(*arguments: Any, **named: Any) -> Any:
        counts["arrays"] += 1
        return make(*arguments, **named)

    with (
        patch.object(Kernel, "in_blocks", counting_blocks),
        patch.object(memory, "new_array", counting_arrays),
    ):
        yield counts
