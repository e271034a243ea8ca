"""Select which of the impacts found enter the zones (docs/method section 6)."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Flags, Positions
from izo_ref.base.records import Impacts
from izo_ref.zones.serial.deep_selection import DEEP, early_impacts, mean_relative_depth
from izo_ref.zones.serial.selection import select_in_order


def select_impacts(impacts: Impacts, pinned: Flags, selection: str, deep: bool = False) -> Flags:
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
        deep: Whether the step is deep; `independent` then takes other impacts, see
            `_select_deep_impacts`.

    Returns:
        (n_impacts,) b1, the impacts to keep.
    """
    if selection == "all":
        return np.ones(len(impacts.toi), bool)
    if deep and selection == "independent":
        return _select_deep_impacts(impacts, pinned)
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


def is_deep(impacts: Impacts, positions_t0: Positions, positions: Positions) -> bool:
    """Return whether the impacts are far deeper than their edges are long, on average.

    Args:
        impacts: The impacts found.
        positions_t0: (n_vertices, 3) f8 [m], start of the path.
        positions: (n_vertices, 3) f8 [m], end of the path.
    """
    own = impacts.nodes, impacts.is_edge_edge, impacts.weights, impacts.normals
    return mean_relative_depth(positions_t0, positions, *own) > DEEP


def _select_deep_impacts(impacts: Impacts, pinned: Flags) -> Flags:
    """Select the impacts that enter the zones in a deep step.

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
