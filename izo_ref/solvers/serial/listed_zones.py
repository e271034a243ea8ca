"""Solve the zones of a list: small ones by one thread each, others by a thread group each."""

from izo_ref.base.arrays import Flags, Floats, Indices, Ints, Offsets
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup, group_add, group_maxima
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.group_memory import index_size, vector_size
from izo_ref.solvers.serial.group_pivot import NO_ROOM, group_pivot
from izo_ref.solvers.serial.small_zone import (
    BLOCK_PIVOT,
    Limits,
    solve_small_zone,
    work_of_small_zone,
)
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers, ZoneRows

# Blocks take the zones with more impacts than this first, so that none of them begins when all
# other zones are done. Half of the impacts take an eighth of the operations of a factorisation.
BIG = 256


@compiled
def most_vertices(n: int) -> int:
    """Return the largest number of unpinned vertices of a zone of n impacts.

    An impact has four vertices, and shares one of them with another impact of its zone.
    """
    return 3 * n + 1


@compiled
def solve_in_slot(
    slot: int,
    n_slots: int,
    zones: Indices,
    impact_offsets: Offsets,
    vertex_offsets: Offsets,
    sizes: Indices,
    rows: ZoneRows,
    limits: Limits,
    single: int,
    numbers: Floats,
    indices: Ints,
    answers_out: ZoneAnswers,
) -> None:
    """Solve small zones by one thread: those with the number `slot`, `slot + n_slots`, ...

    Args:
        slot: The number of this thread and its work space.
        n_slots: How many there are.
        zones: i8, the list of small zones.
        impact_offsets: (n_zones + 1,) i8.
        vertex_offsets: (n_zones + 1,) i8.
        sizes: (N_SIZES,) i8; SMALL is the length of the list.
        rows: The constraints of all zones.
        limits: What counts as solved.
        single: Method for a zone of one impact, a code of `solvers/serial/small_zone.py`.
        numbers: f8, work space of the slot. Zones that it is too small for are not solved.
        indices: i4, work space of the slot.
        answers_out: The entries of these zones are written.
    """
    for i in range(slot, sizes[at.SMALL], n_slots):
        zone = int(zones[i])
        begin, end = impact_offsets[zone], impact_offsets[zone + 1]
        first, last = vertex_offsets[zone], vertex_offsets[zone + 1]
        n_numbers, n_indices = work_of_small_zone(end - begin, last - first)
        solved, steps = False, 0
        has_room = n_numbers <= numbers.shape[0] and n_indices <= indices.shape[0]
        if has_room and not _any_hopeless(begin, end, 1, rows.hopeless):
            _, solved, steps = solve_small_zone(
                single if end - begin == 1 else BLOCK_PIVOT,
                begin,
                end,
                first,
                last,
                rows.unknowns,
                rows.coefficients,
                rows.normals,
                rows.rhs,
                rows.lengths,
                limits,
                numbers,
                indices,
                answers_out.multipliers,
                answers_out.z,
            )
        answers_out.solved[zone], answers_out.steps[zone] = solved, steps


@compiled
def _any_hopeless(begin: int, end: int, step: int, hopeless: Flags) -> bool:
    """Return whether no vertex can satisfy one of the constraints begin, begin + step, ..."""
    found = False
    for j in range(begin, end, step):
        found = found or hopeless[j]
    return found


@compiled
def solve_by_group(
    group: ThreadGroup,
    zones: Indices,
    impact_offsets: Offsets,
    vertex_offsets: Offsets,
    sizes: Indices,
    rows: ZoneRows,
    limits: Limits,
    near: Floats,
    numbers: Floats,
    indices: Ints,
    answers_out: ZoneAnswers,
) -> None:
    """Solve middle zones, one after the other, until other groups have taken the rest.

    Args:
        group: The threads.
        zones: i8, the list of middle zones.
        impact_offsets: (n_zones + 1,) i8.
        vertex_offsets: (n_zones + 1,) i8.
        sizes: (N_SIZES,) i8; MIDDLE is the length of the list, and TICKET is counted up.
        rows: The constraints of all zones.
        limits: What counts as solved.
        near: f8, fast memory of any size, which is used as far as it goes.
        numbers: f8, work space of the group. Zones that it is too small for are not solved.
        indices: i4, work space of the group.
        answers_out: The entries of these zones are written.
    """
    own = impact_offsets, vertex_offsets, rows, limits, near, numbers, indices
    while True:
        taken = _next_zone(group, zones, impact_offsets, sizes)
        if taken < 0:
            return
        _solve_zone(group, int(zones[taken]), *own, answers_out)


