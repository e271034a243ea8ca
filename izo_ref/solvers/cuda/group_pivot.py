"""Block pivoting, where the threads of a block share a zone."""

import numba
from numba import cuda

from izo_ref.base.arrays import Flags, Floats, Indices, Ints, Multipliers, Nodes, Normals, Offsets
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import WARP, block
from izo_ref.solvers.serial.group_pivot import group_pivot
from izo_ref.solvers.serial.small_zone import Limits


@cuda_kernel
def solve_zones_in_blocks(
    # In:
    zones: Indices,  # (n,) i8, zones to solve
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    unknowns: Nodes,  # (n_impacts, 4) i4, vertices in the order of z; -1 for pinned ones
    coefficients: Floats,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    rhs: Floats,  # (n_impacts,) f8  [m kg^1/2]
    lengths: Floats,  # (n_impacts,) f8  [kg^-1/2], of the rows before scaling
    limits: Limits,  # Limits, of solvers/serial/small_zone.py
    most_active: int,  # i8, largest number of active constraints
    # Out:
    multipliers_out: Multipliers,  # (n_impacts,) f8  [m kg^1/2], for rows of unit length
    z_out: Floats,  # (3 n_unknowns,) f8  [m kg^1/2]
    solved_out: Flags,  # (n_zones,) b1, whether the zone is solved to the limits
    steps_out: Ints,  # (n_zones,) i4
    numbers_out: Floats,  # (n_blocks, k) f8, work space
    indices_out: Ints,  # (n_blocks, l) i4, work space
) -> None:
    """Solve zones, one block a zone; a block solves one zone after the other."""
    shared = cuda.shared.array(0, numba.float64)  # the sums of `block` use its first numbers
    near = shared[3 * (cuda.blockDim.x + WARP) :]
    for i in range(cuda.blockIdx.x, zones.shape[0], cuda.gridDim.x):
        zone = int(zones[i])
        solved, steps = group_pivot(
            block(),
            impact_offsets[zone],
            impact_offsets[zone + 1],
            vertex_offsets[zone],
            vertex_offsets[zone + 1],
            unknowns,
            coefficients,
            normals,
            rhs,
            lengths,
            limits,
            most_active,
            near,
            numbers_out[cuda.blockIdx.x],
            indices_out[cuda.blockIdx.x],
            multipliers_out,
            z_out,
        )
        if cuda.threadIdx.x == 0:
            solved_out[zone], steps_out[zone] = solved, steps
