"""Make the arrays of the selection and of the grouping by a thread group, on a CPU or a GPU."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from izo_ref.base.records import Impacts
from izo_ref.zones.serial.group_records import (
    GroupWork,
    SelectionWork,
    VertexLabels,
    ZoneImpacts,
    ZoneLists,
)

# (shape, dtype) -> an array of the CPU or of a GPU
Maker = Callable[[tuple[int, ...], Any], Any]


def zone_impacts(room: int, empty: Maker) -> ZoneImpacts:
    """Return room for the impacts in zones, not written to."""
    return ZoneImpacts(
        nodes=empty((room, 4), np.int32),
        is_edge_edge=empty((room,), np.bool_),
        toi=empty((room,), np.float64),
        weights=empty((room, 4), np.float64),
        normals=empty((room, 3), np.float64),
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


def zone_lists(room: int, n_vertices: int, empty: Maker) -> ZoneLists:
    """Return room for the zones of some impacts, in which all zones that they can have fit.

    Args:
        room: Most impacts.
        n_vertices: Vertices of the scene.
        empty: Makes arrays that are not written to.
    """
    most = min(room, n_vertices)
    return ZoneLists(
        impacts=empty((room,), np.int64),
        impact_offsets=empty((most + 1,), np.int64),
        vertices=empty((min(4 * room, n_vertices),), np.int64),
        vertex_offsets=empty((most + 1,), np.int64),
        to_solve=empty((3, most), np.int64),
    )


def group_work(room: int, n_vertices: int, empty: Maker) -> GroupWork:
    """Return work space for the grouping; parameters as of `zone_lists`."""
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
