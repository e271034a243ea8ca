"""The edges of a mesh, their median length, and rows in order."""

import numpy as np
import pytest

from izo_ref.detection.mesh import edges_of, median_length
from izo_ref.detection.serial.boxes import bounds, bounds_of_edges
from izo_ref.detection.serial.mesh import sort_rows


@pytest.mark.parametrize(
    ("n", "n_values", "width"), [(0, 5, 2), (1, 1, 3), (50, 4, 3), (300, 90, 2)]
)
def test_rows_are_sorted_and_equal_ones_keep_their_order(rng, n, n_values, width):
    rows = rng.integers(0, n_values, (n, width)).astype(np.int32)
    expected = sorted(range(n), key=lambda i: (*rows[i].tolist(), i))
    assert sort_rows(rows, n_values).tolist() == expected


@pytest.mark.parametrize("n", [0, 1, 40])
def test_edges_come_once_and_sorted(rng, n):
    corners = [rng.choice(12, 3, replace=False) for _ in range(n)]
    faces = np.array(corners, np.int32).reshape(-1, 3)
    sides = {tuple(sorted((int(f[k]), int(f[k - 1])))) for f in faces for k in range(3)}
    assert [tuple(edge) for edge in edges_of(faces).tolist()] == sorted(sides)


@pytest.mark.parametrize("n", [0, 1, 2, 7, 10])
def test_the_median_is_that_of_the_lengths(rng, n):
    positions, edges = rng.normal(size=(9, 3)), rng.integers(0, 9, (n, 2)).astype(np.int32)
    lengths = [np.linalg.norm(positions[a] - positions[b]) for a, b in edges]
    expected = np.median(lengths) if n else 0.0
    assert median_length(positions, edges) == pytest.approx(expected, rel=1e-15)


def test_bounds_are_the_lowest_and_highest_coordinates(rng):
    for n in (1, 2, 20):
        points = rng.normal(size=(n, 3))
        edges = np.array([rng.integers(0, n, 2) for _ in range(n)], np.int32)
        low, high = bounds(points)
        assert (low, high) == (tuple(points.min(axis=0)), tuple(points.max(axis=0)))
        used = points[np.unique(edges)]
        low, high = bounds_of_edges(points, edges)
        assert (low, high) == (tuple(used.min(axis=0)), tuple(used.max(axis=0)))
