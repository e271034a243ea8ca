"""Selection and grouping on a GPU, with the counts and arrays of a stage on its own."""

from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.gpu_arrays import empty, to_cpu, to_gpu
from izo_ref.base.records import Impacts
from izo_ref.zones.gpu_grouping import FEW, GroupingStage
from izo_ref.zones.gpu_selection import SELECTIONS, SelectionStage
from izo_ref.zones.group_buffers import zone_impacts
from izo_ref.zones.serial import group_counts as at
from izo_ref.zones.serial.group_records import SelectionRule, StepArrays, ZoneRule
from tests.helpers.groups import THICKNESS_M

SOLVE_ALL = ZoneRule(every_zone=True, small=1, medium=4)


class Grouped(NamedTuple):
    """Zones that a GPU found, on the CPU."""

    zones: list[Any]  # the columns of `Zones`
    to_solve: Any  # (n,) i8, the zones to solve, ascending
    counts: Any  # (N_COUNTS,) i8
    stuck: Any  # (n_vertices,) b1


def counts_of(first_new, n):
    """Return the counts on the GPU of n impacts in zones, new from one of them on."""
    counts = np.zeros(at.N_COUNTS, np.int64)
    counts[at.FIRST_NEW], counts[at.IMPACTS] = first_new, n
    return to_gpu(counts)


def arrays_of(case):
    """Send the arrays of a step to the GPU."""
    start, end, pinned = map(to_gpu, case.scene)
    return StepArrays(start, end, pinned, to_gpu(case.stuck), to_gpu(case.known_depths))


def with_room(impacts, room):
    """Send impacts to the GPU, with room for more."""
    result = zone_impacts(room, empty)
    for column, values in zip(result, impacts, strict=False):
        column[: len(values)].copy_to_device(values)
    return result


def selection_of(found, before, own, name, room, counts, few=FEW):
    """Return the selection among impacts.

    Args:
        found: The impacts found, on the CPU.
        before: The impacts in zones, on the CPU.
        own: Arrays of the step, on the GPU.
        name: Value of `Options.selection`.
        room: How many impacts in zones there is room for.
        counts: Counts on the GPU.
        few: Most impacts that one block selects among.
    """
    on_gpu = Impacts(*map(to_gpu, found))
    rule, n_found = SelectionRule(THICKNESS_M, SELECTIONS[name]), to_gpu(np.array([len(found.toi)]))
    return SelectionStage(on_gpu, n_found, own, rule, with_room(before, room), counts, few)


def grouped(nodes, pinned, stuck, first_new=0, rule=SOLVE_ALL, few=FEW):
    """Group impacts on the GPU; parameters on the CPU, as of `GroupingStage`."""
    counts, own_stuck = counts_of(first_new, len(nodes)), to_gpu(stuck)
    stage = GroupingStage(to_gpu(nodes), to_gpu(pinned), own_stuck, rule, counts, few)
    for launch in stage.launches():
        launch()
    own, lists = to_cpu(counts), [to_cpu(column) for column in stage.lists]
    ends = own[at.ZONES] + 1
    sizes = own[at.ZONE_IMPACTS], ends, own[at.ZONE_VERTICES], ends
    zones = [column[:n] for column, n in zip(lists[:4], sizes, strict=True)]
    of_size = zip(lists[4], own[at.OF_SIZE : at.OF_SIZE + 3], strict=True)
    to_solve = np.sort(np.concatenate([row[:n] for row, n in of_size]))
    return Grouped(zones, to_solve, own, to_cpu(own_stuck))
