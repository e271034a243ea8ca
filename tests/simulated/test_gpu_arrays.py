"""Operations on arrays of a GPU, compared with numpy."""

import numpy as np
import pytest

from izo_ref.base import gpu_arrays as arrays


@pytest.mark.parametrize("n", [0, 1, 3, 40])
def test_orders_are_stable(rng, n):
    keys = rng.integers(-3, 4, n) << 40
    own = arrays.to_gpu(keys)
    order = arrays.to_cpu(arrays.stable_argsort(own))
    assert np.array_equal(order, np.argsort(keys, kind="stable"))
    assert np.array_equal(arrays.to_cpu(own), keys), "the keys themselves stay"


def test_rows_are_taken(rng):
    rows, index = rng.normal(size=(7, 3)), np.array([6, 0, 0])
    taken = arrays.take(arrays.to_gpu(rows), arrays.to_gpu(index))
    assert np.array_equal(arrays.to_cpu(taken), rows[index])
    numbers = arrays.take(arrays.to_gpu(np.arange(3, 10)), arrays.to_gpu(index))
    assert arrays.to_cpu(numbers).tolist() == [9, 3, 3]
