"""Select which of the impacts found enter the zones (docs/method section 6)."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Flags, Ints, Positions
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.zones.grouping import build_zones
from izo_ref.zones.serial.deep_selection import decide_depths, early_impacts, relative_depths
from izo_ref.zones.serial.selection import select_in_order


def select_impacts(
    impacts: Impacts, pinned: Flags, selection: str, deep: Flags | None = None
) -> Flags:
    """Select the impacts that enter the zones.

    An earlier impact deflects the path. A pair that meets later on the old path may then not meet
    at all, and its constraint is not needed. With fewer impacts the answer is closer to the
    proposed positions, and the loop takes more iterations.

    Args:
        impacts: The impacts found; those with equal times are taken in the order given.
        pinned: (n_vertices,) b1.
        selection: `independent` takes impacts in the order of their times, and none that shares an
            unpinned vertex with one taken before. `first-of-any` takes an impact if it is the
            earliest for at least one of its unpinned vertices. `all` takes all.
        deep: (n_impacts,) b1, the impacts of deep zones, of which `independent` takes others (see
            `_select_deep_impacts`); None if there are none. They share no unpinned vertex with the
            rest.

    Returns:
        (n_impacts,) b1, the impacts to keep.
    """
    if selection == "all":
        return np.ones(len(impacts.toi), bool)
    if deep is not None and deep.any() and selection == "independent":
        selected = np.empty(len(impacts.toi), bool)
        selected[deep] = _select_deep_impacts(impacts.take(deep), pinned)
        selected[~deep] = select_impacts(impacts.take(~deep), pinned, selection)
        return selected
    selected = np.empty(len(impacts.toi), bool)
    select_in_order(
        np.argsort(impacts.toi, kind="stable"),
        impacts.nodes,
        pinned,
        selection == "independent",
        np.zeros(len(pinned), bool),
        selected,
    )
    return selected


def find_deep_impacts(
    scene: SceneArrays, impacts: Impacts, positions: Positions, known_out: Ints
) -> Flags:
    """Find the impacts of deep zones.

    A zone is deep if one of its vertices was in a deep zone before. If none of its vertices was in
    any zone before, it is deep if its impacts are far deeper than their edges are long, on average.

    Args:
        scene: The scene.
        impacts: The impacts found on the path to `positions`.
        positions: (n_vertices, 3) f8 [m], end of the path.
        known_out: (n_vertices,) i4, what is known of each vertex; zeros at first. That of the
            vertices of impacts is written.

    Returns:
        (n_impacts,) b1.
    """
    n, own = len(impacts.toi), (impacts.nodes, impacts.is_edge_edge, impacts.weights)
    zones, depths, deep = build_zones(scene, impacts), np.empty(n), np.zeros(n, bool)
    relative_depths(scene.positions_t0, positions, *own, impacts.normals, depths)
    blocks = zones.impacts, zones.impact_offsets
    decide_depths(*blocks, depths, impacts.nodes, scene.pinned, known_out, deep)
    return deep


def _select_deep_impacts(impacts: Impacts, pinned: Flags) -> Flags:
    """Select the impacts that enter deep zones.

    `zones/serial/deep_selection.py` says which, and why. Of the impacts that need not wait, each is
    taken that is the first for at least one of its main vertices, those of vertices with faces
    before those of edges. The earliest impact of all need not wait, so at least one is taken.

    Args:
        impacts: The impacts found; each has an unpinned vertex.
        pinned: (n_vertices,) b1.

    Returns:
        (n_impacts,) b1, the impacts to keep.
    """
    n = len(impacts.toi)
    mains, early, selected = np.empty((n, 4), np.int32), np.empty(n, bool), np.zeros(n, bool)
    first_times = np.full(len(pinned), np.inf)
    early_impacts(impacts.toi, impacts.nodes, impacts.weights, pinned, first_times, mains, early)
    order = np.lexsort((impacts.toi, impacts.is_edge_edge))
    seen = np.zeros(len(pinned), bool)
    select_in_order(order[early[order]], mains, pinned, False, seen, selected)
    return selected
