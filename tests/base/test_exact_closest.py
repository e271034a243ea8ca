"""Exact normals at rest, against every pair of features in long double and cases by hand."""

import numpy as np
import pytest

from izo_ref.base.exact_closest import exact_normal
from tests.naive.closest import closest_vector

FACE = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]


@pytest.mark.parametrize(
    ("is_edge_edge", "points", "expected"),
    [
        (False, [[1, 1, 5e-324], *FACE], [0, 0, 1]),
        (False, [[1, 1, -1e-300], *FACE], [0, 0, -1]),
        (False, [[1, -1e-200, 0], *FACE], [0, -1, 0]),
        (False, [[-3e-100, -4e-100, 0], *FACE], [-0.6, -0.8, 0]),
        (False, [[1, 1, 0], *FACE], None),
        (False, [[5, 0, 0], [0, 0, 0], [1, 0, 0], [3, 0, 0]], [1, 0, 0]),  # a face without area
        (True, [[-1, 0, 1e-17], [1, 0, 1e-17], [0, -1, 0], [0, 1, 0]], [0, 0, 1]),
        (True, [[-1, 0, 0], [1, 0, 0], [-1, 5e-324, 0], [1, 5e-324, 0]], [0, -1, 0]),
        (True, [[0, 0, 0], [1, 0, 0], [1 + 2**-52, 0, 0], [2, 0, 0]], [-1, 0, 0]),
        (True, [[0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 1, 0]], None),
        (True, [[1, 1, 1e200], [1, 1, 1e200], [0, 0, 0], [2, 2, 0]], [0, 0, 1]),
    ],
)
def test_exact_normals_are_those_worked_out_by_hand(is_edge_edge, points, expected):
    normal = exact_normal(is_edge_edge, np.array(points, float))
    if expected is None:
        assert normal is None
    else:
        np.testing.assert_allclose(normal, expected, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("is_edge_edge", [False, True])
def test_exact_normals_agree_with_long_doubles(rng, is_edge_edge):
    for _ in range(300):
        points = rng.normal(size=(4, 3)) * rng.choice([0.0, 0.1, 1.0], (4, 1))
        vector = closest_vector(is_edge_edge, points)
        normal = exact_normal(is_edge_edge, points)
        length = float(np.sqrt(vector @ vector))
        if length < 1e-12:
            continue
        np.testing.assert_allclose(normal, np.array(vector / length, float), atol=1e-9)
