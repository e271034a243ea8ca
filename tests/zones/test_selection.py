"""Which impacts are taken into account next."""

import numpy as np
import pytest

from izo_ref.base.records import Impacts
from izo_ref.zones.selection import select_impacts
from tests.naive import groups


def random_impacts(rng, n, k):
    """Draw n impacts of k vertices, many of them at equal times."""
    nodes = np.array([rng.choice(k, 4, replace=False) for _ in range(n)], np.int32).reshape(-1, 4)
    toi = rng.integers(0, 6, n) / 6.0
    return Impacts(nodes, np.zeros(n, bool), toi, np.zeros((n, 4)), np.zeros((n, 3)))


@pytest.mark.parametrize("n", [0, 1, 5, 40])
def test_selections_are_those_of_the_literal_definitions(rng, n):
    for _ in range(20):
        impacts = random_impacts(rng, n, 12)
        pinned = rng.random(12) < 0.3
        usable = impacts.take(~pinned[impacts.nodes].all(axis=1))
        for name, naive in (
            ("independent", groups.independent),
            ("first-of-any", groups.first_of_any),
        ):
            chosen = select_impacts(usable, pinned, name)
            assert np.flatnonzero(chosen).tolist() == naive(usable.toi, usable.nodes, pinned)
        assert select_impacts(usable, pinned, "all").all()
