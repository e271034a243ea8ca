"""Update a step after its zones are solved, by a thread group.

The vertices of solved zones move to their solution. Zones that are not solved are listed for the
CPU. Then the objective and the active impacts are measured.
"""

from izo_ref.base.arrays import Floats, Indices
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup, group_add, group_sums
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers
from izo_ref.zones.serial.group_records import StepArrays
from izo_ref.zones.serial.listed_zones import ListedZones

# Threads that share a zone. Most small zones have a few impacts; a middle or a large zone has some
# hundred or more, and then a warp reads neighbouring numbers together.
SHARE_SMALL, SHARE_OTHERS = 4, 32


@compiled
def update(
    group: ThreadGroup,
    zones: ListedZones,
    lengths: Floats,
    answers: ZoneAnswers,
    sizes: Indices,
    step_out: StepArrays,
    left_out: Indices,
    counts_out: Indices,
    values_out: Floats,
) -> None:
    """Move the vertices of solved zones, list the zones that are left, and measure the step.

    Args:
        group: The threads.
        zones: The zones, and lists of those that were to be solved.
        lengths: (n_impacts,) f8 [kg^-1/2], of the constraints before scaling.
        answers: The solutions of these zones.
        sizes: (N_SIZES,) i8, how much is to be done.
        step_out: The step; positions, multipliers and flags of solved zones are written.
        left_out: (n_zones,) i8, the zones that are not solved, in any order.
        counts_out: (N_COUNTS,) i8, LEFT is counted, SOLVED and ACTIVE are written.
        values_out: (N_COUNTS,) f8, the same memory; SQUARES is written.
    """
    own = zones, lengths, answers, step_out, left_out, counts_out
    solved = _take_list(group, zones.small, sizes[at.SMALL], SHARE_SMALL, *own)
    solved += _take_list(group, zones.middle, sizes[at.MIDDLE], SHARE_OTHERS, *own)
    solved += _take_list(group, zones.large, sizes[at.LARGE], SHARE_OTHERS, *own)
    group.wait()  # all threads read the positions next
    squares, active, solved_by_all = _sums(group, step_out, sizes, solved)
    if group.rank() == 0:
        counts_out[at.SOLVED], counts_out[at.ACTIVE] = int(solved_by_all), int(active)
        values_out[at.SQUARES] = squares


@compiled
def measure(
    group: ThreadGroup,
    step: StepArrays,
    sizes: Indices,
    counts_out: Indices,
    values_out: Floats,
) -> None:
    """Measure a step: its objective and its active impacts.

    Args:
        group: The threads.
        step: The step.
        sizes: (N_SIZES,) i8; OF_STEP is how many impacts there are.
        counts_out: (N_COUNTS,) i8, ACTIVE is written.
        values_out: (N_COUNTS,) f8, the same memory; SQUARES is written.
    """
    squares, active, _ = _sums(group, step, sizes, 0)
    if group.rank() == 0:
        counts_out[at.ACTIVE], values_out[at.SQUARES] = int(active), squares


@compiled
def _take_list(
    group: ThreadGroup,
    list_of_zones: Indices,
    n: int,
    share: int,
    zones: ListedZones,
    lengths: Floats,
    answers: ZoneAnswers,
    step_out: StepArrays,
    left_out: Indices,
    counts_out: Indices,
) -> int:
    """Take the answers for the zones of a list, `share` threads a zone.

    Returns:
        How many zones this thread found solved; each zone is counted by one thread.
    """
    solved = 0
    for k in range(group.rank(), share * n, group.size()):
        zone, part = list_of_zones[k // share], k % share
        if answers.solved[zone]:
            _take_answer(zone, part, share, zones, lengths, answers, step_out)
            if part == 0:
                solved += 1
        elif part == 0:
            left_out[group_add(group, counts_out, at.LEFT, 1)] = zone
    return solved


@compiled
def _take_answer(
    zone: int,
    part: int,
    share: int,
    zones: ListedZones,
    lengths: Floats,
    answers: ZoneAnswers,
    step_out: StepArrays,
) -> None:
    """Take a part of the answer for a zone: every `share`th vertex and impact."""
    for i in range(zones.vertex_offsets[zone] + part, zones.vertex_offsets[zone + 1], share):
        vertex = zones.vertices[i]
        for axis in range(3):
            displacement = step_out.inverse_sqrt_masses[vertex] * answers.z[3 * i + axis]
            step_out.positions[vertex, axis] = step_out.proposed[vertex, axis] + displacement
    for i in range(zones.impact_offsets[zone] + part, zones.impact_offsets[zone + 1], share):
        impact = zones.impacts[i]
        step_out.multipliers[impact] = answers.multipliers[i] / lengths[i]
        step_out.active[impact] = answers.multipliers[i] > 0.0


@compiled
def _sums(
    group: ThreadGroup, step: StepArrays, sizes: Indices, solved: int
) -> tuple[float, float, float]:
    """Return sum m |x - y|^2 [kg m^2], the active impacts, and the sum of `solved`."""
    squares, active = 0.0, 0.0
    for i in range(group.rank(), step.masses.shape[0], group.size()):
        total = 0.0
        for axis in range(3):
            offset = step.positions[i, axis] - step.proposed[i, axis]
            total += offset * offset
        squares += step.masses[i] * total
    for j in range(group.rank(), sizes[at.OF_STEP], group.size()):
        if step.active[j]:
            active += 1.0
    return group_sums(group, squares, active, float(solved))
