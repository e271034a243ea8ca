"""Group impacts into zones by a thread group, and list the zones that have to be solved.

Each impact and each unpinned vertex of an impact gets a key: first whether it is an impact or a
vertex, then the label of its zone, which is the least vertex of it, then its own number. Sorted
keys are the impacts zone by zone, and then the vertices zone by zone. Zones begin where the label
changes. These places are collected in any order and sorted as well, so there is no prefix sum.
"""

from izo_ref.base.arrays import AnyInt, Flags, Indices, Nodes
from izo_ref.base.compile import compiled
from izo_ref.base.serial.group_sort import group_sort
from izo_ref.base.serial.thread_group import ThreadGroup, group_add
from izo_ref.zones.serial.group_counts import (
    FIRST_NEW,
    IMPACTS,
    LEFT_OUT,
    N_COUNTS,
    OF_SIZE,
    STARTS,
    TO_SOLVE,
    ZONE_IMPACTS,
    ZONE_VERTICES,
    ZONES,
)
from izo_ref.zones.serial.group_labels import (
    forget_marks,
    label_of,
    label_vertices,
    list_vertex,
)
from izo_ref.zones.serial.group_records import GroupWork, StepArrays, VertexLabels, ZoneRule
from izo_ref.zones.serial.listed_zones import ListedZones

# A key holds two numbers of 31 bits: vertices are numbers of 32 bits with a sign.
BITS = 31
NUMBER = (1 << BITS) - 1  # the bits of the lower number
VERTEX = 1 << 62  # added to the keys of vertices, which come behind all impacts
NO_ZONE = (1 << 63) - 1  # key of an impact that is in no zone

SMALL, MIDDLE, LARGE = range(3)  # sizes of zones


@compiled
def group_zones(
    group: ThreadGroup,
    step_out: StepArrays,
    rule: ZoneRule,
    zones_out: ListedZones,
    own: VertexLabels,
    work: GroupWork,
) -> None:
    """Group impacts into zones, and list the zones that have to be solved.

    Those are the zones that have an impact from counts[FIRST_NEW] on, or all of them if the rule
    says so, but without the zones that have a stuck vertex. All vertices of such a zone become
    stuck. If there is no new impact at all, there are no zones.

    Args:
        group: The threads.
        step_out: The step, with counts[IMPACTS] impacts; `stuck` is written.
        rule: Which zones are solved, and their sizes.
        zones_out: The zones, and those that have to be solved. Of the counts, FIRST_NEW and IMPACTS
            are read, the numbers of zones and of zones to solve are written.
        own: Work space.
        work: Work space.
    """
    nodes, pinned, stuck, counts = step_out.nodes, step_out.pinned, step_out.stuck, zones_out.counts
    n, first_new = counts[IMPACTS], counts[FIRST_NEW]
    if group.rank() == 0:
        for k in range(ZONES, N_COUNTS):
            counts[k] = 0
    if n <= first_new:
        return
    group.wait()
    for j in range(group.rank(), n, group.size()):
        for k in range(4):
            vertex = nodes[j, k]
            if not pinned[vertex] and list_vertex(group, vertex, counts, ZONE_VERTICES, own):
                work.stuck_marks[vertex] = 0
    group.wait()
    n_vertices = counts[ZONE_VERTICES]
    label_vertices(group, n, nodes, pinned, n_vertices, own)
    _write_keys(group, n, nodes, pinned, n_vertices, stuck, own, work, counts)
    forget_marks(group, n_vertices, own)
    group.wait()
    scratch = work.places, work.other_keys, work.other_places
    group_sort(group, n + n_vertices, work.keys, *scratch)
    n_impacts = n - counts[LEFT_OUT]
    _divide(group, n_impacts, n_vertices, stuck, zones_out, work)
    group.wait()
    n_zones = counts[STARTS] // 2
    group_sort(group, counts[STARTS], work.starts, *scratch)
    _choose(group, n_zones, n_impacts, n_vertices, first_new, rule, zones_out, work)
    group.wait()
    group_sort(group, counts[TO_SOLVE], work.chosen, *scratch)
    _list_chosen(group, zones_out, work)


