"""Edges that cross faces: an answer in floats is never wrong, and there nearly always is one."""

import numpy as np
import pytest

from izo_ref.base.exact import sides_meet
from izo_ref.detection.formulas.advance import APART, CONTACT, UNDECIDED
from izo_ref.detection.formulas.crossing import certain_sign, edge_face_status


def statuses(points):
    """Return the answer for each row of edge p q and face a b c."""
    return np.array([edge_face_status(*(tuple(p) for p in row)) for row in points])


@pytest.mark.parametrize("size", [1.0, 1e-60, 1e60])
def test_general_edges_and_faces_are_decided_and_never_wrongly(rng, size):
    points = size * rng.normal(size=(400, 5, 3))
    points[200:, :2] *= 0.3  # more of these cross
    found, meet = statuses(points), sides_meet(points[:, :2], points[:, 2:])
    np.testing.assert_array_equal(found == CONTACT, meet)
    np.testing.assert_array_equal(found == APART, ~meet)
    assert 10 < meet.sum() < 200


def test_touching_edges_and_faces_are_never_decided_wrongly(rng):
    """Small integers, and tenths of them, give every degenerate case."""
    points = rng.integers(-2, 3, (600, 5, 3)).astype(float)
    points[300:] *= 0.1
    found, meet = statuses(points), sides_meet(points[:, :2], points[:, 2:])
    assert not (meet & (found == APART)).any()
    assert not (~meet & (found == CONTACT)).any()
    for status in (APART, CONTACT, UNDECIDED):
        assert (found == status).sum() > 20


def test_an_edge_through_a_corner_is_not_decided_by_floats():
    """It passes all sides of the face on the same side, or through them: only just."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    for k in range(3):
        for third in range(3):
            face = np.roll(corners, third, axis=0)
            edge = face[k] + np.array([[0.1, 0.2, 1.0], [-0.1, -0.2, -1.0]])
            assert statuses(np.vstack((edge, face))[None])[0] == UNDECIDED


def test_flat_pairs_are_proved_apart_by_a_direction(rng):
    """Nodes in one plane have no volume, so no sign is certain."""
    apart = 0
    for _ in range(100):
        points = np.column_stack((rng.normal(size=(5, 2)), np.zeros(5)))
        points[:2, 0] += 2.0
        meet = sides_meet(points[None, :2], points[None, 2:])[0]
        status = statuses(points[None])[0]
        assert status == (UNDECIDED if meet else APART)
        apart += not meet
    assert 30 < apart < 100


def test_a_sign_is_that_of_the_determinant_or_none(rng):
    for _ in range(100):
        a, b = rng.integers(-3, 4, (2, 3)).astype(float)
        c = rng.integers(-3, 4, 3).astype(float)
        volume = round(np.linalg.det(np.stack((a, b, c))))
        assert certain_sign(tuple(a), tuple(b), tuple(c)) == np.sign(volume)
        assert certain_sign(tuple(a), tuple(b), tuple(a + 0.5 * b)) == 0
