"""Find the deep zones of the impacts found, by a thread group: `deep_selection.py` says what for.

A zone is deep if the sum of the depths of its impacts is more than DEEP_EDGES times their number.
Sums of floats depend on the order. So the threads sum depths that are rounded to whole units,
and compare the bounds of the sum. Where these do not decide, one thread sums the depths in the
order of the impacts, as the CPU does. So the answer is the same.
"""

from izo_ref.base.arrays import AnyInt
from izo_ref.base.compile import compiled
from izo_ref.base.records import Impacts
from izo_ref.base.serial.thread_group import ThreadGroup, group_add, group_least
from izo_ref.zones.serial.deep_selection import DEEP, DEEP_EDGES, SHALLOW, UNDECIDED
from izo_ref.zones.serial.group_labels import label_of
from izo_ref.zones.serial.group_records import SelectionWork, StepArrays, VertexLabels

UNIT = 2.0**-20  # longest edges; a power of two, so that a depth is divided by it without rounding
# Deeper impacts are not rounded to units [longest edges]. So the units of 2^22 impacts fit into 62
# bits.
DEEPEST = 2.0**20


@compiled
def forget_depths(vertex: AnyInt, work: SelectionWork) -> None:
    """Begin the sums of a zone whose label is this vertex."""
    work.known[vertex] = -UNDECIDED
    work.units[vertex], work.sizes[vertex], work.odd[vertex] = 0, 0, 0


@compiled
def find_deep_zones(
    group: ThreadGroup,
    n: int,
    n_vertices: int,
    found: Impacts,
    step: StepArrays,
    own: VertexLabels,
    work: SelectionWork,
) -> None:
    """Decide which zones are deep; keep what is known of their vertices, and mark their impacts.

    All threads must have waited since labels and depths were written. The threads may read what is
    known of other vertices after the next wait.

    Args:
        group: The threads.
        n: Number of impacts.
        n_vertices: Number of their unpinned vertices.
        found: The impacts.
        step: `known_depths` is read and written.
        own: The vertices, with their labels.
        work: The depths are read; the zones' depths and the flags `deep` are written.
    """
    _sum_depths(group, n, found, step, own, work)
    group.wait()
    for i in range(group.rank(), n_vertices, group.size()):
        vertex = own.listed[i]
        if own.labels[vertex] == vertex:
            work.zone_depths[vertex] = _depth_of_zone(vertex, n, found, step, own, work)
    group.wait()
    for i in range(group.rank(), n_vertices, group.size()):
        vertex = own.listed[i]
        step.known_depths[vertex] = work.zone_depths[own.labels[vertex]]
    for j in range(group.rank(), n, group.size()):
        label = label_of(j, found.nodes, step.pinned, own.labels)
        work.deep[j] = label >= 0 and work.zone_depths[label] == DEEP


@compiled
def _sum_depths(
    group: ThreadGroup,
    n: int,
    found: Impacts,
    step: StepArrays,
    own: VertexLabels,
    work: SelectionWork,
) -> None:
    """Sum the depths of each zone in units, and find the most that is known of its vertices."""
    for j in range(group.rank(), n, group.size()):
        label = label_of(j, found.nodes, step.pinned, own.labels)
        if label < 0:
            continue
        group_add(group, work.sizes, label, 1)
        if abs(work.depths[j]) < DEEPEST:
            group_add(group, work.units, label, int(work.depths[j] / UNIT))
        else:  # a NaN, too
            group_add(group, work.odd, label, 1)
        for k in range(4):
            vertex = found.nodes[j, k]
            if not step.pinned[vertex] and step.known_depths[vertex] != UNDECIDED:
                group_least(group, work.known, label, -int(step.known_depths[vertex]))


@compiled
def _depth_of_zone(
    label: int,
    n: int,
    found: Impacts,
    step: StepArrays,
    own: VertexLabels,
    work: SelectionWork,
) -> int:
    """Return whether the zone with a label is SHALLOW or DEEP."""
    if work.known[label] != -UNDECIDED:
        return -work.known[label]
    size = work.sizes[label]
    if work.odd[label] == 0:
        depth = depth_of_sum(work.units[label], size)
        if depth != UNDECIDED:
            return depth
    total = 0.0
    for j in range(n):
        if label_of(j, found.nodes, step.pinned, own.labels) == label:
            total += work.depths[j]
    return DEEP if total > DEEP_EDGES * size else SHALLOW


@compiled
def depth_of_sum(units: AnyInt, n: AnyInt) -> int:
    """Return SHALLOW or DEEP for a sum of depths in units; UNDECIDED if that is too near to tell.

    Rounding changes each depth by less than one unit. A sum of n floats below DEEPEST has an error
    of at most n^2 u DEEPEST (1 + n u), u = 2^-53, which is less than n^2 2^-12 units.

    Args:
        units: The sum.
        n: Number of depths.
    """
    excess = units - int(DEEP_EDGES / UNIT) * n
    error = n + n * n // 4096 + 1
    if abs(excess) <= error:
        return UNDECIDED
    return DEEP if excess > 0 else SHALLOW
