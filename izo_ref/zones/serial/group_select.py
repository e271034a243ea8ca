"""Select which of the impacts found enter the zones, by a thread group, and append them.

The same impacts are selected as by `zones/selection.py`, in the same order.
"""

from izo_ref.base.arrays import Indices
from izo_ref.base.compile import compiled
from izo_ref.base.records import Impacts
from izo_ref.base.serial.group_sort import group_sort
from izo_ref.base.serial.thread_group import ThreadGroup, group_add
from izo_ref.zones.serial.deep_selection import relative_depth
from izo_ref.zones.serial.group_claims import (
    DROPPED,
    OPEN,
    TAKEN,
    forget_claims,
    prepare_claims,
    take_by_claims,
)
from izo_ref.zones.serial.group_counts import (
    FIRST_NEW,
    FOUND_VERTICES,
    IMPACTS,
    NEEDED_IMPACTS,
    NEW,
)
from izo_ref.zones.serial.group_counts import TAKEN as N_TAKEN
from izo_ref.zones.serial.group_depths import find_deep_zones, forget_depths
from izo_ref.zones.serial.group_labels import forget_marks, label_vertices, list_vertex
from izo_ref.zones.serial.group_records import (
    ALL,
    INDEPENDENT,
    SelectionWork,
    StepArrays,
    VertexLabels,
)
from izo_ref.zones.serial.selection import is_hopeful


@compiled
def group_select(
    group: ThreadGroup,
    found: Impacts,
    n_found: Indices,
    selection: int,
    step_out: StepArrays,
    own: VertexLabels,
    work: SelectionWork,
    counts_out: Indices,
) -> None:
    """Let impacts that were found enter the zones.

    If they do not all fit, none enters, and counts_out[NEEDED_IMPACTS] says how much room there has
    to be. Then the same call with more room selects the same impacts. If there were more impacts
    than `found` has room for, nothing is done at all.

    Args:
        group: The threads.
        found: The impacts found, with room for more; each has an unpinned vertex whose weight is
            not zero.
        n_found: (1,) i8, number of impacts found.
        selection: Which impacts are selected: INDEPENDENT, FIRST_OF_ANY or ALL.
        step_out: The step; its impacts and its known depths are written.
        own: Work space.
        work: Work space.
        counts_out: (N_COUNTS,) i8; IMPACTS is read, and the numbers up to NEEDED_IMPACTS are
            written.
    """
    step, n, before = step_out, n_found[0], counts_out[IMPACTS]
    if n > found.toi.shape[0]:
        n = 0
    if group.rank() == 0:
        counts_out[FOUND_VERTICES], counts_out[N_TAKEN] = 0, 0
    group.wait()
    _begin(group, n, found, selection, step, own, work, counts_out)
    if selection != ALL:
        group.wait()
        n_vertices = counts_out[FOUND_VERTICES]
        if selection == INDEPENDENT:
            label_vertices(group, n, found.nodes, step.pinned, n_vertices, own)
            find_deep_zones(group, n, n_vertices, found, step, own, work)
        prepare_claims(group, n, found, step.pinned, work)
        forget_marks(group, n_vertices, own)
        group.wait()
        take_by_claims(group, n, n_vertices, found, step.pinned, selection, own, work)
    for j in range(group.rank(), n, group.size()):
        if work.states[j] == TAKEN:
            work.taken[group_add(group, counts_out, N_TAKEN, 1)] = j
    group.wait()
    n_taken = counts_out[N_TAKEN]
    group_sort(group, n_taken, work.taken, work.places, work.other_keys, work.other_places)
    n_new = n_taken if before + n_taken <= step.toi.shape[0] else 0
    for i in range(group.rank(), n_new, group.size()):
        _append(before + i, work.taken[i], found, step_out)
    if group.rank() == 0:
        counts_out[FIRST_NEW], counts_out[IMPACTS] = before, before + n_new
        counts_out[NEW], counts_out[NEEDED_IMPACTS] = n_new, before + n_taken


@compiled
def _begin(
    group: ThreadGroup,
    n: int,
    found: Impacts,
    selection: int,
    step: StepArrays,
    own: VertexLabels,
    work: SelectionWork,
    counts: Indices,
) -> None:
    """Drop the impacts that no solver could mend, and list the unpinned vertices of all impacts."""
    nodes, weights, normals = found.nodes, found.weights, found.normals
    for j in range(group.rank(), n, group.size()):
        is_open = is_hopeful(j, step.positions, nodes, weights, normals, step.stuck, step.thickness)
        if selection == ALL:
            work.states[j] = TAKEN if is_open else DROPPED
            continue
        work.states[j], work.deep[j] = OPEN if is_open else DROPPED, False
        if selection == INDEPENDENT:
            work.depths[j] = relative_depth(
                j, step.start, step.positions, nodes, found.is_edge_edge, weights, normals
            )
        for k in range(4):
            vertex = nodes[j, k]
            if not step.pinned[vertex] and list_vertex(group, vertex, counts, FOUND_VERTICES, own):
                forget_depths(vertex, work)
                forget_claims(vertex, work)


@compiled
def _append(to: int, j: int, found: Impacts, step_out: StepArrays) -> None:
    """Copy impact j to a place behind the impacts of the zones; it starts without a multiplier."""
    step_out.is_edge_edge[to], step_out.toi[to] = found.is_edge_edge[j], found.toi[j]
    for k in range(4):
        step_out.nodes[to, k] = found.nodes[j, k]
        step_out.weights[to, k] = found.weights[j, k]
    for axis in range(3):
        step_out.normals[to, axis] = found.normals[j, axis]
    step_out.multipliers[to], step_out.active[to] = 0.0, False
