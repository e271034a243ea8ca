"""Keys that a thread group sorts: one thread here, several in tests/simulated."""

import numpy as np
import pytest

from izo_ref.base.serial.group_sort import RUN, group_sort
from izo_ref.base.serial.thread_group import ALONE

SIZES = [0, 1, 2, RUN - 1, RUN, RUN + 1, 2 * RUN, 2 * RUN + 1, 3 * RUN, 4 * RUN + 3, 1000, 4096]


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("n_different", [1, 3, 10**6])
def test_keys_are_sorted_and_equal_ones_keep_their_order(rng, n, n_different):
    values = rng.integers(-n_different, n_different, n)
    expected = np.argsort(values, kind="stable")
    # the arrays are longer than n, and what is behind the keys stays
    keys, places, more, more_places = (np.full(n + 5, -7) for _ in range(4))
    keys[:n] = values
    group_sort(ALONE, n, keys, places, more, more_places)
    assert np.array_equal(places[:n], expected)
    assert np.array_equal(keys[:n], values[expected])
    for array in (keys, places, more, more_places):
        assert (array[n:] == -7).all()


def test_the_ends_of_the_range_are_sorted_too(rng):
    ends = np.iinfo(np.int64)
    keys = rng.permutation(np.concatenate((np.repeat([ends.min, ends.max, 0, -1], 9), range(20))))
    expected = np.argsort(keys, kind="stable")
    places, more, more_places = (np.empty_like(keys) for _ in range(3))
    group_sort(ALONE, len(keys), keys, places, more, more_places)
    assert np.array_equal(places, expected)
