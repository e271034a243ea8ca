"""Which of the impacts found enter the zones, on the device."""

import numpy as np

from izo_ref.base.gpu_arrays import empty, flatnonzero, full, stable_argsort
from izo_ref.base.records import Impacts
from izo_ref.zones.cuda import selection as kernels


def select_impacts(impacts: Impacts, pinned, selection: str):
    """(n_selected,) i8, the impacts to keep, as `izo_ref.zones.selection` keeps them.

    Args:
        impacts: `Impacts` on the device; equal times are taken in the order given.
        pinned: (n_vertices,) b1, on the device.
        selection: `independent`, `first-of-any` or `all`.
    """
    n, n_vertices = impacts.toi.shape[0], pinned.shape[0]
    if selection == "all" or n == 0:
        return flatnonzero(full(n, True, np.bool_))
    # bits of floats that are not negative are in their order
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
        # the others of `first-of-any` were seen by all before them, taken or not
        if not independent or flatnonzero(undecided).shape[0] == 0:
            break
    taken = empty(n, np.bool_)
    kernels.flag_taken[n](states, taken)
    return flatnonzero(taken)
