"""Which of the impacts found enter the zones, on the device."""

import numpy as np

from izo_ref.base.gpu_arrays import empty, filled, indices_of, order_of
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
        return indices_of(filled(n, True, np.bool_))
    # bits of floats that are not negative are in their order
    order, ranks = order_of(impacts.toi.view(np.int64)), empty(n, np.int64)
    kernels.ranks_of[n](order, ranks)
    states, seen = filled(n, kernels.UNDECIDED, np.int8), filled(n_vertices, False, np.bool_)
    undecided = empty(n, np.bool_)
    independent = selection == "independent"
    while True:
        owners = filled(n_vertices, n, np.int64)
        kernels.claim_vertices[n](impacts.nodes, pinned, ranks, states, owners)
        kernels.take_owners[n](impacts.nodes, pinned, ranks, owners, independent, states, seen)
        kernels.drop_others[n](impacts.nodes, pinned, seen, states, undecided)
        # the others of `first-of-any` were seen by all before them, taken or not
        if not independent or indices_of(undecided).shape[0] == 0:
            break
    taken = empty(n, np.bool_)
    kernels.are_taken[n](states, taken)
    return indices_of(taken)
