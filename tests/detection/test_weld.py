"""Which vertices are one vertex, and which faces are left; sizes, chains and refusals."""

import time

import numpy as np
import pytest

import izo_ref
from izo_ref import errors
from izo_ref.detection import weld
from tests.helpers.shapes import grid


def free(n):
    """Return flags of n vertices of which none is pinned."""
    return np.zeros(n, bool)


def joined_by_hand(start, end, tolerance):
    """Return the lowest vertex of the group of each vertex, by looking at all pairs."""
    lowest = np.arange(len(start))
    for a in range(len(start)):
        for b in range(a):
            near = all(np.linalg.norm(x[a] - x[b]) <= tolerance for x in (start, end))
            if near:
                one, other = sorted((lowest[a], lowest[b]))
                lowest[lowest == other] = one
    return lowest


@pytest.mark.parametrize("tolerance", [0.0, 1e-3])
def test_copies_are_found_as_by_all_pairs(rng, tolerance):
    sites = rng.integers(0, 4, (60, 3)).astype(float)
    start, end = sites, np.where(rng.random((60, 1)) < 0.8, sites, sites + 0.5)
    if tolerance:
        start = start + 0.4 * tolerance * rng.uniform(-1, 1, start.shape) / np.sqrt(3)
    copies = weld.find_copies(start, end, free(60), tolerance)
    np.testing.assert_array_equal(copies, joined_by_hand(start, end, tolerance))
    assert 0 < np.count_nonzero(copies != np.arange(60)) < 60


def test_negative_zero_is_zero_and_the_next_float_is_not():
    start = np.zeros((3, 3))
    start[1], start[2, 0] = -0.0, 5e-324
    assert weld.find_copies(start, start, free(3), 0.0).tolist() == [0, 0, 2]


@pytest.mark.parametrize("n", [0, 1, 3])
@pytest.mark.parametrize("tolerance", [0.0, 0.1])
def test_without_copies_there_is_nothing_to_weld(n, tolerance):
    start = np.arange(3.0 * n).reshape(n, 3)
    assert weld.find_copies(start, start, free(n), tolerance) is None


def test_a_group_takes_the_path_of_its_first_pinned_vertex(rng):
    """The others start and end there, although they were proposed 0.9 um away."""
    positions, faces = grid(3)
    start = np.concatenate((positions, positions[:3] + (0.0, 0.0, 9e-7)))
    faces[faces < 3] += np.where(np.arange(len(faces))[:, None] % 2, 9, 0).repeat(3, 1)[faces < 3]
    pinned = np.arange(12) >= 10
    scene = izo_ref.Scene(start, start + 0.5, faces, None, pinned, weld=1e-6)
    assert scene.copies.tolist() == [*range(9), 0, 1, 2]
    assert scene.pinned.tolist() == [v in (1, 2, 10, 11) for v in range(12)]
    assert scene.masses.tolist() == [2.0] * 3 + [1.0] * 6 + [0.0] * 3
    for positions, given in ((scene.positions_t0, start), (scene.positions_t1, start + 0.5)):
        np.testing.assert_array_equal(positions[:3], given[[0, 10, 11]])
        np.testing.assert_array_equal(positions[9:], given[[0, 10, 11]])
    result = izo_ref.resolve(scene, 1e-3)
    np.testing.assert_array_equal(result.positions, scene.positions_t1)
    moved = result.positions.copy()
    moved[9] += 9e-7
    with pytest.raises(errors.WeldError, match="vertex 9"):
        scene.after(result, moved)
    moved[9] -= 5e-7
    assert (scene.after(result, moved).positions_t1[9] == moved[0]).all()


def test_a_chain_may_not_lead_far():
    line = np.zeros((4, 3))
    line[:, 0] = 0.0, 0.9, 1.8, 9.0
    with pytest.raises(errors.WeldError, match=r"chain.*vertex 2, at the start 1\.8 m from ver"):
        weld.find_copies(line, line, free(4), 1.0)
    assert weld.find_copies(line, line, free(4), 1.8).tolist() == [0, 0, 0, 3]
    # pinned vertex 1 is within the tolerance of both others
    assert weld.find_copies(line, line, np.arange(4) == 1, 1.0).tolist() == [0, 0, 0, 3]


