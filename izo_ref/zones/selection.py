"""Which of the impacts found enter the zones (SPEC section 6)."""

import numpy as np

from izo_ref.base.records import Impacts
from izo_ref.zones.serial.selection import select_in_order


def select_impacts(impacts: Impacts, pinned, selection: str) -> np.ndarray:
    """(n,) b1, the impacts to keep.

    A pair that meets late on a path which an earlier impact will deflect is a half-space
    too many: fewer impacts end closer to the candidate positions, and take more
    iterations.

    Args:
        impacts: `Impacts`; equal times are taken in the order given.
        pinned: (n_vertices,) b1.
        selection: `independent`: by time, those that share no free vertex with one taken
            before; `first-of-any`: the earliest for at least one of their free vertices;
            `all`.
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