@compiled
def _write_keys(
    group: ThreadGroup,
    n: int,
    nodes: Nodes,
    pinned: Flags,
    n_vertices: int,
    stuck: Flags,
    own: VertexLabels,
    work: GroupWork,
    counts: Indices,
) -> None:
    """Write the keys of impacts and vertices; count the stuck vertices of each zone."""
    for j in range(group.rank(), n, group.size()):
        label = label_of(j, nodes, pinned, own.labels)
        work.keys[j] = (label << BITS) + j if label >= 0 else NO_ZONE
        if label < 0:
            group_add(group, counts, LEFT_OUT, 1)
    for i in range(group.rank(), n_vertices, group.size()):
        vertex = own.listed[i]
        label = int(own.labels[vertex])
        work.keys[n + i] = VERTEX + (label << BITS) + vertex
        if stuck[vertex]:
            group_add(group, work.stuck_marks, label, 1)


@compiled
def _divide(
    group: ThreadGroup,
    n_impacts: int,
    n_vertices: int,
    stuck_out: Flags,
    zones_out: ListedZones,
    work: GroupWork,
) -> None:
    """Collect where zones begin; list impacts and vertices; mark the vertices of stuck zones."""
    keys, counts = work.keys, zones_out.counts
    for i in range(group.rank(), n_impacts + n_vertices, group.size()):
        label, number = keys[i] >> BITS, keys[i] & NUMBER
        if i == 0 or keys[i - 1] >> BITS != label:
            work.starts[group_add(group, counts, STARTS, 1)] = i
        if i < n_impacts:
            zones_out.impacts[i] = number
        else:
            zones_out.vertices[i - n_impacts] = number
            if work.stuck_marks[label - (VERTEX >> BITS)] > 0:
                stuck_out[number] = True


@compiled
def _choose(
    group: ThreadGroup,
    n_zones: int,
    n_impacts: int,
    n_vertices: int,
    first_new: int,
    rule: ZoneRule,
    zones_out: ListedZones,
    work: GroupWork,
) -> None:
    """Write where zones begin, and collect the zones to solve, with keys that sort by size."""
    starts, keys, counts = work.starts, work.keys, zones_out.counts
    for zone in range(group.rank(), n_zones, group.size()):
        begin, end = starts[zone], starts[zone + 1]
        zones_out.impact_offsets[zone] = begin
        zones_out.vertex_offsets[zone] = starts[n_zones + zone] - n_impacts
        is_stuck = work.stuck_marks[keys[begin] >> BITS] > 0
        is_new = (keys[end - 1] & NUMBER) >= first_new
        if (rule.every_zone or is_new) and not is_stuck:
            size = _size_of(end - begin, rule)
            group_add(group, counts, OF_SIZE + size, 1)
            work.chosen[group_add(group, counts, TO_SOLVE, 1)] = (size << BITS) + zone
    if group.rank() == 0:
        zones_out.impact_offsets[n_zones] = n_impacts
        zones_out.vertex_offsets[n_zones] = n_vertices
        counts[ZONES], counts[ZONE_IMPACTS] = n_zones, n_impacts


@compiled
def _size_of(n: AnyInt, rule: ZoneRule) -> int:
    """Return SMALL, MIDDLE or LARGE for a zone of n impacts."""
    if n <= rule.small:
        return SMALL
    return MIDDLE if n <= rule.middle else LARGE


@compiled
def _list_chosen(group: ThreadGroup, zones_out: ListedZones, work: GroupWork) -> None:
    """List the zones to solve by their size."""
    counts = zones_out.counts
    n_small, n_middle = counts[OF_SIZE + SMALL], counts[OF_SIZE + MIDDLE]
    for i in range(group.rank(), counts[TO_SOLVE], group.size()):
        size, zone = work.chosen[i] >> BITS, work.chosen[i] & NUMBER
        if size == SMALL:
            zones_out.small[i] = zone
        elif size == MIDDLE:
            zones_out.middle[i - n_small] = zone
        else:
            zones_out.large[i - n_small - n_middle] = zone
