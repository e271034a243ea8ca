"""Select which of the impacts found enter the zones, on a GPU."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import GpuArray
from izo_ref.base.cuda.arrays import SUM
from izo_ref.base.gpu_arrays import (
    as_column,
    empty,
    flatnonzero,
    full,
    reduce,
    stable_argsort,
)
from izo_ref.base.records import Impacts
from izo_ref.zones.cuda import selection as kernels
from izo_ref.zones.serial.deep_selection import DEEP


def select_impacts(
    impacts: Impacts, pinned: GpuArray, selection: str, deep: bool = False
) -> GpuArray:
    """Select the impacts that enter the zones, the same ones as `zones/selection.py`.

    Args:
        impacts: The impacts found, on the GPU; those with equal times are taken in the order given.
        pinned: (n_vertices,) b1, on the GPU.
        selection: `independent`, `first-of-any` or `all`; see `zones/selection.py`.
        deep: Whether the step is deep.

    Returns:
        (n_selected,) i8, the impacts to keep, ascending, on the GPU.
    """
    n, n_vertices = impacts.toi.shape[0], pinned.shape[0]
    if selection == "all" or n == 0:
        return flatnonzero(full(n, True, np.bool_))
    if deep and selection == "independent":
        return _select_deep_impacts(impacts, pinned)
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


def is_deep(impacts: Impacts, positions_t0: GpuArray, positions: GpuArray) -> bool:
    """Return whether the impacts are far deeper than their edges are long, on average.

    Args:
        impacts: The impacts found, on the GPU.
        positions_t0: (n_vertices, 3) f8 [m], start of the path, on the GPU.
        positions: (n_vertices, 3) f8 [m], end of the path, on the GPU.
    """
    n = impacts.toi.shape[0]
    if n == 0:
        return False
    own = impacts.nodes, impacts.is_edge_edge, impacts.weights, impacts.normals
    depths = empty(n, np.float64)
    kernels.compute_relative_depths[n](positions_t0, positions, *own, depths)
    return float(reduce(as_column(depths), SUM)) > DEEP * n


def _select_deep_impacts(impacts: Impacts, pinned: GpuArray) -> GpuArray:
    """Select the impacts that enter the zones in a deep step, as `zones/selection.py`.

    Args:
        impacts: The impacts found, on the GPU, at least one; each has an unpinned vertex.
        pinned: (n_vertices,) b1, on the GPU.

    Returns:
        (n_selected,) i8, the impacts to keep, ascending, on the GPU.
    """
    n, n_vertices = impacts.toi.shape[0], pinned.shape[0]
    bits, mains = impacts.toi.view(np.int64), empty((n, 4), np.int32)
    first_times = full(n_vertices, np.inf, np.float64)
    first_bits = first_times.view(np.int64)
    kernels.claim_first_times[n](bits, impacts.nodes, impacts.weights, pinned, mains, first_bits)
    keys, states = empty(n, np.int64), empty(n, np.int8)
    kernels.drop_late_impacts[n](
        impacts.toi, bits, impacts.is_edge_edge, mains, first_times, keys, states
    )
    ranks, owners = empty(n, np.int64), full(n_vertices, n, np.int64)
    kernels.rank_impacts[n](stable_argsort(keys), ranks)
    kernels.claim_vertices[n](mains, pinned, ranks, states, owners)
    seen, taken = full(n_vertices, False, np.bool_), empty(n, np.bool_)
    kernels.take_owners[n](mains, pinned, ranks, owners, False, states, seen)
    kernels.flag_taken[n](states, taken)
    return flatnonzero(taken)