@compiled
def solve_by_all(
    group: ThreadGroup,
    large: Indices,
    middle: Indices,
    impact_offsets: Offsets,
    vertex_offsets: Offsets,
    sizes: Indices,
    rows: ZoneRows,
    limits: Limits,
    numbers: Floats,
    indices: Ints,
    answers_out: ZoneAnswers,
) -> None:
    """Solve zones, one after the other, by all threads that there are.

    These are the large zones, and the middle zones whose factor had no room in the work space of a
    group.

    Args:
        group: The threads.
        large: i8, the list of large zones.
        middle: i8, the list of middle zones, which groups have solved before.
        impact_offsets: (n_zones + 1,) i8.
        vertex_offsets: (n_zones + 1,) i8.
        sizes: (N_SIZES,) i8; LARGE and MIDDLE are the lengths of the lists.
        rows: The constraints of all zones.
        limits: What counts as solved.
        numbers: f8, work space. Zones that it is too small for are not solved.
        indices: i4, work space.
        answers_out: The entries of these zones are written.
    """
    own = impact_offsets, vertex_offsets, rows, limits, numbers[:0], numbers, indices
    n_large = sizes[at.LARGE]
    for i in range(n_large + sizes[at.MIDDLE]):  # one loop, because a GPU has each call in full
        zone = int(large[i]) if i < n_large else int(middle[i - n_large])
        is_left = not answers_out.solved[zone] and answers_out.steps[zone] == NO_ROOM
        if i < n_large or is_left:
            _solve_zone(group, zone, *own, answers_out)


@compiled
def _solve_zone(
    group: ThreadGroup,
    zone: int,
    impact_offsets: Offsets,
    vertex_offsets: Offsets,
    rows: ZoneRows,
    limits: Limits,
    near: Floats,
    numbers: Floats,
    indices: Ints,
    answers_out: ZoneAnswers,
) -> None:
    """Solve a zone by a group; parameters as of `solve_by_group`."""
    begin, end = impact_offsets[zone], impact_offsets[zone + 1]
    first, last = vertex_offsets[zone], vertex_offsets[zone + 1]
    has_numbers = vector_size(end - begin, last - first) <= numbers.shape[0]
    has_room = has_numbers and index_size(end - begin, last - first) <= indices.shape[0]
    solved, steps = False, 0 if has_room else NO_ROOM
    if has_room and not group_finds_hopeless(group, begin, end, rows.hopeless):
        solved, steps = group_pivot(
            group,
            begin,
            end,
            first,
            last,
            rows.unknowns,
            rows.coefficients,
            rows.normals,
            rows.rhs,
            rows.lengths,
            rows.positions,
            limits,
            near,
            numbers,
            indices,
            answers_out.multipliers,
            answers_out.z,
        )
    if group.rank() == 0:
        answers_out.solved[zone], answers_out.steps[zone] = solved, steps


@compiled
def _next_zone(group: ThreadGroup, zones: Indices, impact_offsets: Offsets, sizes: Indices) -> int:
    """Take the next place of the list that no group has taken; -1 if there is none.

    The list is gone through twice: for the zones with more than BIG impacts, then for the others.
    """
    n, ticket = sizes[at.MIDDLE], 0
    while True:
        if group.rank() == 0:
            ticket = group_add(group, sizes, at.TICKET, 1)
        # other threads have 0
        taken = int(group_maxima(group, float(ticket), 0.0)[0])
        if taken >= 2 * n:
            return -1
        place = taken if taken < n else taken - n
        zone = int(zones[place])
        is_big = impact_offsets[zone + 1] - impact_offsets[zone] > BIG
        if is_big == (taken < n):
            return place


@compiled
def group_finds_hopeless(group: ThreadGroup, begin: int, end: int, hopeless: Flags) -> bool:
    """Return whether no vertex can satisfy one of the constraints begin..end.

    Args:
        group: The threads.
        begin: The zone's first impact.
        end: Its last impact + 1.
        hopeless: (n_impacts,) b1.
    """
    mine = _any_hopeless(begin + group.rank(), end, group.size(), hopeless)
    return group_maxima(group, 1.0 if mine else 0.0, 0.0)[0] > 0.0
