"""Order the constraints of a zone along the axis in which it is longest, by a thread group.

Constraints that share a vertex are near each other. So in this order their numbers are near each
other, too, and the factors of `envelope.py` are narrow.
"""

import numpy as np

from izo_ref.base.arrays import AnyInt, Ints, Positions
from izo_ref.base.compile import compiled
from izo_ref.base.serial.group_sort import group_sort
from izo_ref.base.serial.thread_group import group_maxima
from izo_ref.solvers.serial.envelope import SHIFT, Envelope, complete, count_tiles
from izo_ref.solvers.serial.group_memory import Memory
from izo_ref.solvers.serial.group_zone import Zone

# Places along the axis that are told apart. Constraints at the same place keep their order.
PLACES = 1 << 20


@compiled
def order_constraints(zone: Zone, positions: Positions, memory: Memory) -> None:
    """Write `order` and `lowest` of the work space; arrays that the guess writes hold the keys.

    All threads have to wait before they read `lowest`.

    Args:
        zone: The zone.
        positions: (n_vertices, 3) f8 [m], of the zone's vertices.
        memory: Work space.
    """
    group, n = zone.group, zone.rhs.shape[0]
    axis, low, length = _longest_axis(zone, positions)
    keys, rank_of, size = memory.is_active, memory.places, group.size()
    for j in range(group.rank(), n, size):
        share = (_middle(zone, positions, axis, low, j) - low) / length if length > 0.0 else 0.0
        # a length that overflows makes shares that are not numbers, which have no place
        keys[j] = int(PLACES * share) if share < 1.0 else PLACES
    group.wait()
    group_sort(group, n, keys, memory.order, memory.is_wrong, memory.active)
    for t in range(group.rank(), n, size):
        rank_of[memory.order[t]] = t
    group.wait()
    for j in range(group.rank(), n, size):
        memory.lowest[j] = memory.order[_lowest_rank(zone, rank_of, j)]


@compiled
def _longest_axis(zone: Zone, positions: Positions) -> tuple[int, float, float]:
    """Return the axis in which a zone is longest, its least coordinate and its length [m]."""
    group, n = zone.group, positions.shape[0]
    best, least, longest = 0, 0.0, -1.0
    for axis in range(3):
        high, low = -np.inf, np.inf
        for i in range(group.rank(), n, group.size()):
            high, low = max(high, positions[i, axis]), min(low, positions[i, axis])
        high, negative_low = group_maxima(group, high, -low)
        if high + negative_low > longest:
            best, least, longest = axis, -negative_low, high + negative_low
    return best, least, longest


@compiled
def _middle(zone: Zone, positions: Positions, axis: int, low: float, j: AnyInt) -> float:
    """Return the mean coordinate of the unpinned vertices of a constraint; `low` without any."""
    total, count = 0.0, 0
    for k in range(4):
        node = zone.nodes[j, k]
        if node >= 0:
            total += positions[node - zone.first, axis] - low
            count += 1
    return low + total / count if count else low


@compiled
def _lowest_rank(zone: Zone, rank_of: Ints, j: AnyInt) -> int:
    """Return the lowest place in the order of a constraint that shares a vertex with this one."""
    lowest = rank_of[j]
    for k in range(4):
        node = zone.nodes[j, k]
        entry = zone.heads[node - zone.first] if node >= 0 else -1
        while entry >= 0:
            lowest = min(lowest, rank_of[entry >> 2])
            entry = zone.chain[entry]
    return lowest


@compiled
def number_active(zone: Zone, memory: Memory) -> Envelope:
    """Number the active constraints in the order, and return the envelope of their matrix."""
    group, q, mine = zone.group, 0, zone.group.rank()
    for t in range(memory.order.shape[0]):
        j = memory.order[t]
        is_active = memory.is_active[j] != 0
        if t == mine:
            memory.places[j] = q if is_active else ~q
            if is_active:
                memory.active[q] = j
            mine += group.size()
        q += 1 if is_active else 0
    group.wait()
    tiles = count_tiles(q)
    envelope = Envelope(q, tiles, memory.firsts_of_tiles, memory.lasts_of_tiles, memory.starts)
    for i in range(group.rank(), tiles, group.size()):
        first = i
        for a in range(i << SHIFT, min((i + 1) << SHIFT, q)):
            place = memory.places[memory.lowest[memory.active[a]]]
            first = min(first, (place if place >= 0 else ~place) >> SHIFT)
        envelope.firsts[i] = first
    group.wait()
    if group.rank() == 0:
        complete(envelope)
    group.wait()
    return envelope
