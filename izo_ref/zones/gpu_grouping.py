"""Zones on a GPU: impacts that share an unpinned vertex, in contiguous blocks."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import GpuArray
from izo_ref.base.gpu_arrays import (
    arange,
    empty,
    flatnonzero,
    full,
    offsets_of,
    stable_argsort,
    take,
    to_cpu,
)
from izo_ref.base.records import Impacts
from izo_ref.zones.cuda import grouping as kernels
from izo_ref.zones.grouping import Zones


def build_zones(impacts: Impacts, pinned: GpuArray) -> Zones:
    """Group impacts into zones, as `build_zones` of `zones/grouping.py` does on the CPU.

    Args:
        impacts: The impacts, on the GPU.
        pinned: (n_vertices,) b1, on the GPU.

    Returns:
        The zones, with arrays on the GPU.
    """
    n, n_vertices = impacts.nodes.shape[0], pinned.shape[0]
    labels = _label_vertices(impacts.nodes, pinned)
    components, grouped = empty(n, np.int64), empty(n, np.bool_)
    in_zone = full(n_vertices, False, np.bool_)
    kernels.label_impacts[n](impacts.nodes, pinned, labels, components, in_zone)
    kernels.flag_grouped[n](components, grouped)
    own_impacts, impact_offsets = _in_groups(flatnonzero(grouped), components)
    vertices, vertex_offsets = _in_groups(flatnonzero(in_zone), labels)
    return Zones(own_impacts, impact_offsets, vertices, vertex_offsets)


def _label_vertices(nodes: GpuArray, pinned: GpuArray) -> GpuArray:
    """Return (n_vertices,) i8, the least vertex of the zone that each vertex is in."""
    n, n_vertices = nodes.shape[0], pinned.shape[0]
    labels = arange(n_vertices)
    while True:
        changed, shorter = full(1, 0, np.int64), empty(n_vertices, np.int64)
        kernels.join_labels[n](nodes, pinned, labels, changed)
        kernels.shorten_labels[n_vertices](labels, shorter)
        labels = shorter
        if not to_cpu(changed)[0]:
            return labels


def _in_groups(members: GpuArray, groups: GpuArray) -> tuple[GpuArray, GpuArray]:
    """Sort members by their group, and return them and where each group begins.

    Args:
        members: (n,) i8, indices into `groups`; members of one group keep their order.
        groups: (m,) i8, the group of each index.
    """
    keys = take(groups, members)
    order, n = stable_argsort(keys), members.shape[0]
    first = empty(n + 1, np.bool_)
    kernels.flag_first[n + 1](take(keys, order), first)
    return take(members, order), flatnonzero(first)


def blocks_of(offsets: GpuArray, n: int) -> GpuArray:
    """Return (n,) i8, the block that each of n entries is in.

    Args:
        offsets: (n_blocks + 1,) i8, where each block begins, and the end; no block is empty.
        n: The number of entries, which is the last offset.
    """
    blocks = empty(n, np.int64)
    kernels.find_blocks[n](offsets, blocks)
    return blocks


def choose_zones(zones: Zones, chosen: GpuArray) -> Zones | None:
    """Return some of the zones, with arrays on the GPU, or None if no zone is chosen.

    Args:
        zones: The zones, on the GPU.
        chosen: (n_zones,) b1, on the GPU.
    """
    index = flatnonzero(chosen)
    if index.shape[0] == 0:
        return None
    if index.shape[0] == len(zones):
        return zones
    columns = []
    for members, offsets in (zones[:2], zones[2:]):
        n = members.shape[0]
        flags, sizes = empty(n, np.bool_), empty(len(zones), np.int64)
        kernels.flag_members[n](blocks_of(offsets, n), chosen, flags)
        kernels.count_members[len(zones)](offsets, sizes)
        columns.append(take(members, flatnonzero(flags)))
        columns.append(offsets_of(take(sizes, index)))
    return Zones(*columns)
