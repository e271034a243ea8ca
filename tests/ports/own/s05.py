"""Stage S5 by our own compiled functions."""

from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Flags
from izo_ref.base.records import Impacts
from izo_ref.zones.grouping import build_zones


class Pinned(NamedTuple):
    """The part of a scene that `build_zones` reads."""

    pinned: Flags


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the zone of each impact; both types of floats are the same, since there are none."""
    nodes = np.array(inputs["nodes"], np.int32).reshape(-1, 4)
    n = len(nodes)
    impacts = Impacts(nodes, np.zeros(n, bool), np.zeros(n), np.zeros((n, 4)), np.zeros((n, 3)))
    zones = build_zones(Pinned(np.array(inputs["pinned"], bool)), impacts)  # pyright: ignore
    zone_of_impact = np.full(n, -1)
    for zone in range(len(zones)):
        zone_of_impact[zones.impacts_of(zone)] = zone
    return {"zone_of_impact": zone_of_impact.tolist()}
