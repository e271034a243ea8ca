"""Intersections of simplices in exact arithmetic."""

import numpy as np
import pytest

from izo_ref.base.exact import simplices_meet

FACE = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ([(0.2, 0.2, 0)], FACE, True),
        ([(0.2, 0.2, 5e-324)], FACE, False),
        ([(0.5, 0.5, 0)], FACE, True),  # on an edge
        ([(0.5, 0.5 + 2**-53, 0)], FACE, False),
        ([(1, 0, 0)], FACE, True),  # on a corner
        ([(0.2, 0.2, 1), (0.2, 0.2, -1)], FACE, True),
        ([(0.2, 0.2, 1), (0.2, 0.2, 1e-300)], FACE, False),
        ([(-1, 0.5, 0), (1, 0.5, 0)], FACE, True),  # in the plane, across
        ([(-1, -0.5, 0), (1, -0.5, 0)], FACE, False),  # in the plane, beside
        ([(0, 0, 0), (1, 0, 0)], [(0.5, 0, 0), (2, 0, 0)], True),  # collinear, overlap
        ([(0, 0, 0), (1, 0, 0)], [(1.5, 0, 0), (2, 0, 0)], False),  # collinear, apart
        ([(0, 0, 0), (0, 0, 0)], [(0, -1, 0), (0, 1, 0)], True),  # an edge without length
        ([(0, 0, 0)], [(-1, 0, 0), (1, 0, 0), (2, 0, 0)], True),  # a face without area
    ],
)
def test_cases_worked_out_by_hand(first, second, expected):
    assert simplices_meet(first, second) is expected
    assert simplices_meet(second, first) is expected


def test_a_point_made_from_exact_weights_lies_in_the_face(rng):
    for _ in range(20):
        face = rng.integers(-8, 8, (3, 3)).astype(float)
        w = rng.integers(0, 5, 2) / 16.0
        point = (1.0 - w.sum()) * face[0] + w[0] * face[1] + w[1] * face[2]
        assert simplices_meet([point], face)
        n = np.cross(face[1] - face[0], face[2] - face[0])
        if n.any():
            assert not simplices_meet([point + 2.0**-30 * n], face)
