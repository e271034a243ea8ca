"""Searches in sorted arrays, against looking at every entry."""

import numpy as np

from izo_ref.base.serial.search import first_not_below, is_among


def test_searches_find_what_looking_at_every_entry_finds(rng):
    for n in (0, 1, 2, 3, 7, 30):
        ascending = np.sort(rng.integers(0, 20, n))
        for value in range(-1, 22):
            expected = sum(entry < value for entry in ascending.tolist())
            assert first_not_below(value, ascending) == expected
            assert is_among(value, ascending) == (value in ascending.tolist())
