"""`Impacts` whose columns are arrays of a GPU."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import GpuArray
from izo_ref.base.cuda import impacts as kernels
from izo_ref.base.gpu_arrays import concatenate, empty, to_cpu, to_gpu
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


def take_impacts(impacts: Impacts, index: GpuArray) -> Impacts:
    """Return the impacts of an index, (n,) i8."""
    n = index.shape[0]
    taken = empty_impacts(n)
    kernels.take_impacts[n](*impacts, index, *taken)
    return taken


def concatenate_impacts(*records: Impacts) -> Impacts:
    """Return the impacts of several records, one record after the other.

    If only one record is not empty, it is returned itself, and not a copy.
    """
    not_empty = [record for record in records if record.toi.shape[0]] or records[:1]
    if len(not_empty) == 1:
        return not_empty[0]
    return Impacts._make(concatenate(columns) for columns in zip(*not_empty, strict=True))


def impacts_to_gpu(impacts: Impacts) -> Impacts:
    """Return a copy on the GPU."""
    return Impacts._make(to_gpu(column) for column in impacts)


def impacts_to_cpu(impacts: Impacts) -> Impacts:
    """Return a copy on the CPU."""
    return Impacts._make(to_cpu(column) for column in impacts)
