"""Impacts come in the order of the caller's faces and edges, with their weights and normals."""

import itertools

import numpy as np

from izo_ref.loop.serial.numbering import order_sides

PLACES = np.array([4, 0, 6, 2, 5, 1, 3])  # the caller's vertex at each place


def ordered(is_edge_edge, nodes, weights, normals, faces):
    """Return nodes, weights and normals of impacts, as `order_sides` changes them."""
    place = np.argsort(PLACES)
    nodes, weights, normals = place[nodes].astype(np.int32), weights.copy(), normals.copy()
    order_sides(PLACES, faces, np.array(is_edge_edge), nodes, weights, normals)
    return nodes, weights, normals


def test_corners_come_in_the_order_of_the_face(rng):
    """All faces here have the same lowest vertex, or the same corners as another one."""
    faces = np.array([[3, 1, 5], [1, 6, 3], [5, 1, 4], [6, 5, 4], [1, 3, 6]], np.int32)
    impacts, expected = [], []
    for k in (0, 1, 2, 3):
        for corners in itertools.permutations(faces[k]):
            impacts.append((2 if k != 3 else 0, *corners))
            expected.append((impacts[-1][0], *faces[k]))
    weights = np.column_stack((np.ones(len(impacts)), -rng.dirichlet([1, 1, 1], len(impacts))))
    normals = rng.normal(size=(len(impacts), 3))
    found = ordered([False] * len(impacts), np.array(impacts), weights, normals, faces)
    np.testing.assert_array_equal(found[0], expected)
    np.testing.assert_array_equal(found[2], normals)
    for i, (before, after) in enumerate(zip(impacts, expected, strict=True)):
        of_vertex = dict(zip(before, weights[i], strict=True))
        assert found[1][i].tolist() == [of_vertex[vertex] for vertex in after]


def test_the_lower_edge_comes_first_and_the_lower_vertex_in_each(rng):
    impacts = [
        (*first, *second)
        for a, b in (((0, 5), (2, 3)), ((1, 6), (1, 4)), ((3, 4), (0, 6)))
        for one, other in ((a, b), (b, a))
        for first in itertools.permutations(one)
        for second in itertools.permutations(other)
    ]
    weights, normals = rng.normal(size=(len(impacts), 4)), rng.normal(size=(len(impacts), 3))
    nothing = np.empty((0, 3), np.int32)
    found = ordered([True] * len(impacts), np.array(impacts), weights, normals, nothing)
    for i, before in enumerate(impacts):
        first, second = sorted((sorted(before[:2]), sorted(before[2:])))
        assert found[0][i].tolist() == [*first, *second]
        swapped = sorted(before[:2]) != first
        sign = -1.0 if swapped else 1.0
        sides = (before[:2], weights[i, :2]), (before[2:], weights[i, 2:])
        own = [dict(zip(*side, strict=True)) for side in (sides[::-1] if swapped else sides)]
        expected = [sign * own[0][v] for v in first] + [sign * own[1][v] for v in second]
        assert found[1][i].tolist() == expected
        np.testing.assert_array_equal(found[2][i], sign * normals[i])
