"""Index arrays of blocks that lie side by side."""

import numpy as np


def ranges(starts, counts):
    """starts[0], starts[0] + 1, ... (counts[0] of them), then the same of starts[1], ..."""
    before = np.cumsum(counts) - counts
    return np.arange(counts.sum()) + np.repeat(starts - before, counts)
