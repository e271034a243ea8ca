"""Kernels of a step on a GPU that run before and after the iterations."""

from numba import cuda

from izo_ref.base.arrays import Flags, Floats, Indices, Ints, Multipliers, Positions
from izo_ref.base.cuda.compile import cuda_kernel


@cuda_kernel
def begin_step(
    # In:
    proposed: Positions,  # (n_vertices, 3) f8  [m]
    multipliers: Multipliers,  # (n_impacts,) f8  [kg]
    # Out:
    positions_out: Positions,  # (n_vertices, 3) f8  [m], the proposed ones
    stuck_out: Flags,  # (n_vertices,) b1, all false
    known_depths_out: Ints,  # (n_vertices,) i4, all 0
    active_out: Flags,  # (n_impacts,) b1, the multiplier is positive
) -> None:
    """Go back to the proposed positions."""
    i = cuda.grid(1)
    if i < proposed.shape[0]:
        stuck_out[i], known_depths_out[i] = False, 0
        for axis in range(3):
            positions_out[i, axis] = proposed[i, axis]
    if i < multipliers.shape[0]:
        active_out[i] = multipliers[i] > 0.0


@cuda_kernel
def take_positions(
    # In:
    rows: Positions,  # (n_rows, 3) f8  [m], in the caller's numbering
    order: Indices,  # (n_vertices,) i8, the row of each vertex
    centre: Floats,  # (3,) f8  [m]
    radius: float,  # f8  [m]
    # Out:
    positions_out: Positions,  # (n_vertices, 3) f8  [m]
    outside_out: Indices,  # (1,) i8, counts numbers not in the cube of this centre and radius
) -> None:
    """Copy positions of the caller, and count numbers far outside, or not finite."""
    i = cuda.grid(1)
    if i < order.shape[0]:
        for axis in range(3):
            x = rows[order[i], axis]
            positions_out[i, axis] = x
            if not abs(x - centre[axis]) <= radius:
                cuda.atomic.add(outside_out, 0, 1)
