"""Which contacts become impacts, and which impacts are kept from one path to the next."""

import numpy as np
import pytest

from izo_ref.base.records import Pairs
from izo_ref.detection.known_impacts import KnownImpacts
from izo_ref.detection.near_pairs import Contacts
from izo_ref.detection.pair_keys import pair_keys

# two faces, each with a vertex that is 1 m, or next to nothing, above it
FACE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
START = np.array([(0.25, 0.25, 1.0), *FACE, (5.25, 0.25, 1e-20), *FACE], float)
START[5:, 0] += 5.0
NODES = np.array([[0, 1, 2, 3], [4, 5, 6, 7]], np.int32)


def contacts(toi, keys=(-9, -5)):
    """Return contacts of both pairs, at some times, with directions that are noise."""
    n = len(keys)
    return Contacts(np.array(keys), NODES[:n].copy(), np.array(toi), np.tile([1.0, 0, 0], (n, 1)))


def fallen(first, second):
    """Return the ends of a path on which the two vertices fall by some heights."""
    end = START.copy()
    end[0, 2] -= first
    end[4, 2] -= second
    return end


@pytest.mark.parametrize(
    ("start_is_free", "falls", "toi", "expected"),
    [
        (True, (2.0, 1.0), [0.5, 0.0], [0, 1]),
        (True, (2.0, -1.0), [0.5, 0.0], [0]),  # it rises, which floats cannot tell
        (True, (2.0, -1.0), [0.5, 0.25], [0, 1]),  # no doubt is left after the start
        (True, (2.0, 0.0), [0.5, 0.0], [0]),  # a pair at rest
        (True, (2.0, 0.0), [0.5, 0.25], [0]),
        (False, (2.0, 0.0), [0.5, 0.25], [0, 1]),
        (False, (2.0, -1.0), [0.5, 0.0], [0, 1]),
        (False, (0.0, 0.0), [0.5, 0.0], [0, 1]),
    ],
)
def test_contacts_that_cannot_meet_are_no_impacts(start_is_free, falls, toi, expected):
    known = KnownImpacts(START, start_is_free, None)
    known.add([contacts([], ()), contacts(toi)], fallen(*falls))
    assert known.impacts.nodes.tolist() == NODES[expected].tolist()
    assert not known.impacts.is_edge_edge.any()
    for normal, own in zip(known.impacts.normals, expected, strict=True):
        if start_is_free and falls[own] > 0.0:
            np.testing.assert_allclose(np.abs(normal), [0.0, 0.0, 1.0], atol=1e-12)


def test_edges_are_decided_as_edges():
    """Edges that cross in space do not meet where the first one rises at the start."""
    start = np.array([[-1, 0, 1e-20], [1, 0, 1e-20], [0, -1, 0], [0, 1, 0.0]])
    one = Contacts(np.array([3]), NODES[:1], np.zeros(1), np.array([[1.0, 0.0, 0.0]]))
    for shift, meets in ((1.0, False), (-1.0, True)):
        known = KnownImpacts(start, True, None)
        known.add([one], start + (np.arange(4) < 2)[:, None] * np.array([0.0, 0.0, shift]))
        assert known.impacts.is_edge_edge.tolist() == [True] * meets


def test_impacts_are_sorted_kept_and_forgotten_and_excluded_pairs_never_come():
    known, end = KnownImpacts(START, True, None), fallen(2.0, 1.0)
    known.add([contacts([0.5, 0.25]).take(np.array([1]))], end)
    known.add([contacts([0.5, 0.25]).take(np.array([0]))], end)
    assert known.impacts.nodes.tolist() == NODES.tolist()
    assert known.impacts.toi.tolist() == [0.5, 0.25]
    known.add([contacts([], ())], end)
    moves = np.zeros(8)
    known.forget(moves)
    assert len(known.impacts.toi) == 2
    moves[2] = 1e-300  # a corner of the first face
    known.forget(moves)
    assert known.impacts.nodes.tolist() == NODES[1:].tolist()
    named = set(pair_keys(Pairs(NODES[1:], np.zeros(1, bool))))
    known = KnownImpacts(START, True, named)
    known.add([contacts([0.5, 0.25])], end)
    assert known.impacts.nodes.tolist() == NODES[:1].tolist()
