"""How far something has gone through: distances and patches against slow programs."""

import numpy as np
import pytest

from izo_ref.detection.mesh import edges_of
from izo_ref.sequence.reach import _farthest, find_patches, point_face_distances
from tests.helpers.shapes import grid
from tests.naive.crossings import distance_to_face


def test_distances_of_points_and_faces_are_those_of_a_search(rng):
    points, corners = rng.normal(size=(30, 3)), rng.normal(size=(30, 3, 3))
    corners[::5, 2] = corners[::5, 0] + 0.3 * (corners[::5, 1] - corners[::5, 0])  # without area
    corners[1] = corners[1, 0]
    found = point_face_distances(points, corners)
    wanted = [distance_to_face(p, c) for p, c in zip(points, corners, strict=True)]
    assert found == pytest.approx(wanted, rel=1e-7)


@pytest.mark.parametrize("spread", [1.0, 100.0])
def test_the_farthest_vertex_is_found_among_faces_of_all_sizes(rng, spread):
    sizes = spread ** rng.uniform(-1.0, 1.0, size=(80, 1, 1))
    corners = rng.normal(size=(80, 1, 3)) + 0.1 * sizes * rng.normal(size=(80, 3, 3))
    positions = rng.normal(size=(60, 3))
    groups = [np.arange(0, 5), np.arange(5, 6), np.arange(6, 60)]
    nearest = [point_face_distances(np.tile(p, (80, 1)), corners).min() for p in positions]
    wanted = [max(nearest[i] for i in group) for group in groups]
    assert _farthest(positions, groups, corners) == pytest.approx(wanted)


def test_the_largest_patch_of_each_component_stays():
    _, faces = grid(4)
    faces = np.concatenate((faces, faces + 16)).astype(np.int32)
    edges = edges_of(faces)
    component = np.repeat([0, 1], 16)
    # Vertex 0 and the vertices 31 and 27 are cut off; vertex 5 has no edge left either.
    alone = [0, 5]
    cut = np.isin(edges, alone).any(axis=1)
    pair = np.isin(edges, [27, 31]).sum(axis=1)
    patches = find_patches(edges, cut | (pair == 1), component)
    assert np.flatnonzero(patches.cut_off).tolist() == [0, 5, 27, 31]
    assert patches.patch[27] == patches.patch[31] != patches.patch[0]
    assert patches.sizes[patches.patch[[0, 27]]].tolist() == [1, 2]


def test_of_two_equal_patches_the_one_of_the_lower_vertices_stays():
    edges = np.array([(0, 1), (1, 2), (2, 3)], np.int32)
    patches = find_patches(edges, np.array([False, True, False]), np.zeros(4, np.int64))
    assert patches.cut_off.tolist() == [False, False, True, True]
