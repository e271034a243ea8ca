"""Take impacts in rounds of claims, by a thread group.

In each round every open impact claims its vertices: the unpinned ones, or its main vertices in a
deep zone. A vertex belongs to the claim with the least key, which is the time of impact; among
equal keys the first impact is the owner. An impact that owns all its vertices is taken, and open
impacts at its vertices are dropped in the next round. In deep zones, and by the rule
`first-of-any`, an impact that owns one vertex is taken, and one round decides all.

That selects the same impacts as `selection.py`, which takes one impact after the other.
"""

from izo_ref.base.arrays import AnyInt, Flags
from izo_ref.base.compile import compiled
from izo_ref.base.records import Impacts
from izo_ref.base.serial.thread_group import ThreadGroup, group_least, group_maxima
from izo_ref.zones.serial.deep_selection import is_early, main_vertices
from izo_ref.zones.serial.group_records import INDEPENDENT, SelectionWork, VertexLabels

OPEN, TAKEN, DROPPED = range(3)
# Added to the keys of edge-edge impacts in deep zones, so that they come behind all vertex-face
# impacts. The bits of a time up to 1, read as an integer, are below it.
BEHIND = 1 << 62
NOBODY = (1 << 63) - 1  # above all keys and claims


@compiled
def forget_claims(vertex: AnyInt, work: SelectionWork) -> None:
    """Begin without an owner of a vertex."""
    work.first_bits[vertex] = NOBODY
    work.owner_keys[vertex], work.owners[vertex] = NOBODY, NOBODY
    work.seen[vertex] = False


@compiled
def prepare_claims(
    group: ThreadGroup, n: int, found: Impacts, pinned: Flags, work: SelectionWork
) -> None:
    """Write the vertices that open impacts claim, and the keys.

    The first times at which vertices are main vertices may be read after the next wait.

    Args:
        group: The threads.
        n: Number of impacts.
        found: The impacts; each has an unpinned vertex whose weight is not zero.
        pinned: (n_vertices,) b1.
        work: `states` and `deep` are read; each thread has written those of its own impacts.
    """
    for j in range(group.rank(), n, group.size()):
        work.keys[j] = work.time_bits[j]
        for k in range(4):
            work.claims[j, k] = found.nodes[j, k]
        if work.deep[j] and work.states[j] == OPEN:
            first, second = main_vertices(j, found.nodes, found.weights, pinned)
            work.claims[j, 0], work.claims[j, 1] = first, first
            work.claims[j, 2], work.claims[j, 3] = second, second
            group_least(group, work.first_bits, first, work.time_bits[j])
            group_least(group, work.first_bits, second, work.time_bits[j])
            if found.is_edge_edge[j]:
                work.keys[j] += BEHIND


@compiled
def take_by_claims(
    group: ThreadGroup,
    n: int,
    n_vertices: int,
    found: Impacts,
    pinned: Flags,
    selection: int,
    own: VertexLabels,
    work: SelectionWork,
) -> None:
    """Take or drop every open impact.

    All threads must have waited since `prepare_claims`. Each thread may read the states of its own
    impacts at once.

    Args:
        group: The threads.
        n: Number of impacts.
        n_vertices: Number of their unpinned vertices.
        found: The impacts.
        pinned: (n_vertices,) b1.
        selection: Which impacts are taken: INDEPENDENT or FIRST_OF_ANY.
        own: The vertices.
        work: The claims, the keys and the states.
    """
    is_independent = selection == INDEPENDENT
    later = 0  # the claims of a round are lower than all claims before, so owners are not reset
    while _claim_by_key(group, n, found, pinned, work):
        for j in range(group.rank(), n, group.size()):
            if work.states[j] == OPEN:
                for k in range(4):
                    vertex = work.claims[j, k]
                    if not pinned[vertex] and work.owner_keys[vertex] == work.keys[j]:
                        group_least(group, work.owners, vertex, j - later)
        group.wait()
        for j in range(group.rank(), n, group.size()):
            if work.states[j] == OPEN:
                _take_owner(j, j - later, is_independent and not work.deep[j], pinned, work)
        for i in range(group.rank(), n_vertices, group.size()):
            work.owner_keys[own.listed[i]] = NOBODY
        group.wait()
        later += n


@compiled
def _claim_by_key(
    group: ThreadGroup, n: int, found: Impacts, pinned: Flags, work: SelectionWork
) -> bool:
    """Drop the open impacts that have to wait, and claim vertices for the others, if there are any.

    The group waits for all threads.

    Returns:
        Whether any impact is open.
    """
    n_open = 0.0
    for j in range(group.rank(), n, group.size()):
        if work.states[j] == OPEN and _has_to_wait(j, found, pinned, work):
            work.states[j] = DROPPED
        if work.states[j] == OPEN:
            n_open = 1.0
            for k in range(4):
                if not pinned[work.claims[j, k]]:
                    group_least(group, work.owner_keys, work.claims[j, k], work.keys[j])
    return group_maxima(group, n_open, 0.0)[0] > 0.0


@compiled
def _has_to_wait(j: int, found: Impacts, pinned: Flags, work: SelectionWork) -> bool:
    """Return whether impact j is left for later detections."""
    if work.deep[j]:
        return not is_early(j, found.toi, work.claims, work.first_times)
    waits = False
    for k in range(4):
        if work.seen[work.claims[j, k]] and not pinned[work.claims[j, k]]:
            waits = True
    return waits


@compiled
def _take_owner(j: int, claim: int, needs_all: bool, pinned: Flags, work: SelectionWork) -> None:
    """Take an open impact if it owns a vertex, or all of its vertices if it needs all.

    Args:
        j: The impact.
        claim: Its claim.
        needs_all: Whether it stays open if it does not own all of them; else it is dropped.
        pinned: (n_vertices,) b1.
        work: The owners; the state is written.
    """
    n_claimed, n_own = 0, 0
    for k in range(4):
        if not pinned[work.claims[j, k]]:
            n_claimed += 1
            n_own += work.owners[work.claims[j, k]] == claim
    if (n_own == n_claimed) if needs_all else (n_own > 0):
        work.states[j] = TAKEN
        for k in range(4):
            if needs_all and not pinned[work.claims[j, k]]:
                work.seen[work.claims[j, k]] = True
    elif not needs_all:
        work.states[j] = DROPPED
