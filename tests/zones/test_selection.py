"""Which impacts are taken into account next."""

import numpy as np
import pytest

from izo_ref.base.records import Impacts
from izo_ref.zones.selection import select_impacts
from izo_ref.zones.serial.selection import tight_impacts
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


def test_tight_impacts_are_those_without_slack():
    """Two equal impacts at the thickness are both tight, whichever of them pushes."""
    positions = np.array([[0.2, 0.2, 0.1], [0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, 0.2]])
    weights = np.array([1.0, -0.6, -0.2, -0.2])
    nodes = np.array([[0, 1, 2, 3], [0, 1, 2, 3], [4, 1, 2, 3], [0, 1, 2, 3]], np.int32)
    normals = np.array([[0.0, 0.0, 1.0]] * 3 + [[0.0, 0.0, -1.0]])
    tight = np.empty(4, bool)
    tight_impacts(positions, nodes, np.tile(weights, (4, 1)), normals, 0.1, tight)
    assert tight.tolist() == [True, True, False, True]
