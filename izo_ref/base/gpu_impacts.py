"""`Impacts` whose columns are on the device."""

import numpy as np

from izo_ref.base.cuda import impacts as kernels
from izo_ref.base.gpu_arrays import empty, joined, on_device, on_host
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


def joined_impacts(*parts: Impacts) -> Impacts:
    """One after the other; the only one that is not empty as it is."""
    some = [part for part in parts if part.toi.shape[0]] or parts[:1]
    if len(some) == 1:
        return some[0]
    return Impacts(*(joined(columns) for columns in zip(*some, strict=True)))


def impacts_on_device(impacts: Impacts) -> Impacts:
    """A copy on the device."""
    return Impacts(*(on_device(column) for column in impacts))


def impacts_on_host(impacts: Impacts) -> Impacts:
    """A copy of the processor."""
    return Impacts(*(on_host(column) for column in impacts))
