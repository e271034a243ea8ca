"""Starts that touch or cross, and pairs nearer than rounding, on a GPU as on the CPU."""

import numpy as np
import pytest

import izo_ref
from tests.helpers.touching import random_scene

# pure Python and numpy warn where compiled code divides by zero silently
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")

FACE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])


def same_impacts(scene):
    """Check that a GPU finds the impacts of the CPU, in the same order, with the same frames."""
    expected, found = izo_ref.find_impacts(scene), izo_ref.find_impacts(scene, device="cuda")
    for own, other in zip(found, expected, strict=True):
        assert np.array_equal(own, other)
    return len(expected.toi)


def test_touching_starts_have_the_same_impacts_and_answers():
    touching = impacts = 0
    for seed in range(40):
        start, end, faces, pinned = random_scene(np.random.default_rng(seed))
        scene = izo_ref.Scene(start, end, faces, pinned=pinned, initial_intersections="ratchet")
        touching += scene.touching is not None
        impacts += same_impacts(scene)
        if seed % 8:
            continue
        expected = izo_ref.resolve(scene, 1e-2)
        result = izo_ref.resolve(scene, 1e-2, device="cuda")
        assert result.status is expected.status
        np.testing.assert_allclose(result.positions, expected.positions, atol=1e-6)
        own, other = result.certificate, expected.certificate
        assert np.array_equal(own.excluded_ends, other.excluded_ends)
    assert min(touching, impacts) > 10


@pytest.mark.parametrize("gap", [1e-12, 1e-15, 5e-324])
@pytest.mark.parametrize("move", [-0.1, 0.1])
def test_pairs_nearer_than_rounding_are_decided_exactly(gap, move):
    start = np.concatenate((FACE, [[0.2, 0.3, gap]]))
    end = start.copy()
    end[3, 2] += move
    scene = izo_ref.Scene(start, end, [[0, 1, 2]], pinned=[1, 1, 1, 0])
    assert same_impacts(scene) == (move < 0.0)
    assert izo_ref.resolve(scene, 1e-3, device="cuda").status is izo_ref.Status.FREE


@pytest.mark.parametrize("prescribed", ["exclude", "block"])
def test_pinned_parts_that_cross_end_as_on_the_cpu(prescribed):
    needle = np.array([[0.2, 0.2, 1.0], [0.3, 0.2, 1.0], [0.2, 0.2, 2.0]])
    start = np.concatenate((FACE, needle, FACE + (9, 0, 0), needle + (9, 0, 0)))
    end = start.copy()
    end[3:6, 2] -= 2.0
    end[9:, 2] -= 2.0
    pinned = np.arange(12) < 9
    faces = np.arange(12).reshape(4, 3)
    scene = izo_ref.Scene(start, end, faces, pinned=pinned, prescribed=prescribed)
    expected = izo_ref.resolve(scene, 1e-2)
    result = izo_ref.resolve(scene, 1e-2, device="cuda")
    assert result.status is expected.status
    assert result.time_free == expected.time_free
    np.testing.assert_allclose(result.positions, expected.positions, atol=1e-9)
