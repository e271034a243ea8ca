"""Zones on the device: impacts that share an unpinned vertex, in contiguous blocks."""

import numpy as np

from izo_ref.base.gpu_arrays import arange, empty, flatnonzero, full, stable_argsort, take, to_cpu
from izo_ref.base.records import Impacts
from izo_ref.zones.cuda import grouping as kernels
from izo_ref.zones.grouping import Zones


def build_zones(impacts: Impacts, pinned) -> Zones:
    """Group impacts into zones, as `izo_ref.zones.grouping.build_zones` does.

    Args:
        impacts: `Impacts` on the device.
        pinned: (n_vertices,) b1, on the device.

    Returns:
        `Zones` of arrays on the device.
    """
    n, n_vertices = impacts.nodes.shape[0], pinned.shape[0]
    labels = _labels(impacts.nodes, pinned)
    components, free = empty(n, np.int64), empty(n, np.bool_)
    in_zone = full(n_vertices, False, np.bool_)
    kernels.label_impacts[n](impacts.nodes, pinned, labels, components, in_zone)
    kernels.flag_grouped[n](components, free)
    rows, row_offsets = _grouped(flatnonzero(free), components)
    vertices, vertex_offsets = _grouped(flatnonzero(in_zone), labels)
    return Zones(rows, row_offsets, vertices, vertex_offsets)


def _labels(nodes, pinned):
    """(n_vertices,) i8, the least vertex of the zone that each is in."""
    n, n_vertices = nodes.shape[0], pinned.shape[0]
    labels = arange(n_vertices)
    while True:
        changed, shorter = full(1, 0, np.int64), empty(n_vertices, np.int64)
        kernels.join_labels[n](nodes, pinned, labels, changed)
        kernels.shorten_labels[n_vertices](labels, shorter)
        labels = shorter
        if not to_cpu(changed)[0]:
            return labels


def _grouped(members, groups):
    """Members by their group, else as given, and where each group begins."""
    keys = take(groups, members)
    order, n = stable_argsort(keys), members.shape[0]
    first = empty(n + 1, np.bool_)
    kernels.flag_first[n + 1](take(keys, order), first)
    return take(members, order), flatnonzero(first)
