"""The first contact of one pair, as detection decides it."""

import numpy as np

from izo_ref.detection.formulas.advance import advance


def first_contact(is_edge_edge, start, end):
    """Call `advance` for one pair.

    Args:
        is_edge_edge: kind of the pair.
        start, end: (4, 3) positions of its nodes at t = 0 and t = 1 [m].

    Returns:
        status, time, direction, number of steps and margin, as `advance` returns them.
    """
    relative = [
        tuple(float(x) for x in np.subtract(p[k], p[0])) for p in (start, end) for k in (1, 2, 3)
    ]
    return advance(is_edge_edge, *relative)
