"""Operations on arrays of a GPU, compared with numpy."""

import sys
import types

import numpy as np
import pytest

from izo_ref.base import gpu_arrays as arrays
from izo_ref.base import gpu_interop as interop
from izo_ref.base.cuda import arrays as kernels
from izo_ref.base.cuda import compile as _jit
from izo_ref.base.cuda.arrays import LARGEST, LEAST, SUM

THREADS, ITEMS = 4, 2
TILE = THREADS * ITEMS
SIZES = [1, 3, TILE, 3 * TILE + 3]


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    """Make blocks small: the simulator starts a thread of the system for each of their threads."""
    sizes = {"THREADS": THREADS, "ITEMS": ITEMS, "TILE": TILE, "TILES": 4 * TILE}
    for module in (_jit, kernels, arrays):
        for name, value in sizes.items():
            if hasattr(module, name):
                monkeypatch.setattr(module, name, value)


@pytest.mark.parametrize("n", [*SIZES, TILE**2 + 1])
def test_offsets_are_the_sums_before_each_entry(rng, n):
    values = rng.integers(0, 9, n)
    starts = arrays.to_cpu(arrays.offsets_of(arrays.to_gpu(values)))
    assert np.array_equal(starts, np.concatenate(([0], np.cumsum(values))))


@pytest.mark.parametrize("n", [0, *SIZES])
def test_flatnonzero_finds_the_true_flags(rng, n):
    flags = rng.random(n) < 0.3
    index = arrays.to_cpu(arrays.flatnonzero(arrays.to_gpu(flags)))
    assert np.array_equal(index, np.flatnonzero(flags))


@pytest.mark.parametrize("n", [0, *SIZES])
def test_orders_are_stable(rng, n):
    keys = rng.integers(-3, 4, n) << 40
    order = arrays.to_cpu(arrays.stable_argsort(arrays.to_gpu(keys)))
    assert np.array_equal(order, np.argsort(keys, kind="stable"))


def test_long_arrays_are_sorted_by_cupy_if_it_is_installed(rng, monkeypatch):
    asked = []

    def argsort(keys):
        asked.append(len(keys))
        return arrays.shared_copy(np.argsort(arrays.to_cpu(keys), kind="stable"))

    cupy = types.SimpleNamespace(asarray=lambda keys: keys, argsort=argsort)
    monkeypatch.setitem(sys.modules, "cupy", cupy)
    keys = rng.integers(-3, 4, 5 * TILE)
    for there in (False, True):
        # In the simulator, cupy is never reported as installed.
        assert not interop.has_cupy()
        monkeypatch.setattr(arrays, "has_cupy", lambda there=there: there)
        order = arrays.to_cpu(arrays.stable_argsort(arrays.to_gpu(keys)))
        assert np.array_equal(order, np.argsort(keys, kind="stable"))
        assert asked == ([5 * TILE] if there else [])


@pytest.mark.parametrize("n", [*SIZES, TILE**2 + 2])
def test_columns_are_reduced_to_sum_largest_and_least(rng, n):
    for values in (rng.normal(size=(n, 3)), rng.integers(-9, 9, (n, 3))):
        own = arrays.to_gpu(values)
        assert arrays.reduce(own, LARGEST, 1) == values[:, 1].max()
        assert arrays.reduce(own, LEAST, 2) == values[:, 2].min()
        # the rounding of a sum of n terms in any order
        bound = n * 2.0**-53 * np.abs(values[:, 0]).sum()
        assert abs(arrays.reduce(own, SUM) - values[:, 0].sum()) <= bound


def test_rows_are_taken_and_concatenated(rng):
    rows, index = rng.normal(size=(7, 3)), np.array([6, 0, 0])
    taken = arrays.take(arrays.to_gpu(rows), arrays.to_gpu(index))
    assert np.array_equal(arrays.to_cpu(taken), rows[index])
    nothing = arrays.empty((0, 3), float)
    both = arrays.concatenate([taken, nothing, arrays.to_gpu(rows)])
    assert np.array_equal(arrays.to_cpu(both), np.concatenate((rows[index], rows)))
    numbers = arrays.take(arrays.arange(7, 3), arrays.to_gpu(index))
    assert arrays.to_cpu(numbers).tolist() == [9, 3, 3]
