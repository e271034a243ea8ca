"""Selection and grouping on a GPU, with the counts and arrays of a stage on its own."""

from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.gpu_arrays import empty, overwrite, to_cpu, to_gpu
from izo_ref.zones.gpu_grouping import FEW, launch_of_grouping
from izo_ref.zones.group_buffers import listed_zones, zone_impacts
from izo_ref.zones.serial import group_counts as at
from izo_ref.zones.serial.group_records import ZoneRule
from tests.helpers.groups import Case, Scene, step_arrays

SOLVE_ALL = ZoneRule(every_zone=True, small=1, middle=4)


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


def step_of(case, impacts, room):
    """Send the arrays of a step to the GPU.

    Args:
        case: The vertices, on the CPU.
        impacts: Columns of the impacts in zones, on the CPU; others have no numbers.
        room: How many impacts in zones there is room for.
    """
    own = zone_impacts(room, empty)
    overwrite(own, tuple(impacts))
    return step_arrays(own, to_gpu(case._replace(found=())))


def grouped(nodes, pinned, stuck, first_new=0, rule=SOLVE_ALL, few=FEW):
    """Group impacts on the GPU; parameters on the CPU, as of `launch_of_grouping`."""
    n, n_vertices = len(nodes), len(pinned)
    scene = Scene(np.empty((n_vertices, 3)), np.empty((n_vertices, 3)), pinned)
    step = step_of(Case(scene, (), stuck, np.zeros(n_vertices, np.int32)), (nodes,), n)
    zones = listed_zones(n, n_vertices, counts_of(first_new, n), empty)
    launch_of_grouping(step, rule, zones, few)()
    lists = to_cpu(zones)
    ends, counts = lists.counts[at.ZONES] + 1, lists.counts
    sizes = counts[at.ZONE_IMPACTS], ends, counts[at.ZONE_VERTICES], ends
    columns = [column[:k] for column, k in zip(lists[:4], sizes, strict=True)]
    of_size = zip(lists[4:7], counts[at.OF_SIZE : at.OF_SIZE + 3], strict=True)
    to_solve = np.sort(np.concatenate([row[:k] for row, k in of_size]))
    return Grouped(columns, to_solve, counts, to_cpu(step.stuck))
