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
# zones that need more. The zones of 513 to 1,024 impacts of armadillo-rollers, stack-6k, sheets-10k
# and sphere-10k take up to 209 tiles. The work space of all blocks is 186 MB with 132
# multiprocessors. Not measured yet: a block has fewer threads, but they wait for each other in less
# time than all blocks do.
LARGEST, TILES_OF_BLOCK = 1024, 256
# Blocks of a multiprocessor; its registers have room for two at a time.
BLOCKS = 2
# Tiles of a factor for each impact for which the step has room. The large zones of
# cloth-ball-clean took at most 1.4 for each active constraint, those of armadillo-rollers,
# sphere-10k, stack-6k, sheets-10k and sheets-50k at most 0.62. A zone that needs more goes to the
# CPU.
TILES_PER_IMPACT = 2
KINDS = np.float64, np.int32  # of the numbers and the indices of a work space

Launch = Callable[..., None]


def launches_of_pivoting(
    middle: GpuArray,
    large: GpuArray,
    impact_offsets: GpuArray,
    vertex_offsets: GpuArray,
    sizes: GpuArray,
    rows: ZoneRows,
    limits: Limits,
    answers: ZoneAnswers,
) -> list[Launch]:
    """Return two launches: one block solves a zone; then all blocks solve a zone together.

    All blocks solve the large zones, and the middle zones for which a block had no room.

    Args:
        middle: (n,) i8, the list of middle zones.
        large: (n,) i8, the list of large zones.
        impact_offsets: (n_zones + 1,) i8.
        vertex_offsets: (n_zones + 1,) i8.
        sizes: (N_SIZES,) i8; MIDDLE and LARGE are the lengths of the lists, and TICKET is 0 before
            the launches.
        rows: The constraints of all zones.
        limits: What counts as solved, with its array on the GPU.
        answers: The entries of these zones are written.
    """
    offsets = impact_offsets, vertex_offsets
    n_blocks, n_threads = fixed_launch(BLOCKS, THREADS)
    needed = work_of_group_pivot(LARGEST, most_vertices(LARGEST), TILES_OF_BLOCK)
    work = [empty((n_blocks, n), kind) for n, kind in zip(needed, KINDS, strict=True)]
    own = middle, *offsets, rows, limits, sizes, answers, *work
    n_bytes = min(SHARED, largest_shared_bytes())
    in_blocks = kernels.solve_list_in_blocks
    first = in_blocks.prepare(n_blocks, n_threads, *own, shared_bytes=n_bytes)
    m, n_vertices = rows.rhs.shape[0], rows.positions.shape[0]
    needed = work_of_group_pivot(m, n_vertices, min(dense_tiles(m), TILES_PER_IMPACT * m))
    work = [empty(n, kind) for n, kind in zip(needed, KINDS, strict=True)]
    own = large, middle, *offsets, sizes, rows, limits, answers, *work
    return [first, by_grid(kernels.solve_list_by_grid, *own)]
