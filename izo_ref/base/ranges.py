"""Index arrays of blocks that lie side by side."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import AnyInts, Indices


def ranges(starts: AnyInts, counts: AnyInts) -> Indices:
    """Return the numbers of several ranges, one range after the other.

    Args:
        starts: (n,) integers, the first number of each range.
        counts: (n,) integers, how many numbers each range has.

    Returns:
        (m,) i8, starts[0], starts[0] + 1, ... (counts[0] numbers), then the same for starts[1], ...
    """
    ends = counts.cumsum()
    total = ends[-1] if len(ends) else 0
    return np.arange(total) + (starts - ends + counts).repeat(counts)
