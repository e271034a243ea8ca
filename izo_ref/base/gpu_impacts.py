"""`Impacts` whose columns are on the device."""

import numpy as np

from izo_ref.base.cuda import impacts as kernels
from izo_ref.base.gpu_arrays import concatenate, empty, to_cpu, to_gpu
from izo_ref.base.records import Impacts


def empty_impacts(n) -> Impacts:
    """So many, not written to."""
    return Impacts(
        empty((n, 4), np.int32),
        empty(n, np.bool_),
        empty(n, np.float64),
        empty((n, 4), np.float64),
        empty((n, 3), np.float64),
    )


def take_impacts(impacts: Impacts, index) -> Impacts:
    """Those of an index, (n,) i8."""
    n = index.shape[0]
    taken = empty_impacts(n)
    kernels.take_impacts[n](*impacts, index, *taken)
    return taken


def concatenate_impacts(*parts: Impacts) -> Impacts:
    """One after the other; the only one that is not empty as it is."""
    some = [part for part in parts if part.toi.shape[0]] or parts[:1]
    if len(some) == 1:
        return some[0]
    return Impacts(*(concatenate(columns) for columns in zip(*some, strict=True)))


def impacts_to_gpu(impacts: Impacts) -> Impacts:
    """A copy on the device."""
    return Impacts(*(to_gpu(column) for column in impacts))


def impacts_to_cpu(impacts: Impacts) -> Impacts:
    """A copy of the processor."""
    return Impacts(*(to_cpu(column) for column in impacts))
