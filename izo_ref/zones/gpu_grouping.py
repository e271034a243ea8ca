"""Select impacts, and group them into zones, on a GPU: two launches of a step.

Their work space is made once; it has room for all impacts and zones that the arrays have room for.
"""

from __future__ import annotations

from izo_ref.base.arrays import GpuArray
from izo_ref.base.cuda.compile import Launch
from izo_ref.base.gpu_arrays import empty, zeros
from izo_ref.base.gpu_launch import THREADS, by_grid
from izo_ref.base.records import Impacts
from izo_ref.zones.cuda import grouping, selection
from izo_ref.zones.group_buffers import group_work, selection_work, vertex_labels
from izo_ref.zones.serial.group_records import SELECTIONS, StepArrays, ZoneRule
from izo_ref.zones.serial.listed_zones import ListedZones

# Most impacts that one block selects among or groups: one a thread. A wait of all blocks takes
# longer than a wait of one block, but one block has fewer threads for the work. From how many
# impacts on all blocks are faster was not measured.
FEW = THREADS


def launch_of_selection(
    found: Impacts,
    n_found: GpuArray,
    name: str,
    step: StepArrays,
    counts: GpuArray,
    few: int = FEW,
) -> Launch:
    """Return the launch that lets impacts that were found enter the zones.

    Args:
        found: The impacts found, with room for more.
        n_found: (1,) i8, number of impacts found.
        name: Which impacts are selected, a value of `Options.selection`.
        step: The step, with room for more impacts in zones.
        counts: (N_COUNTS,) i8 of `zones/serial/group_counts.py`; IMPACTS is valid.
        few: Most impacts that one block selects among.
    """
    n_vertices = step.pinned.shape[0]
    vertices = vertex_labels(found.toi.shape[0], n_vertices, empty, zeros)
    work = vertices, selection_work(found, n_vertices, empty)
    own = few, found, n_found, SELECTIONS.index(name), step
    return by_grid(selection.select_impacts, *own, *work, counts)


def launch_of_grouping(
    step: StepArrays, rule: ZoneRule, zones: ListedZones, few: int = FEW
) -> Launch:
    """Return the launch that builds the zones, and lists those that have to be solved.

    Args:
        step: The step, with room for more impacts in zones. All vertices of zones that have a stuck
            vertex become stuck.
        rule: Which zones are solved.
        zones: The zones are written. Of their counts, FIRST_NEW and IMPACTS are valid.
        few: Most impacts that one block groups.
    """
    room, n_vertices = step.toi.shape[0], step.pinned.shape[0]
    work = group_work(room, n_vertices, empty)
    vertices = vertex_labels(room, n_vertices, empty, zeros)
    return by_grid(grouping.group_impacts, few, rule, step, zones, vertices, work)
