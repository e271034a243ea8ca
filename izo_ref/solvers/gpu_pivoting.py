"""Block pivoting on a GPU: one block of threads for each zone of some hundred impacts."""

import numpy as np

from izo_ref.base.arrays import GpuArray
from izo_ref.base.devices import count_resident_blocks, largest_shared_bytes
from izo_ref.base.gpu_arrays import empty
from izo_ref.solvers.cuda import group_pivot as kernels
from izo_ref.solvers.gpu_constraints import GpuConstraints, GpuSolution
from izo_ref.solvers.gpu_sizes import zones_of_size
from izo_ref.solvers.serial.group_memory import work_of_group_pivot
from izo_ref.solvers.serial.small_zone import Limits

# Threads of a block. With more than 256, a thread has fewer registers than the kernel uses.
THREADS = 128
# Most shared memory of a block [bytes]. It holds the factor of 130 active constraints beside the
# vectors of 256 impacts, and two blocks fit into a multiprocessor of a GPU for computing. What does
# not fit is in the memory of the GPU, behind its caches. Not measured yet.
SHARED = 96 << 10
# Most impacts of a zone that a block solves, and most active ones among them. The processor solves
# larger zones: its factors are sparse, and the factors of a block are dense.
LARGEST, MOST_ACTIVE = 512, 256


def solve_in_blocks(
    constraints: GpuConstraints, more_than: int, limits: Limits, solution: GpuSolution
) -> GpuArray:
    """Solve the zones that are not too large for a block.

    Args:
        constraints: The constraints of all zones.
        more_than: Impacts; zones with no more impacts are left alone.
        limits: What counts as solved, with its array on the GPU.
        solution: Its entries of these zones are written.

    Returns:
        (n_zones,) i4, the number of solves of each of these zones; other entries are invalid.
    """
    zones = zones_of_size(constraints.impact_offsets, more_than, LARGEST)
    n_blocks = min(zones.shape[0], 2 * count_resident_blocks())  # registers allow two at a time
    steps = empty(solution.solved.shape[0], np.int32)
    if n_blocks == 0:
        return steps
    n_bytes = min(SHARED, largest_shared_bytes())
    # an impact has at most four vertices of its own
    n_numbers, n_indices = work_of_group_pivot(LARGEST, 4 * LARGEST, MOST_ACTIVE)
    kernels.solve_zones_in_blocks.in_blocks(n_blocks, THREADS, n_bytes)(
        zones,
        *constraints,
        limits,
        MOST_ACTIVE,
        *solution,
        steps,
        empty((n_blocks, n_numbers), np.float64),
        empty((n_blocks, n_indices), np.int32),
    )
    return steps
