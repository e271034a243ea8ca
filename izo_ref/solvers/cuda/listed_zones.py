"""Write the constraints of all zones of a step on a GPU, and solve the zones of lists."""

import numba
from numba import cuda

from izo_ref.base.arrays import Floats, Indices, Ints, Offsets
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import WARP, block, grid
from izo_ref.solvers.serial import zone_rows
from izo_ref.solvers.serial.listed_zones import solve_by_all, solve_by_group, solve_in_slot
from izo_ref.solvers.serial.small_zone import Limits
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers, ZoneRows
from izo_ref.zones.serial.group_records import StepArrays
from izo_ref.zones.serial.listed_zones import ListedZones


@cuda_kernel
def write_rows(
    # In:
    zones: ListedZones,  # ListedZones, of zones/serial/listed_zones.py
    inputs: StepArrays,  # StepArrays, of zones/serial/group_records.py
    # Out:
    rows_out: ZoneRows,  # ZoneRows, of solvers/serial/zone_buffers.py
    answers_out: ZoneAnswers,  # ZoneAnswers, all zones become unsolved
    places_out: Ints,  # (n_vertices,) i4, the place of each vertex in those of the zones
    sizes_out: Indices,  # (8,) i8, how much is to be done
    counts_out: Indices,  # (7,) i8, what the CPU reads
    parts_out: Floats,  # (n_blocks, 7) f8, zeros, work space
) -> None:
    """Write the constraints of all zones, and begin all counts anew."""
    group = grid(parts_out)
    zone_rows.write_rows(
        group, zones, inputs, rows_out, answers_out, places_out, sizes_out, counts_out
    )


@cuda_kernel
def solve_list_in_slots(
    # In:
    zones: Indices,  # (n,) i8, the list of small zones
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    sizes: Indices,  # (8,) i8, how much is to be done
    rows: ZoneRows,  # ZoneRows, of solvers/serial/zone_buffers.py
    limits: Limits,  # Limits, of solvers/serial/small_zone.py
    single: int,  # i8, method for a zone of one impact, a code of solvers/serial/small_zone.py
    # Out:
    answers_out: ZoneAnswers,  # ZoneAnswers, entries of these zones are written
    numbers_out: Floats,  # (n_threads, k) f8, work space
    indices_out: Ints,  # (n_threads, l) i4, work space
) -> None:
    """Solve small zones, one thread a zone; a thread solves one zone after the other."""
    slot = cuda.grid(1)
    solve_in_slot(
        slot,
        cuda.gridsize(1),
        zones,
        impact_offsets,
        vertex_offsets,
        sizes,
        rows,
        limits,
        single,
        numbers_out[slot],
        indices_out[slot],
        answers_out,
    )


@cuda_kernel
def solve_list_in_blocks(
    # In:
    zones: Indices,  # (n,) i8, the list of middle zones
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    rows: ZoneRows,  # ZoneRows, of solvers/serial/zone_buffers.py
    limits: Limits,  # Limits, of solvers/serial/small_zone.py
    # Out:
    sizes_out: Indices,  # (8,) i8, how much is to be done; the tickets are counted up
    answers_out: ZoneAnswers,  # ZoneAnswers, entries of these zones are written
    numbers_out: Floats,  # (n_blocks, k) f8, work space
    indices_out: Ints,  # (n_blocks, l) i4, work space
) -> None:
    """Solve middle zones, one block a zone; a block that is done takes the next zone."""
    shared = cuda.shared.array(0, numba.float64)  # the sums of `block` use its first numbers
    solve_by_group(
        block(),
        zones,
        impact_offsets,
        vertex_offsets,
        sizes_out,
        rows,
        limits,
        shared[3 * (cuda.blockDim.x + WARP) :],
        numbers_out[cuda.blockIdx.x],
        indices_out[cuda.blockIdx.x],
        answers_out,
    )


@cuda_kernel
def solve_list_by_grid(
    # In:
    large: Indices,  # (n,) i8, the list of large zones
    middle: Indices,  # (n,) i8, the list of middle zones
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    sizes: Indices,  # (8,) i8, how much is to be done
    rows: ZoneRows,  # ZoneRows, of solvers/serial/zone_buffers.py
    limits: Limits,  # Limits, of solvers/serial/small_zone.py
    # Out:
    answers_out: ZoneAnswers,  # ZoneAnswers, entries of these zones are written
    numbers_out: Floats,  # (k,) f8, work space
    indices_out: Ints,  # (l,) i4, work space
    parts_out: Floats,  # (n_blocks, 7) f8, zeros, work space
) -> None:
    """Solve large zones, and middle ones that had no room, one by one, by all blocks."""
    group = grid(parts_out)
    own = large, middle, impact_offsets, vertex_offsets, sizes, rows, limits
    solve_by_all(group, *own, numbers_out, indices_out, answers_out)
