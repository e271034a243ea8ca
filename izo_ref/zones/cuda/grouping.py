"""Group impacts that share an unpinned vertex in one launch, and choose zones, on a GPU."""

from numba import cuda

from izo_ref.base.arrays import Floats
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import block, grid
from izo_ref.zones.serial.group_counts import IMPACTS
from izo_ref.zones.serial.group_records import GroupWork, StepArrays, VertexLabels, ZoneRule
from izo_ref.zones.serial.group_zones import group_zones
from izo_ref.zones.serial.listed_zones import ListedZones


@cuda_kernel
def group_impacts(
    # In:
    few: int,  # i8, most impacts that one block groups, while the other blocks have nothing to do
    rule: ZoneRule,  # ZoneRule, of zones/serial/group_records.py
    # Out:
    step_out: StepArrays,  # StepArrays; all vertices of zones with a stuck one become stuck
    zones_out: ListedZones,  # ListedZones, of zones/serial/listed_zones.py
    vertices_out: VertexLabels,  # VertexLabels, work space
    work_out: GroupWork,  # GroupWork, work space
    parts_out: Floats,  # (n_blocks, 7) f8, zeros at first, work space
) -> None:
    """Group impacts into zones, and list the zones that have to be solved."""
    own = step_out, rule, zones_out, vertices_out, work_out
    if zones_out.counts[IMPACTS] > few:
        group_zones(grid(parts_out), *own)
    elif cuda.blockIdx.x == 0:
        group_zones(block(), *own)
