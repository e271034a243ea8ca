"""Exchange active and inactive constraints by a thread group, as `solvers/pivoting.py` does."""

from izo_ref.base.arrays import AnyInt
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import group_sum
from izo_ref.solvers.serial.exchange_rules import RHO
from izo_ref.solvers.serial.group_memory import Memory
from izo_ref.solvers.serial.group_zone import Zone


@compiled
def flag_wrong(zone: Zone, memory: Memory, slop: float) -> float:
    """Flag the constraints that are on the wrong side, and return how many there are.

    An inactive constraint that is violated by no more than `slop` does not enter: rounding could
    make it enter and leave for ever.
    """
    group, count = zone.group, 0.0
    for j in range(group.rank(), zone.rhs.shape[0], group.size()):
        if memory.is_active[j] != 0:
            is_wrong = memory.u[j] < 0.0
        else:
            is_wrong = memory.products[j] - RHO * memory.earlier[j] < zone.rhs[j] - slop
        memory.is_wrong[j] = 1 if is_wrong else 0
        if is_wrong:
            count += 1.0
    return group_sum(group, count)


@compiled
def exchange(zone: Zone, memory: Memory, first_only: bool, by_distance: bool) -> None:
    """Let constraints on the wrong side change sides.

    Args:
        zone: The zone.
        memory: Work space, with what `flag_wrong` wrote.
        first_only: Only those change sides that come first at all their vertices.
        by_distance: The one farthest on the wrong side comes first; of equal ones, and if this is
            False, the one with the highest number.
    """
    group, n = zone.group, zone.rhs.shape[0]
    if first_only:
        for j in range(group.rank(), n, group.size()):
            is_active = memory.is_active[j] != 0
            off = -memory.u[j] if is_active else zone.rhs[j] - memory.products[j]
            memory.right[j] = off if by_distance else 0.0
        group.wait()
        for i in range(group.rank(), zone.heads.shape[0], group.size()):
            memory.firsts[i] = _first_wrong(zone, memory, i)
        group.wait()
    for j in range(group.rank(), n, group.size()):
        if memory.is_wrong[j] != 0 and (not first_only or _comes_first(zone, memory, j)):
            memory.is_active[j] = 1 - memory.is_active[j]
    group.wait()


@compiled
def _first_wrong(zone: Zone, memory: Memory, vertex: AnyInt) -> int:
    """Return which constraint on the wrong side comes first at a vertex; -1 if there is none."""
    best, entry = -1, zone.heads[vertex]
    while entry >= 0:
        j = int(entry >> 2)
        if memory.is_wrong[j] != 0:
            if best < 0:
                best = j
            else:
                own, other = memory.right[j], memory.right[best]
                if own > other or (own == other and j > best):
                    best = j
        entry = zone.chain[entry]
    return best


@compiled
def _comes_first(zone: Zone, memory: Memory, j: AnyInt) -> bool:
    """Return whether a constraint comes first at all its vertices."""
    for k in range(4):
        node = zone.nodes[j, k]
        if node >= 0 and memory.firsts[node - zone.first] != j:
            return False
    return True
