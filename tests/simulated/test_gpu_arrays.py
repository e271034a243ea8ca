"""Operations on arrays of a GPU, compared with numpy."""

import numpy as np
import pytest

from izo_ref.base import gpu_arrays as arrays
from izo_ref.base.records import Pairs
from validation.study.gpu_sort import stable_argsort


@pytest.mark.parametrize("n", [0, 1, 3, 40])
def test_orders_are_stable(rng, n):
    keys = rng.integers(-3, 4, n) << 40
    own = arrays.to_gpu(keys)
    order = arrays.to_cpu(stable_argsort(own))
    assert np.array_equal(order, np.argsort(keys, kind="stable"))
    assert np.array_equal(arrays.to_cpu(own), keys), "the keys themselves stay"


@pytest.mark.parametrize("shape", [(7, 3), (7,)])
def test_rows_are_put(rng, shape):
    values, index = rng.normal(size=shape), np.array([6, 0, 2])
    own = arrays.to_gpu(values)
    arrays.put_rows(arrays.to_gpu(index), arrays.to_gpu(values[:3]), own)
    expected = values.copy()
    expected[index] = values[:3]
    assert np.array_equal(arrays.to_cpu(own), expected)


def test_records_are_copied_and_overwritten_column_by_column(rng):
    pairs = Pairs(rng.integers(0, 9, (5, 4), np.int32), rng.random(5) < 0.5)
    own = arrays.to_gpu(pairs)
    assert isinstance(own, Pairs)
    few = Pairs(pairs.nodes[3:], pairs.is_edge_edge[3:])
    arrays.overwrite(own, arrays.to_gpu(few))
    found = arrays.to_cpu(own)
    assert np.array_equal(found.nodes, np.concatenate((few.nodes, pairs.nodes[2:])))
    assert np.array_equal(found.is_edge_edge, [*few.is_edge_edge, *pairs.is_edge_edge[2:]])
