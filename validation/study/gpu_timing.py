"""Time work on a GPU by its own events."""

from collections.abc import Callable

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
    from izo_ref.base.gpu_arrays import copy, zeros

    values = zeros(n_bytes // 8, np.float64)
    target = copy(values)
    return 2 * n_bytes / event_ms(lambda: target.copy_to_device(values), repeats)
