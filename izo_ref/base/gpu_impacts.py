"""`Impacts` whose columns are arrays of a GPU."""

from __future__ import annotations

import numpy as np

from izo_ref.base.gpu_arrays import empty, to_cpu, to_gpu
from izo_ref.base.records import Impacts


def empty_impacts(n: int) -> Impacts:
    """Return room for n impacts, not written to."""
    return Impacts(
        empty((n, 4), np.int32),
        empty(n, np.bool_),
        empty(n, np.float64),
        empty((n, 4), np.float64),
        empty((n, 3), np.float64),
    )


def impacts_to_gpu(impacts: Impacts) -> Impacts:
    """Return a copy on the GPU."""
    return Impacts._make(to_gpu(column) for column in impacts)


def impacts_to_cpu(impacts: Impacts) -> Impacts:
    """Return a copy on the CPU."""
    return Impacts._make(to_cpu(column) for column in impacts)
