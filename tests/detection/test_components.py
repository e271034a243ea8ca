"""Connected components of a mesh, and which of them moving components can reach."""

import numpy as np

from izo_ref.detection.components import MeshComponents
from tests.helpers.shapes import two_sheets


def test_components_have_their_vertices_boxes_and_reach(rng):
    scene = two_sheets(rng, 4)
    parts = MeshComponents(len(scene.positions_t0) + 2, scene.faces)
    assert parts.count == 4  # two sheets, and two vertices that belong to no face
    assert parts.component.tolist() == [0] * 16 + [1] * 16 + [2, 3]
    positions = np.vstack((scene.positions_t0, [[5, 5, 5], [9, 9, 9.0]]))
    low, high = parts.boxes(positions)
    np.testing.assert_array_equal(low[1], positions[16:32].min(axis=0))
    np.testing.assert_array_equal(high[0], positions[:16].max(axis=0))
    moved = positions.copy()
    moved[32] = (8, 8, 8)
    assert parts.out_of_reach(positions, moved).tolist() == [True, True, False, True]
    moved[32] = (9, 9, 9)  # the vertex touches the other one
    assert parts.out_of_reach(positions, moved).tolist() == [True, True, False, False]


def test_components_of_another_numbering_are_the_same(rng):
    scene = two_sheets(rng, 4)
    n = len(scene.positions_t0) + 2
    parts, order = MeshComponents(n, scene.faces), rng.permutation(n)
    other = parts.renumbered(order)
    assert other.count == parts.count
    np.testing.assert_array_equal(other.component, parts.component[order])
    positions = rng.normal(size=(n, 3))
    for found, expected in zip(other.boxes(positions[order]), parts.boxes(positions), strict=True):
        np.testing.assert_array_equal(found, expected)
