"""Select which of the impacts found enter the zones, on a GPU."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import GpuArray
from izo_ref.base.gpu_arrays import empty, flatnonzero, full, stable_argsort
from izo_ref.base.records import Impacts
from izo_ref.zones.cuda import selection as kernels


def select_impacts(impacts: Impacts, pinned: GpuArray, selection: str) -> GpuArray:
    """Select the impacts that enter the zones, the same ones as `zones/selection.py`.

    Args:
        impacts: The impacts found, on the GPU; those with equal times are taken in the order given.
        pinned: (n_vertices,) b1, on the GPU.
        selection: `independent`, `first-of-any` or `all`; see `zones/selection.py`.

    Returns:
        (n_selected,) i8, the impacts to keep, ascending, on the GPU.
    """
    n, n_vertices = impacts.toi.shape[0], pinned.shape[0]
    if selection == "all" or n == 0:
        return flatnonzero(full(n, True, np.bool_))
    # the bits of floats that are not negative, read as integers, have the same order
    order, ranks = stable_argsort(impacts.toi.view(np.int64)), empty(n, np.int64)
    kernels.rank_impacts[n](order, ranks)
    states, seen = full(n, kernels.UNDECIDED, np.int8), full(n_vertices, False, np.bool_)
    undecided = empty(n, np.bool_)
    independent = selection == "independent"
    while True:
        owners = full(n_vertices, n, np.int64)
        kernels.claim_vertices[n](impacts.nodes, pinned, ranks, states, owners)
        kernels.take_owners[n](impacts.nodes, pinned, ranks, owners, independent, states, seen)
        kernels.drop_others[n](impacts.nodes, pinned, seen, states, undecided)
        # With `first-of-any` one round decides all: an impact that is not taken still counts as
        # earlier for its vertices, so no other impact becomes the earliest when it is dropped.
        if not independent or flatnonzero(undecided).shape[0] == 0:
            break
    taken = empty(n, np.bool_)
    kernels.flag_taken[n](states, taken)
    return flatnonzero(taken)
