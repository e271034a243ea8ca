"""Make the arrays of the selection and of the grouping by a thread group, on a CPU or a GPU."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from izo_ref.base.records import Impacts, empty_impacts
from izo_ref.zones.serial.group_records import (
    GroupWork,
    SelectionWork,
    VertexLabels,
    ZoneImpacts,
)
from izo_ref.zones.serial.listed_zones import ListedZones

# (shape, dtype) -> an array of the CPU or of a GPU
Maker = Callable[[tuple[int, ...], Any], Any]


def zone_impacts(room: int, empty: Maker) -> ZoneImpacts:
    """Return room for the impacts in zones, not written to."""
    return ZoneImpacts(
        *empty_impacts(room, empty),
        multipliers=empty((room,), np.float64),
        active=empty((room,), np.bool_),
    )


def vertex_labels(room: int, n_vertices: int, empty: Maker, zeros: Maker) -> VertexLabels:
    """Return work space for the vertices of some impacts.

    Args:
        room: Most impacts.
        n_vertices: Vertices of the scene.
        empty: Makes arrays that are not written to.
        zeros: Makes arrays of zeros.
    """
    most = min(4 * room, n_vertices)
    return VertexLabels(
        marks=zeros((n_vertices,), np.int64),
        listed=empty((most,), np.int64),
        labels=empty((n_vertices,), np.int64),
        parents=empty((n_vertices,), np.int64),
    )


def listed_zones(room: int, n_vertices: int, counts: Any, empty: Maker) -> ListedZones:
    """Return room for the zones of some impacts, in which all zones that they can have fit.

    Args:
        room: Most impacts.
        n_vertices: Vertices of the scene.
        counts: (16,) i8, of `serial/group_counts.py`.
        empty: Makes arrays that are not written to.
    """
    most = min(room, n_vertices)
    return ListedZones(
        impacts=empty((room,), np.int64),
        impact_offsets=empty((most + 1,), np.int64),
        vertices=empty((min(4 * room, n_vertices),), np.int64),
        vertex_offsets=empty((most + 1,), np.int64),
        small=empty((most,), np.int64),
        middle=empty((most,), np.int64),
        large=empty((most,), np.int64),
        counts=counts,
    )


def group_work(room: int, n_vertices: int, empty: Maker) -> GroupWork:
    """Return work space for the grouping; parameters as of `listed_zones`."""
    n_keys, most = room + min(4 * room, n_vertices), min(room, n_vertices)
    return GroupWork(
        stuck_marks=empty((n_vertices,), np.int64),
        keys=empty((n_keys,), np.int64),
        starts=empty((2 * most,), np.int64),
        chosen=empty((most,), np.int64),
        places=empty((n_keys,), np.int64),
        other_keys=empty((n_keys,), np.int64),
        other_places=empty((n_keys,), np.int64),
    )


def selection_work(found: Impacts, n_vertices: int, empty: Maker) -> SelectionWork:
    """Return work space for the selection among impacts.

    Args:
        found: Room for the impacts.
        n_vertices: Vertices of the scene.
        empty: Makes arrays that are not written to.
    """
    room = found.toi.shape[0]
    rows = {name: empty((room,), np.int64) for name in ("keys", "taken", "places")}
    others = {name: empty((room,), np.int64) for name in ("other_keys", "other_places")}
    names = "known", "units", "sizes", "odd", "zone_depths", "owner_keys", "owners"
    of_vertices = {name: empty((n_vertices,), np.int64) for name in names}
    first_times = empty((n_vertices,), np.float64)
    return SelectionWork(
        # the bits of floats that are not negative, read as integers, have the same order
        time_bits=found.toi.view(np.int64),
        states=empty((room,), np.int8),
        deep=empty((room,), np.bool_),
        depths=empty((room,), np.float64),
        claims=empty((room, 4), np.int32),
        first_times=first_times,
        first_bits=first_times.view(np.int64),
        seen=empty((n_vertices,), np.bool_),
        **rows,
        **others,
        **of_vertices,
    )
