"""Connected components of a mesh, and which of them moving components can reach."""

import numpy as np

from izo_ref.detection.components import MeshComponents
from izo_ref.detection.serial.components import paths_of_components
from tests.helpers.shapes import two_sheets


def test_components_have_their_vertices_boxes_and_reach(rng):
    scene = two_sheets(rng, 4)
    parts = MeshComponents(len(scene.positions_t0) + 2, scene.faces)
    assert parts.count == 4  # two sheets, and two vertices that belong to no face
    assert parts.component.tolist() == [0] * 16 + [1] * 16 + [2, 3]
    positions = np.vstack((scene.positions_t0, [[5, 5, 5], [9, 9, 9.0]]))
    ends = positions + rng.normal(size=positions.shape)
    ends[:16] = positions[:16]
    moving, low, high = paths_of_components(parts.component, parts.count, positions, ends)
    assert moving.tolist() == [False, True, True, True]
    both = np.concatenate((positions[16:32], ends[16:32]))
    np.testing.assert_array_equal(low[1], both.min(axis=0))
    np.testing.assert_array_equal(high[1], both.max(axis=0))
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
