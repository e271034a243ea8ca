"""How far vertices move, and within what reach they are expected to end."""

import numpy as np

from izo_ref.base.arrays import AnyInt, Flags, Floats, Positions
from izo_ref.base.compile import compiled


@compiled
def _largest_difference(i: AnyInt, a: Positions, b: Positions) -> float:
    """Return how far point i of two arrays is apart along the axis on which that is farthest."""
    return max(abs(a[i, 0] - b[i, 0]), abs(a[i, 1] - b[i, 1]), abs(a[i, 2] - b[i, 2]))


@compiled
def largest_moves(positions: Positions, previous: Positions) -> tuple[Floats, int]:
    """Return how far each vertex moved, and how many vertices moved.

    Args:
        positions: (n_vertices, 3) f8 [m].
        previous: (n_vertices, 3) f8 [m].

    Returns:
        (n_vertices,) f8 [m], the move along the axis on which it is largest, rounded up; and the
        number of vertices that moved.
    """
    moves, n_moved = np.empty(positions.shape[0]), 0
    for i in range(positions.shape[0]):
        # the factor covers the rounding of the difference
        moves[i] = _largest_difference(i, positions, previous) * (1.0 + 2.0**-50)
        n_moved += moves[i] > 0.0
    return moves, n_moved


@compiled
def renew_reach(
    positions: Positions,  # (n_vertices, 3) f8 [m]
    moves: Floats,  # (n_vertices,) f8 [m], of the vertices since the last detection
    reach_per_move: float,  # f8, a new reach over the move
    far_reach: float,  # f8 [m], largest new reach
    centres_out: Positions,  # (n_vertices, 3) f8 [m], about which vertices are expected to end
    reach_out: Floats,  # (n_vertices,) f8 [m], of each vertex about its centre, along each axis
    left_out: Flags,  # (n_vertices,) b1, the vertex left its reach
) -> int:
    """Give a new centre and reach to the vertices that left theirs, and return how many did."""
    n_left = 0
    for i in range(positions.shape[0]):
        left_out[i] = _largest_difference(i, positions, centres_out) > reach_out[i]
        if left_out[i]:
            n_left += 1
            reach_out[i] = min(reach_per_move * moves[i], far_reach)
            for axis in range(3):
                centres_out[i, axis] = positions[i, axis]
    return n_left
