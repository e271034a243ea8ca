"""Update a step on a GPU after its zones are solved, by all blocks of a launch."""

from izo_ref.base.arrays import Floats, Indices
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import grid
from izo_ref.loop.serial.update import measure, update
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers
from izo_ref.zones.serial.group_records import StepArrays
from izo_ref.zones.serial.listed_zones import ListedZones


@cuda_kernel
def update_step(
    # In:
    zones: ListedZones,  # ListedZones, of zones/serial/listed_zones.py
    lengths: Floats,  # (n_impacts,) f8  [kg^-1/2], of the rows before scaling
    answers: ZoneAnswers,  # ZoneAnswers, of solvers/serial/zone_buffers.py
    sizes: Indices,  # (8,) i8, how much is to be done
    # Out:
    step_out: StepArrays,  # StepArrays, entries of solved zones are written
    left_out: Indices,  # (n_zones,) i8, zones that are not solved, in any order
    counts_out: Indices,  # (7,) i8, what the CPU reads
    values_out: Floats,  # (7,) f8, the same memory
    parts_out: Floats,  # (n_blocks, 7) f8, zeros, work space
) -> None:
    """Move the vertices of solved zones, list the zones that are left, and measure the step."""
    own = zones, lengths, answers, sizes, step_out, left_out, counts_out, values_out
    update(grid(parts_out), *own)


@cuda_kernel
def measure_step(
    # In:
    step: StepArrays,  # StepArrays, of zones/serial/group_records.py
    sizes: Indices,  # (8,) i8, how much is to be done
    # Out:
    counts_out: Indices,  # (7,) i8, what the CPU reads
    values_out: Floats,  # (7,) f8, the same memory
    parts_out: Floats,  # (n_blocks, 7) f8, zeros, work space
) -> None:
    """Measure the objective and the active impacts of a step."""
    measure(grid(parts_out), step, sizes, counts_out, values_out)
