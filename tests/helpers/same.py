"""Comparisons of what a GPU returns with what is expected, bit by bit."""

import numpy as np

from izo_ref.base.gpu_arrays import to_cpu


def same_columns(found, expected):
    """Check that arrays of the GPU are those of the CPU."""
    for own, other in zip(found, expected, strict=True):
        assert np.array_equal(to_cpu(own), other)


def same_result(found, expected):
    """Check that two results have the same answer; their histories may differ."""
    assert found.status is expected.status
    assert np.array_equal(found.positions, expected.positions)
    assert np.array_equal(found.multipliers, expected.multipliers)
    for own, other in zip(found.impacts, expected.impacts, strict=True):
        assert np.array_equal(own, other)
