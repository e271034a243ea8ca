"""Select which of the impacts found enter the zones, on a GPU."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import GpuArray
from izo_ref.base.gpu_arrays import empty, flatnonzero, full, stable_argsort
from izo_ref.base.records import Impacts
from izo_ref.zones.cuda import selection as kernels
from izo_ref.zones.gpu_grouping import build_zones


def select_impacts(
    impacts: Impacts, pinned: GpuArray, selection: str, deep: GpuArray | None = None
) -> GpuArray:
    """Select the impacts that enter the zones, the same ones as `zones/selection.py`.

    Args:
        impacts: The impacts found, on the GPU; those with equal times are taken in the order given.
        pinned: (n_vertices,) b1, on the GPU.
        selection: `independent`, `first-of-any` or `all`; see `zones/selection.py`.
        deep: (n_impacts,) b1, the impacts of deep zones, on the GPU; None if there are none.

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
    some_deep = independent and deep is not None and flatnonzero(deep).shape[0] > 0
    if some_deep:
        kernels.drop_impacts[n](deep, states)
    while True:
        owners = full(n_vertices, n, np.int64)
        kernels.claim_vertices[n](impacts.nodes, pinned, ranks, states, owners)
        kernels.take_owners[n](impacts.nodes, pinned, ranks, owners, independent, states, seen)
        kernels.drop_others[n](impacts.nodes, pinned, seen, states, undecided)
        # With `first-of-any` one round decides all: an impact that is not taken still counts as
        # earlier for its vertices, so no other impact becomes the earliest when it is dropped.
        if not independent or flatnonzero(undecided).shape[0] == 0:
            break
    if some_deep:
        _take_deep_impacts(impacts, pinned, deep, states)
    taken = empty(n, np.bool_)
    kernels.flag_taken[n](states, taken)
    return flatnonzero(taken)


def find_deep_impacts(
    impacts: Impacts, starts: GpuArray, positions: GpuArray, pinned: GpuArray, known_out: GpuArray
) -> GpuArray:
    """Find the impacts of deep zones, as `find_deep_impacts` of `zones/selection.py`.

    Args:
        impacts: The impacts found, on the GPU.
        starts: (n_vertices, 3) f8 [m], start of the path, on the GPU.
        positions: (n_vertices, 3) f8 [m], end of the path, on the GPU.
        pinned: (n_vertices,) b1, on the GPU.
        known_out: (n_vertices,) i4, what is known of each vertex, on the GPU; zeros at first. That
            of the vertices of impacts is written.

    Returns:
        (n_impacts,) b1, on the GPU.
    """
    n = impacts.toi.shape[0]
    depths, deep = empty(n, np.float64), full(n, False, np.bool_)
    if n == 0:
        return deep
    own = impacts.nodes, impacts.is_edge_edge, impacts.weights, impacts.normals
    kernels.compute_relative_depths[n](starts, positions, *own, depths)
    zones = build_zones(impacts, pinned)
    kernels.decide_depths[len(zones)](
        zones.impacts, zones.impact_offsets, depths, impacts.nodes, pinned, known_out, deep
    )
    return deep


def _take_deep_impacts(
    impacts: Impacts, pinned: GpuArray, deep: GpuArray, states_out: GpuArray
) -> None:
    """Take the impacts that enter deep zones, as `zones/selection.py` does, and drop the others.

    Args:
        impacts: The impacts found, on the GPU, at least one; each has an unpinned vertex.
        pinned: (n_vertices,) b1, on the GPU.
        deep: (n_impacts,) b1, the impacts of deep zones, on the GPU.
        states_out: (n_impacts,) i1, on the GPU; those of deep zones are written.
    """
    n, n_vertices = impacts.toi.shape[0], pinned.shape[0]
    bits, mains = impacts.toi.view(np.int64), empty((n, 4), np.int32)
    first_times = full(n_vertices, np.inf, np.float64)
    first_bits = first_times.view(np.int64)
    kernels.claim_first_times[n](bits, impacts.nodes, impacts.weights, pinned, mains, first_bits)
    keys = empty(n, np.int64)
    own = impacts.is_edge_edge, mains, first_times, deep
    kernels.drop_late_impacts[n](impacts.toi, bits, *own, keys, states_out)
    ranks, owners = empty(n, np.int64), full(n_vertices, n, np.int64)
    kernels.rank_impacts[n](stable_argsort(keys), ranks)
    kernels.claim_vertices[n](mains, pinned, ranks, states_out, owners)
    seen = full(n_vertices, False, np.bool_)
    kernels.take_owners[n](mains, pinned, ranks, owners, False, states_out, seen)
