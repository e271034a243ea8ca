"""Block pivoting on a GPU: a middle zone by one block of threads, a large zone by all blocks."""

from collections.abc import Callable

import numpy as np

from izo_ref.base.arrays import GpuArray
from izo_ref.base.devices import fixed_launch, largest_shared_bytes
from izo_ref.base.gpu_arrays import empty
from izo_ref.base.gpu_launch import by_grid
from izo_ref.solvers.cuda import listed_zones as kernels
from izo_ref.solvers.serial.envelope import dense_tiles
from izo_ref.solvers.serial.group_memory import work_of_group_pivot
from izo_ref.solvers.serial.listed_zones import most_vertices
from izo_ref.solvers.serial.small_zone import Limits
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers, ZoneRows

# Threads of a block. With more than 256, a thread has fewer registers than the kernel uses.
THREADS = 128
# Most shared memory of a block [bytes]. It holds a dense factor of 112 active constraints beside
# the vectors of 256 impacts, and two blocks fit into a multiprocessor of a GPU for computing. What
# does not fit is in the memory of the GPU, behind its caches. Not measured yet.
SHARED = 96 << 10
# Most impacts of a zone that a block solves, and tiles of its factor. All blocks together solve
# zones that need more. The zones of armadillo-rollers with 500 to 1,000 impacts take up to 193
# tiles. The work space of all blocks is 180 MB with 132 multiprocessors. Not measured yet: a block
# has fewer threads, but they wait for each other in less time than all blocks do.
LARGEST, MOST_TILES = 1024, 256
# Blocks of a multiprocessor; its registers have room for two at a time.
BLOCKS = 2
# Tiles of a factor for each impact for which the step has room. The large zones of
# cloth-ball-clean took at most 1.4 for each active constraint, those of armadillo-rollers,
# stack-6k, sheets-10k and sheets-50k at most 0.63. A zone that needs more goes to the CPU.
TILES_PER_IMPACT = 2

Launch = Callable[..., None]


def launch_in_blocks(
    zones: GpuArray,
    impact_offsets: GpuArray,
    vertex_offsets: GpuArray,
    sizes: GpuArray,
    rows: ZoneRows,
    limits: Limits,
    answers: ZoneAnswers,
) -> Launch:
    """Return the launch that solves a list of middle zones, one block a zone.

    Args:
        zones: (n,) i8, the list.
        impact_offsets: (n_zones + 1,) i8.
        vertex_offsets: (n_zones + 1,) i8.
        sizes: (N_SIZES,) i8; MIDDLE is the length of the list, and TICKET is 0 before the launch.
        rows: The constraints of all zones.
        limits: What counts as solved, with its array on the GPU.
        answers: The entries of these zones are written.
    """
    n_blocks, n_threads = fixed_launch(BLOCKS, THREADS)
    n_numbers, n_indices = work_of_group_pivot(LARGEST, most_vertices(LARGEST), MOST_TILES)
    work = empty((n_blocks, n_numbers), np.float64), empty((n_blocks, n_indices), np.int32)
    own = zones, impact_offsets, vertex_offsets, rows, limits, sizes, answers, *work
    n_bytes = min(SHARED, largest_shared_bytes())
    return kernels.solve_list_in_blocks.prepare(n_blocks, n_threads, *own, shared_bytes=n_bytes)


def launch_by_grid(
    large: GpuArray,
    middle: GpuArray,
    impact_offsets: GpuArray,
    vertex_offsets: GpuArray,
    sizes: GpuArray,
    rows: ZoneRows,
    limits: Limits,
    answers: ZoneAnswers,
) -> Launch:
    """Return the launch that solves zones by all blocks, behind `launch_in_blocks`.

    Args:
        large: (n,) i8, the list of large zones; LARGE is its length.
        middle: (n,) i8, the list of middle zones, of which those without room for a factor are
            solved.
        impact_offsets: These and the other arguments are those of `launch_in_blocks`.
        vertex_offsets: The same.
        sizes: The same.
        rows: The same.
        limits: The same.
        answers: The same.
    """
    m, n = rows.rhs.shape[0], rows.positions.shape[0]
    n_tiles = min(dense_tiles(m), TILES_PER_IMPACT * m)
    n_numbers, n_indices = work_of_group_pivot(m, n, n_tiles)
    work = empty(n_numbers, np.float64), empty(n_indices, np.int32)
    own = large, middle, impact_offsets, vertex_offsets, sizes, rows, limits, answers
    return by_grid(kernels.solve_list_by_grid, *own, *work)
