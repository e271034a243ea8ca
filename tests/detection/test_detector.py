"""The detector: it follows a path, keeps what did not change, and leaves out excluded pairs."""

import numpy as np
import pytest

import izo_ref
from izo_ref.base.options import RULES
from izo_ref.base.records import PairState
from izo_ref.detection.detector import Detector
from tests.helpers.shapes import grid, two_sheets


def same_impacts(a, b):
    """Check that two sets of impacts have the same bits."""
    for x, y in zip(a, b, strict=True):
        np.testing.assert_array_equal(x, y)


@pytest.mark.parametrize("rules", [frozenset(RULES), frozenset()])
@pytest.mark.parametrize("share", [0.02, 0.3, 1.0])
def test_a_detector_that_follows_a_path_finds_what_a_new_one_finds(rng, share, rules):
    """The ends move far at first, then less and less, as in the loop; some vertices go back."""
    scene = two_sheets(rng)
    mesh = scene.positions_t0, scene.edges, scene.faces
    detector = Detector(*mesh, rules=rules)
    end = scene.positions_t1.copy()
    sizes, found = [], detector.find(end)
    for size in (0.1, 0.03, 0.01, 1e-3, 1e-3, 1e-5, 0.05, 1e-7, 1e-9, 0.0):
        same_impacts(found, Detector(*mesh).find(end))
        sizes.append(len(found.toi))
        part = rng.random((len(end), 1)) < share
        back = rng.random((len(end), 1)) < 0.1
        step = size * rng.normal(size=end.shape)
        end = np.where(part, np.where(back, scene.positions_t0, end + step), end)
        found = detector.find(end)
    assert len(set(sizes)) > 3


@pytest.mark.parametrize("mover", ["lower", "upper"])
@pytest.mark.parametrize(
    "steps",  # that close the gap of 0.05; an edge is 1 / 7 long, and "far" is 0.1 of that
    [
        (0.045, 0.003, 0.0029),
        (0.04, 0.003, 0.0029, 0.0028, 0.0027),
        (0.028, 0.01, 0.005, 0.005, 0.004),
    ],
    ids=["in one step", "creeping", "each step within the margin"],
)
def test_impacts_within_the_reach_are_found(rng, mover, steps):
    """A sheet approaches by smaller and smaller steps, each within the reach of the first."""
    start, faces = grid(8, 0.0, jitter=1e-5 * rng.normal(size=(64, 3)))
    start = np.concatenate((start, start + (0.013, 0.021, 0.05)))
    faces = np.concatenate((faces, faces + 64)).astype(np.int32)
    edges = izo_ref.Scene(start, start, faces).edges
    detector = Detector(start, edges, faces)
    moves = slice(0, 64) if mover == "lower" else slice(64, 128)
    # Both sheets move, because elements at rest are in no tree.
    end, found = start + (1e-4, 0.0, 0.0), []
    for nearer in steps:
        end[moves, 2] += nearer if mover == "lower" else -nearer
        found.append(detector.find(end))
    assert [len(impacts.toi) > 0 for impacts in found] == [False] * (len(steps) - 1) + [True]
    same_impacts(found[-1], Detector(start, edges, faces).find(end))


def test_a_component_at_rest_is_found_once_something_reaches_it(rng):
    """Two sheets start far from each other; a later path leads one sheet to the other."""
    scene = two_sheets(rng)
    n = len(scene.positions_t0) // 2
    start = scene.positions_t0.copy()
    start[n:, 2] += 100.0
    mesh = start, scene.edges, scene.faces
    detector = Detector(*mesh)
    end = start.copy()
    end[:n, 2] += 1.0
    assert len(detector.find(end).toi) == 0
    every = Detector(*mesh, rules=frozenset())
    every.find(end)
    assert sum(detector.counts.pairs.values()) < sum(every.counts.pairs.values())
    end[:n, 2] += 200.0
    found = detector.find(end)
    assert len(found.toi) > 100
    same_impacts(found, Detector(*mesh, rules=frozenset()).find(end))


@pytest.mark.parametrize("shift", [(0, 0, 5), (0, -3, 0)], ids=["vertex-face", "edge-edge"])
@pytest.mark.parametrize("turn", range(3))
@pytest.mark.parametrize("order", [range(6), range(5, -1, -1)], ids=["up", "down"])
def test_excluded_pairs_are_excluded_everywhere(shift, turn, order):
    """A triangle that intersects another one moves out of it, so only excluded pairs meet.

    This holds for any numbering and any first corner, although `resolve` renumbers the scene.
    """
    start = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [0.9, 1, 2], [1.1, 1.05, 2]])
    end = start.copy()
    end[3:] += shift
    order = np.array(order)
    faces = np.argsort(order)[[np.roll([0, 1, 2], turn), np.roll([3, 4, 5], turn)]]
    with pytest.raises(izo_ref.base.errors.InitialIntersectionError):
        izo_ref.Scene(start[order], end[order], faces)
    scene = izo_ref.Scene(start[order], end[order], faces, initial_intersections="exclude")
    assert len(izo_ref.find_impacts(scene).toi) == 0
    assert izo_ref.certify_path(scene, end[order]).free
    result = izo_ref.resolve(scene, 1e-3)
    assert result.status is izo_ref.Status.FREE_EXCEPT_EXCLUDED
    assert result.certificate.excluded_ends.tolist() == [PairState.APART] * len(
        scene.excluded.nodes
    )
    assert len(result.impacts.toi) == 0
    np.testing.assert_array_equal(result.positions, end[order])
    scene.excluded = None  # without the list, the same pairs are found
    assert len(izo_ref.find_impacts(scene).toi) > 0
