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
from izo_ref.zones.serial.group_records import (
    LARGE,
    MEDIUM,
    SMALL,
    GroupWork,
    VertexLabels,
    ZoneLists,
    ZoneRule,
)

# A key holds two numbers of 31 bits: vertices are numbers of 32 bits with a sign.
BITS = 31
NUMBER = (1 << BITS) - 1  # the bits of the lower number
VERTEX = 1 << 62  # added to the keys of vertices, which come behind all impacts
NO_ZONE = (1 << 63) - 1  # key of an impact that is in no zone


@compiled
def group_zones(
    group: ThreadGroup,
    nodes: Nodes,
    pinned: Flags,
    rule: ZoneRule,
    stuck_out: Flags,
    lists_out: ZoneLists,
    own: VertexLabels,
    work: GroupWork,
    counts_out: Indices,
) -> None:
    """Group impacts into zones, and list the zones that have to be solved.

    Those are the zones that have an impact from counts[FIRST_NEW] on, or all of them if the rule
    says so, but without the zones that have a stuck vertex. All vertices of such a zone become
    stuck. If there is no new impact at all, there are no zones.

    Args:
        group: The threads.
        nodes: (room, 4) i4, of the counts[IMPACTS] impacts.
        pinned: (n_vertices,) b1.
        rule: Which zones are solved, and their sizes.
        stuck_out: (n_vertices,) b1.
        lists_out: The zones, and those that have to be solved.
        own: Work space.
        work: Work space.
        counts_out: (N_COUNTS,) i8; FIRST_NEW and IMPACTS are read, the numbers of zones and of
            zones to solve are written.
    """
    n, first_new = counts_out[IMPACTS], counts_out[FIRST_NEW]
    if group.rank() == 0:
        for k in range(ZONES, N_COUNTS):
            counts_out[k] = 0
    if n <= first_new:
        return
    group.wait()
    for j in range(group.rank(), n, group.size()):
        for k in range(4):
            vertex = nodes[j, k]
            if not pinned[vertex] and list_vertex(group, vertex, counts_out, ZONE_VERTICES, own):
                work.stuck_marks[vertex] = 0
    group.wait()
    n_vertices = counts_out[ZONE_VERTICES]
    label_vertices(group, n, nodes, pinned, n_vertices, own)
    _write_keys(group, n, nodes, pinned, n_vertices, stuck_out, own, work, counts_out)
    forget_marks(group, n_vertices, own)
    group.wait()
    scratch = work.places, work.other_keys, work.other_places
    group_sort(group, n + n_vertices, work.keys, *scratch)
    n_impacts = n - counts_out[LEFT_OUT]
    _divide(group, n_impacts, n_vertices, stuck_out, lists_out, work, counts_out)
    group.wait()
    n_zones = counts_out[STARTS] // 2
    group_sort(group, counts_out[STARTS], work.starts, *scratch)
    _choose(group, n_zones, n_impacts, n_vertices, first_new, rule, lists_out, work, counts_out)
    group.wait()
    group_sort(group, counts_out[TO_SOLVE], work.chosen, *scratch)
    _list_chosen(group, lists_out, work, counts_out)


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
    lists_out: ZoneLists,
    work: GroupWork,
    counts: Indices,
) -> None:
    """Collect where zones begin; list impacts and vertices; mark the vertices of stuck zones."""
    keys = work.keys
    for i in range(group.rank(), n_impacts + n_vertices, group.size()):
        label, number = keys[i] >> BITS, keys[i] & NUMBER
        if i == 0 or keys[i - 1] >> BITS != label:
            work.starts[group_add(group, counts, STARTS, 1)] = i
        if i < n_impacts:
            lists_out.impacts[i] = number
        else:
            lists_out.vertices[i - n_impacts] = number
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
    lists_out: ZoneLists,
    work: GroupWork,
    counts: Indices,
) -> None:
    """Write where zones begin, and collect the zones to solve, with keys that sort by size."""
    starts, keys = work.starts, work.keys
    for zone in range(group.rank(), n_zones, group.size()):
        begin, end = starts[zone], starts[zone + 1]
        lists_out.impact_offsets[zone] = begin
        lists_out.vertex_offsets[zone] = starts[n_zones + zone] - n_impacts
        is_stuck = work.stuck_marks[keys[begin] >> BITS] > 0
        is_new = (keys[end - 1] & NUMBER) >= first_new
        if (rule.every_zone or is_new) and not is_stuck:
            size = _size_of(end - begin, rule)
            group_add(group, counts, OF_SIZE + size, 1)
            work.chosen[group_add(group, counts, TO_SOLVE, 1)] = (size << BITS) + zone
    if group.rank() == 0:
        lists_out.impact_offsets[n_zones] = n_impacts
        lists_out.vertex_offsets[n_zones] = n_vertices
        counts[ZONES], counts[ZONE_IMPACTS] = n_zones, n_impacts


@compiled
def _size_of(n: AnyInt, rule: ZoneRule) -> int:
    """Return SMALL, MEDIUM or LARGE for a zone of n impacts."""
    if n <= rule.small:
        return SMALL
    return MEDIUM if n <= rule.medium else LARGE


@compiled
def _list_chosen(
    group: ThreadGroup, lists_out: ZoneLists, work: GroupWork, counts: Indices
) -> None:
    """List the zones to solve by their size."""
    for i in range(group.rank(), counts[TO_SOLVE], group.size()):
        size, at = work.chosen[i] >> BITS, i
        for smaller in range(size):
            at -= counts[OF_SIZE + smaller]
        lists_out.to_solve[size, at] = work.chosen[i] & NUMBER
