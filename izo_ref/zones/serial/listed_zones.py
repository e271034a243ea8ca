"""Zones on a GPU, with room to spare, and lists of those that are to be solved.

The arrays have fixed sizes, and how much of them is used is known on the device alone. A list that
does not fit is counted to its end, so a count may be larger than the room. Whoever reads the
arrays asks `all_fit` first.
"""

from typing import NamedTuple

from izo_ref.base.arrays import Indices, Offsets
from izo_ref.base.compile import compiled
from izo_ref.zones.serial import group_counts

# Places of the numbers in `ListedZones.counts`.
OF_STEP, NEEDED, ZONES = group_counts.IMPACTS, group_counts.NEEDED_IMPACTS, group_counts.ZONES
SMALL, MIDDLE, LARGE = range(group_counts.OF_SIZE, group_counts.OF_SIZE + 3)
IMPACTS, VERTICES = group_counts.ZONE_IMPACTS, group_counts.ZONE_VERTICES
N_COUNTS = group_counts.N_COUNTS


class ListedZones(NamedTuple):
    """Zones side by side as in `zones/grouping.py`, and those to solve by their number of impacts.

    The arrays are at least as long as stated. Together, the three lists hold each zone at most
    once; the grouping lists them in ascending order.
    """

    impacts: Indices  # (n_impacts,) i8, impacts of the step, zone by zone
    impact_offsets: Offsets  # (n_zones + 1,) i8
    vertices: Indices  # (n_vertices,) i8, unpinned vertices of the step, zone by zone
    vertex_offsets: Offsets  # (n_zones + 1,) i8
    small: Indices  # (n_small,) i8, zones
    middle: Indices  # (n_middle,) i8, zones
    large: Indices  # (n_large,) i8, zones
    counts: Indices  # (16,) i8, of `group_counts.py`


@compiled
def all_fit(zones: ListedZones, room: int) -> bool:
    """Return whether all arrays have as much room as their counts say.

    Args:
        zones: The zones.
        room: How many impacts of the step there is room for.
    """
    counts = zones.counts
    return (
        counts[NEEDED] <= room
        and counts[ZONES] < min(zones.impact_offsets.shape[0], zones.vertex_offsets.shape[0])
        and counts[IMPACTS] <= zones.impacts.shape[0]
        and counts[VERTICES] <= zones.vertices.shape[0]
        and counts[SMALL] <= zones.small.shape[0]
        and counts[MIDDLE] <= zones.middle.shape[0]
        and counts[LARGE] <= zones.large.shape[0]
    )
