"""Sides that meet, in exact arithmetic."""

import numpy as np
import pytest

from izo_ref.base import exact
from izo_ref.base.exact import CHUNK, sides_meet, volume_signs
from tests.naive.simplices import simplices_meet

FACE = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
SIDES = [(1, 3), (2, 2), (2, 3)]  # vertices of both sides


def meet(first, second):
    """Return whether one pair of sides meets."""
    return bool(sides_meet(np.array([first], float), np.array([second], float))[0])


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ([(0.2, 0.2, 0)], FACE, True),
        ([(0.2, 0.2, 5e-324)], FACE, False),
        ([(0.5, 0.5, 0)], FACE, True),  # on an edge
        ([(0.5, 0.5 + 2**-53, 0)], FACE, False),
        ([(1, 0, 0)], FACE, True),  # on a corner
        ([(1, 0, 1)], FACE, False),  # over a corner
        ([(-0.0, 0, 0)], FACE, True),
        ([(0.2, 0.2, 1), (0.2, 0.2, -1)], FACE, True),
        ([(0.2, 0.2, 1), (0.2, 0.2, 0)], FACE, True),  # an end in the face
        ([(0.2, 0.2, 1), (0.2, 0.2, 1e-300)], FACE, False),
        ([(0.5, 0, 1), (0.5, 0, -1)], FACE, True),  # through a side
        ([(0.5, -5e-324, 1), (0.5, -5e-324, -1)], FACE, False),
        ([(0, 0, 1), (0, 0, -1)], FACE, True),  # through a corner
        ([(2, 2, 0), (2, 2, 1)], FACE, False),  # an end in the plane, beside the face
        ([(-1, 0.5, 0), (1, 0.5, 0)], FACE, True),  # in the plane, across
        ([(-1, -0.5, 0), (1, -0.5, 0)], FACE, False),  # in the plane, beside
        ([(0.2, 0.2, 0), (0.3, 0.2, 0)], FACE, True),  # in the plane, inside
        ([(0, 0, 0), (1, 0, 0)], [(0.5, 0, 0), (2, 0, 0)], True),  # collinear, overlap
        ([(0, 0, 0), (1, 0, 0)], [(1.5, 0, 0), (2, 0, 0)], False),  # collinear, apart
        ([(1.5, 0, 0), (2, 0, 0)], [(0, 0, 0), (1, 0, 0)], False),
        ([(0, 0, 0), (0, 0, 0)], [(0, -1, 0), (0, 1, 0)], True),  # an edge without length
        ([(0, 0, 0), (1, 0, 0)], [(2, -1, 0), (2, 1, 0)], False),  # coplanar, beside
        ([(0, 0, 0)], [(-1, 0, 0), (1, 0, 0), (2, 0, 0)], True),  # a face without area
        ([(0, 1, 0), (0, -1, 0)], [(-1, 0, 0), (1, 0, 0), (2, 0, 0)], True),
        ([(0, 1, 0), (0, 1e-9, 0)], [(-1, 0, 0), (1, 0, 0), (2, 0, 0)], False),
    ],
)
def test_cases_worked_out_by_hand(first, second, expected):
    assert meet(first, second) is expected
    assert simplices_meet(first, second) is expected
    for scale in (-2.0, 2.0**60):  # exact
        assert meet(scale * np.array(first), scale * np.array(second)) is expected


@pytest.mark.parametrize(("k", "m"), SIDES)
def test_degenerate_pairs_are_decided_as_by_fractions(rng, k, m):
    """Small integers give every degenerate case; tenths are integers that were rounded."""
    points = rng.integers(-1, 2, (400, k + m, 3)).astype(float)
    points[100:200] *= 0.1
    points[200:300, :, 2] = 0.3  # in a plane
    points[300:] = points[300:, :, :1] * (1.0, 2.0, -3.0) + (0.5, 0.0, 7.0)  # on a line
    points *= 2.0 ** rng.integers(-1000, 1000, (len(points), 1, 1))
    expected = [simplices_meet(row[:k], row[k:]) for row in points]
    assert sides_meet(points[:, :k], points[:, k:]).tolist() == expected
    assert 50 < sum(expected) < 350


@pytest.mark.parametrize(("k", "m"), SIDES)
def test_general_pairs_of_any_size_are_decided_as_by_fractions(rng, k, m):
    points = rng.normal(size=(100, k + m, 3)) * 2.0 ** rng.integers(-60, 60, (100, k + m, 1))
    points[:50] = rng.normal(size=(50, k + m, 3))
    points[50:, :, 1] = 0.1
    expected = [simplices_meet(row[:k], row[k:]) for row in points]
    assert sides_meet(points[:, :k], points[:, k:]).tolist() == expected


def test_a_point_made_from_exact_weights_lies_in_the_face(rng):
    for _ in range(20):
        face = rng.integers(-8, 8, (3, 3)).astype(float)
        w = rng.integers(0, 5, 2) / 16.0
        point = (1.0 - w.sum()) * face[0] + w[0] * face[1] + w[1] * face[2]
        assert meet([point], face)
        n = np.cross(face[1] - face[0], face[2] - face[0])
        if n.any():
            assert not meet([point + 2.0**-30 * n], face)


def test_each_pair_of_many_gets_its_own_answer():
    """There are more pairs than are decided at once."""
    n = 2 * CHUNK + 3
    heights = np.where(np.arange(n) % 3 == 0, 0.0, 2.0**-60)
    vertices = np.column_stack((np.full((n, 2), 0.25), heights))[:, None]
    faces = np.broadcast_to(np.array(FACE, float), (n, 3, 3))
    assert (sides_meet(vertices, faces) == (heights == 0.0)).all()
    assert sides_meet(vertices[:0], faces[:0]).shape == (0,)


@pytest.mark.parametrize("n", range(8))
def test_every_chunk_is_decided(rng, monkeypatch, n):
    """Three are decided at once: there are none, a part of a chunk, whole chunks, and one more."""
    monkeypatch.setattr(exact, "CHUNK", 3)
    points = rng.integers(-3, 4, (n, 4, 3)).astype(float)
    points[::3, 3] = points[::3, 0]  # without volume
    expected = np.sign(np.round(np.linalg.det(points[:, 1:] - points[:, :1])))
    np.testing.assert_array_equal(volume_signs(points), expected)
    meets = [simplices_meet(row[:1], row[1:]) for row in points]
    assert sides_meet(points[:, :1], points[:, 1:]).tolist() == meets
