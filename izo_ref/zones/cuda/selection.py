"""Select which of the impacts found enter the zones, in one launch.

A block waits for its own threads in a small part of the time that all blocks wait for each other.
So one block selects among few impacts, while the other blocks have nothing to do.
"""

from numba import cuda

from izo_ref.base.arrays import Floats, Indices
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import block, grid
from izo_ref.base.records import Impacts
from izo_ref.zones.serial.group_records import SelectionWork, StepArrays, VertexLabels
from izo_ref.zones.serial.group_select import group_select


@cuda_kernel
def select_impacts(
    # In:
    few: int,  # i8, most impacts found that one block selects among
    found: Impacts,  # Impacts, of base/records.py, with room for more
    n_found: Indices,  # (1,) i8
    selection: int,  # i8, which impacts are selected, a code of zones/serial/group_records.py
    # Out:
    step_out: StepArrays,  # StepArrays; impacts are appended, and known depths are written
    vertices_out: VertexLabels,  # VertexLabels, work space
    work_out: SelectionWork,  # SelectionWork, work space
    counts_out: Indices,  # (16,) i8, of zones/serial/group_counts.py
    parts_out: Floats,  # (n_blocks, 7) f8, zeros at first, work space
) -> None:
    """Select impacts and append them to those in the zones."""
    own = found, n_found, selection, step_out, vertices_out, work_out, counts_out
    if n_found[0] > few:
        group_select(grid(parts_out), *own)
    elif cuda.blockIdx.x == 0:
        group_select(block(), *own)
