"""The first contact of one pair, as detection decides it."""

import numpy as np

from izo_ref.detection.formulas.advance import MAX_STEPS, advance

NO_REACH = (0.0, 0.0, 0.0, 0.0)


def first_contact(is_edge_edge, start, end):
    """Call `advance` for one pair without reach.

    Args:
        is_edge_edge: kind of the pair.
        start, end: (4, 3) positions of its nodes at t = 0 and t = 1 [m].

    Returns:
        status, time, direction and number of steps, as `advance` returns them.
    """
    relative = [
        tuple(float(x) for x in np.subtract(p[k], p[0])) for p in (start, end) for k in (1, 2, 3)
    ]
    return advance(is_edge_edge, *relative, NO_REACH, MAX_STEPS)
