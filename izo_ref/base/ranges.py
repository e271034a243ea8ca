"""Index arrays of blocks that lie side by side, and numbers without repetition."""

import numpy as np


def ranges(starts, counts):
    """starts[0], starts[0] + 1, ... (counts[0] of them), then the same of starts[1], ..."""
    before = np.cumsum(counts) - counts
    return np.arange(counts.sum()) + np.repeat(starts - before, counts)


def distinct(numbers):
    """The numbers that there are, ascending.

    As `np.unique`, which from numpy 2.3 on looks integers up in a table: for the edges of a
    million triangles that takes fifty times as long as sorting them.
    """
    ascending = np.sort(numbers)
    first = np.ones(len(ascending), bool)
    np.not_equal(ascending[1:], ascending[:-1], out=first[1:])
    return ascending[first]


def members(values, offsets, chosen):
    """The blocks chosen, one after the other, and where each begins."""
    counts = np.diff(offsets)[chosen]
    index = ranges(offsets[:-1][chosen], counts)
    return values[index], np.concatenate(([0], np.cumsum(counts)))
