"""Select which of the impacts found enter the zones (docs/method section 6)."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Flags
from izo_ref.base.records import Impacts
from izo_ref.zones.serial.selection import select_in_order


def select_impacts(impacts: Impacts, pinned: Flags, selection: str) -> Flags:
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

    Returns:
        (n_impacts,) b1, the impacts to keep.
    """
    if selection == "all":
        return np.ones(len(impacts.toi), bool)
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