def test_a_tolerance_that_joins_everything_is_refused_quickly(rng):
    points = rng.random((20000, 3))
    begin = time.process_time()
    with pytest.raises(errors.WeldError, match=r"got 2 m, within which each vertex has 19999"):
        weld.find_copies(points, points, free(20000), 2.0)
    assert time.process_time() - begin < 1.0


@pytest.mark.parametrize("tolerance", [0.0, 1e-9])
def test_thousands_of_vertices_take_little_time(rng, tolerance):
    """5000 vertices take 2 and 5 CPU ms, once scipy is loaded."""
    points = np.tile(rng.random((2500, 3)), (2, 1))
    weld.find_copies(points[:10], points[:10], free(10), tolerance)
    begin = time.process_time()
    copies = weld.find_copies(points, points, free(5000), tolerance)
    assert time.process_time() - begin < 0.1
    np.testing.assert_array_equal(copies, np.tile(np.arange(2500), 2))


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, True, "a", [0.0]])
def test_what_is_no_tolerance_is_refused(value):
    with pytest.raises(errors.OptionError, match=r"weld: expected None or a finite number >= 0"):
        izo_ref.Scene(np.eye(3), np.eye(3), [[0, 1, 2]], weld=value)


def test_flat_faces_are_left_out_if_another_face_has_their_edge():
    faces = np.array([[0, 1, 2], [0, 3, 1], [3, 1, 2], [4, 2, 1], [0, 3, 6]], np.int32)
    copies = np.array([0, 1, 2, 0, 4, 5, 0])
    # face 1 becomes the edge (0, 1) of face 0, face 2 becomes face 0, and face 4 becomes a point
    assert weld.welded_faces(faces, copies).tolist() == [[0, 1, 2], [4, 2, 1]]
    alone = np.array([[0, 3, 5]], np.int32)
    with pytest.raises(errors.DegenerateFaceError) as caught:
        weld.welded_faces(np.concatenate((faces, alone)), copies)
    assert "face 5: [0, 3, 5], of which the edge (0, 5) is left" in str(caught.value)


def test_masses_whose_sum_overflows_are_refused():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 1], [0, 1, 1]])
    faces = [[0, 1, 2], [3, 4, 5]]
    assert izo_ref.Scene(corners, corners, faces, 1e307, weld=0).masses[0] == 2e307
    with pytest.raises(errors.NonFiniteError, match="the first is that of vertex 0"):
        izo_ref.Scene(corners, corners, faces, 1.7e308, weld=0)


def test_without_coincident_vertices_weld_changes_nothing():
    positions, faces = grid(4)
    scene = izo_ref.Scene(positions, positions, faces, weld=0)
    assert scene.copies is None
    assert scene.unwelded == {}
    assert scene.masses.tolist() == [1.0] * 16


@pytest.mark.parametrize("exponent", [-1000, -600, 0, 600, 1000])
def test_vertices_of_any_size_are_joined_as_others_are(rng, exponent):
    start = rng.integers(0, 4, (60, 3)) + rng.integers(-1, 2, (60, 3)) * 2.0**-12
    end = np.where(rng.random((60, 1)) < 0.5, start, 0.0)  # many vertices that start apart end here
    tolerance, unit = 2.0**-10, 2.0**exponent
    copies = weld.find_copies(unit * start, unit * end, free(60), unit * tolerance)
    np.testing.assert_array_equal(copies, joined_by_hand(start, end, tolerance))


def test_a_vertex_far_out_does_not_keep_others_from_being_joined():
    far = 1.7e308
    points = np.array([[0, 0, 0], [far, far, 0], [1e-7, 0, 0], [-far, 0, 0]])
    assert weld.find_copies(points, points, free(4), 1e-6).tolist() == [0, 1, 0, 3]
