"""Group impacts that share an unpinned vertex in one launch, and choose zones, on a GPU."""

from numba import cuda

from izo_ref.base.arrays import Flags, Floats, Indices, Nodes
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import block, grid
from izo_ref.zones.serial.group_counts import IMPACTS
from izo_ref.zones.serial.group_records import GroupWork, VertexLabels, ZoneLists, ZoneRule
from izo_ref.zones.serial.group_zones import group_zones


@cuda_kernel
def group_impacts(
    # In:
    few: int,  # i8, most impacts that one block groups, while the other blocks have nothing to do
    nodes: Nodes,  # (room, 4) i4
    pinned: Flags,  # (n_vertices,) b1
    rule: ZoneRule,  # ZoneRule, of zones/serial/group_records.py
    # Out:
    stuck_out: Flags,  # (n_vertices,) b1, becomes true for all vertices of zones with a stuck one
    lists_out: ZoneLists,  # ZoneLists
    vertices_out: VertexLabels,  # VertexLabels, work space
    work_out: GroupWork,  # GroupWork, work space
    counts_out: Indices,  # (16,) i8, of zones/serial/group_counts.py
    parts_out: Floats,  # (n_blocks, 7) f8, zeros at first, work space
) -> None:
    """Group impacts into zones, and list the zones that have to be solved."""
    own = nodes, pinned, rule, stuck_out, lists_out, vertices_out, work_out, counts_out
    if counts_out[IMPACTS] > few:
        group_zones(grid(parts_out), *own)
    elif cuda.blockIdx.x == 0:
        group_zones(block(), *own)
