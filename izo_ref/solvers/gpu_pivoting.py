"""Block pivoting on a GPU: one block of threads for each zone of some hundred impacts."""

from collections.abc import Callable

import numpy as np

from izo_ref.base.arrays import GpuArray
from izo_ref.base.devices import fixed_launch, largest_shared_bytes
from izo_ref.base.gpu_arrays import empty
from izo_ref.solvers.cuda import listed_zones as kernels
from izo_ref.solvers.serial.group_memory import work_of_group_pivot
from izo_ref.solvers.serial.listed_zones import most_vertices
from izo_ref.solvers.serial.small_zone import Limits
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers, ZoneRows

# Threads of a block. With more than 256, a thread has fewer registers than the kernel uses.
THREADS = 128
# Most shared memory of a block [bytes]. It holds the factor of 130 active constraints beside the
# vectors of 256 impacts, and two blocks fit into a multiprocessor of a GPU for computing. What does
# not fit is in the memory of the GPU, behind its caches. Not measured yet.
SHARED = 96 << 10
# Most impacts of a zone that a block solves, and most active ones among them. The processor solves
# larger zones: its factors are sparse, and the factors of a block are dense.
LARGEST, MOST_ACTIVE = 512, 256
# Blocks of a multiprocessor; its registers have room for two at a time.
BLOCKS = 2


class BlockPivoting:
    """Blocks of threads, each with its work space, which take the zones of a list."""

    def __init__(self) -> None:
        """Allocate the work space."""
        self._sizes = fixed_launch(BLOCKS, THREADS)
        n_numbers, n_indices = work_of_group_pivot(LARGEST, most_vertices(LARGEST), MOST_ACTIVE)
        self._numbers = empty((self._sizes[0], n_numbers), np.float64)
        self._indices = empty((self._sizes[0], n_indices), np.int32)

    def launch(
        self,
        zones: GpuArray,
        impact_offsets: GpuArray,
        vertex_offsets: GpuArray,
        sizes: GpuArray,
        rows: ZoneRows,
        limits: Limits,
        answers: ZoneAnswers,
    ) -> Callable[..., None]:
        """Return the launch that solves the zones of a list.

        Args:
            zones: (n,) i8, the list.
            impact_offsets: (n_zones + 1,) i8.
            vertex_offsets: (n_zones + 1,) i8.
            sizes: (N_SIZES,) i8; MIDDLE is the length of the list, and TICKET is 0 before the
                launch.
            rows: The constraints of all zones.
            limits: What counts as solved, with its array on the GPU.
            answers: The entries of these zones are written.
        """
        own = zones, impact_offsets, vertex_offsets, rows, limits, MOST_ACTIVE, sizes, answers
        launch, n_bytes = self._sizes, min(SHARED, largest_shared_bytes())
        work = self._numbers, self._indices
        return kernels.solve_list_in_blocks.prepare(*launch, *own, *work, shared_bytes=n_bytes)
