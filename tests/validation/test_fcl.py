"""Crossings of a mesh at rest, as python-fcl reports them."""

import numpy as np
import pytest

from izo_ref.detection.intersections import find_intersections
from izo_ref.detection.mesh import edges_of
from tests.helpers.own_scenes import scene
from tests.helpers.shapes import grid
from tests.helpers.steps import load
from tests.naive.simplices import simplices_meet
from validation.oracles.fcl import crossing_faces

FACE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
APART = [[0, 1, 2], [3, 4, 5]]
OVER_VERTEX = [[0, 1, 2], [0, 3, 4]]
OVER_EDGE = [[0, 1, 2], [1, 0, 3]]


def crosses(others, faces):
    """Return whether two faces cross, and check that no order of faces and corners matters."""
    positions = np.array(FACE + others, float)
    answers = []
    for first, second in ((0, 1), (1, 0)):
        for turn in range(3):
            two = [np.roll(faces[first], turn), faces[second]]
            answers.append(crossing_faces(positions, two).tolist())
    assert answers in ([[[0, 1]]] * 6, [[]] * 6)
    return answers[0] == [[0, 1]]


def slats(n):
    """Return n upright slats that cross n level ones: n * n crossings of n + n faces."""
    k = np.arange(n)[:, None, None]
    upright = np.array([[0, -9, -1], [0, 9 + 9 * n, -1], [0, 0, 9]]) + k * np.array([2, 0, 0])
    level = np.array([[-9, 0, 0.5], [9 + 9 * n, 0, 0.5], [0, 0, 0]]) + k * np.array([0, 2, 0.01])
    return np.concatenate((upright, level)).reshape(-1, 3), np.arange(6 * n).reshape(-1, 3)


@pytest.mark.parametrize("first_cap", [None, 1, 7])
def test_no_contact_is_cut_off(first_cap):
    positions, faces = slats(6)
    pairs = crossing_faces(positions, faces, first_cap)
    assert pairs.tolist() == [[i, 6 + j] for i in range(6) for j in range(6)]


@pytest.mark.parametrize("tilted", [False, True])
def test_neighbouring_faces_of_a_sheet_do_not_cross(rng, tilted):
    """A flat sheet is the hardest case, because all its neighbouring faces are coplanar."""
    positions, faces = grid(20)
    if tilted:
        positions = positions @ np.linalg.qr(rng.normal(size=(3, 3)))[0] + rng.normal(size=3)
    assert crossing_faces(positions, faces).shape == (0, 2)


def test_each_pair_comes_once():
    """Coplanar faces have several contacts, and fcl lists them in both orders."""
    shifted = [[0.2, 0.2, 0], [1.2, 0.2, 0], [0.2, 1.2, 0]]
    positions = np.array(FACE + shifted + [[5, 5, 5]] * 3, float) + [0, 0, 1]
    positions[6:] += FACE
    assert crossing_faces(positions, np.arange(9).reshape(3, 3)).tolist() == [[0, 1]]


@pytest.mark.parametrize(
    ("edge", "expected"),
    {
        "through": ([[0.25, 0.25, -1], [0.25, 0.25, 1]], True),
        "beside": ([[-1, 0.5, -1], [-1, 0.5, 1]], False),
        "beyond, so the other edge is": ([[0.75, 0.75, -1], [0.75, 0.75, 1]], True),
        "above": ([[0.25, 0.25, 0.1], [0.25, 0.25, 1]], False),
        "with an end on it": ([[0.25, 0.25, 0], [0.25, 0.25, 1]], True),
        "with an end hardly above": ([[0.25, 0.25, 1e-50], [0.25, 0.25, 1]], False),
        "through the opposite edge": ([[0.5, 0.5, -1], [0.5, 0.5, 1]], True),
        "through a side": ([[0.5, 0, -1], [0.5, 0, 1]], True),
        "past a side by hardly anything": ([[0.5, -1e-50, -1], [0.5, -1e-50, 1]], False),
        "through a corner": ([[1, 0, -1], [1, 0, 1]], True),
        "over all of it": ([[2, -1, 0], [-1, 2, 0]], True),
        "in its plane, beside": ([[-1, 0.1, 0], [0.1, -1, 0]], False),
        "in its plane, along an edge": ([[0.5, 0, 0], [0.5, -1, 0]], True),
        "face in line, along an edge": ([[0.5, 0, 0], [0.25, 0, 0]], True),
        "face in line, beside": ([[-1, 0, 0], [-2, 0, 0]], False),
        "face in line, upright": ([[0, 0, 1], [0, 0, 2]], False),
    }.values(),
)
def test_faces_with_a_common_vertex_cross_as_worked_out_by_hand(edge, expected):
    assert crosses(edge, OVER_VERTEX) == expected


@pytest.mark.parametrize(
    ("tip", "expected"),
    {
        "flat": ([0.5, -1, 0], False),
        "folded": ([0.5, 1, 0], True),
        "folded, hardly open": ([0.5, 1, 1e-50], False),
        "upright": ([0.5, 0, 1], False),
        "without area": ([0.5, 0, 0], False),
    }.values(),
)
def test_faces_with_a_common_edge_cross_as_worked_out_by_hand(tip, expected):
    assert crosses([tip], OVER_EDGE) == expected


@pytest.mark.parametrize("tip", [[0.25, 0.25, 0], [0.25, 0.25, -1]])
def test_faces_without_a_common_vertex_cross(tip):
    assert crosses([tip, [0.2, 0.2, 1], [0.3, 0.3, 1]], APART)


def test_duplicate_faces_are_left_out():
    assert len(crossing_faces(np.array(FACE, float), [[0, 1, 2], [2, 1, 0]])) == 0


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_positions_that_are_not_finite_are_refused(value):
    positions, faces = slats(2)
    positions[[4, 7], 1] = value
    with pytest.raises(ValueError, match=r"finite, vertex 4 is"):
        crossing_faces(positions, faces)


def test_face_with_a_vertex_twice_is_refused():
    with pytest.raises(ValueError, match="face 1"):
        crossing_faces(np.array(FACE, float), [[0, 1, 2], [1, 2, 1]])


@pytest.mark.parametrize("faces", [np.empty((0, 3), int), [[0, 1, 2]]])
def test_fewer_than_two_faces_have_no_crossing(faces):
    assert crossing_faces(np.array(FACE, float), faces).shape == (0, 2)


def expected_pairs(positions, faces):
    """Return the pairs of faces, of which an edge of one meets the other, as izo_ref finds them."""
    found = find_intersections(positions, edges_of(faces), faces)
    corners = [set(face) for face in faces.tolist()]
    owners = []
    meeting = list(zip(found.crossing_edges, found.crossed_faces, strict=True))
    for nodes, is_edge_edge in zip(*found.touching, strict=True):
        split = 2 if is_edge_edge else 1
        meeting.append((nodes[:split], nodes[split:]))
    for pair in meeting:
        sides = [set(side.tolist()) for side in pair]
        owners += [tuple([i for i, c in enumerate(corners) if side <= c] for side in sides)]
    pairs = {(min(i, j), max(i, j)) for a, b in owners for i in a for j in b if i != j}
    return sorted(map(list, pairs))


@pytest.mark.parametrize("n_vertices", [8, 20, 60])
def test_agrees_with_izo_ref_on_random_faces(rng, n_vertices):
    """The faces are in general position; pairs share no vertex or one."""
    faces = np.array([rng.choice(n_vertices, 3, replace=False) for _ in range(25)], np.int32)
    positions = rng.normal(size=(n_vertices, 3))
    pairs = crossing_faces(positions, faces).tolist()
    assert pairs == expected_pairs(positions, faces)
    assert pairs


def test_agrees_with_izo_ref_on_a_grid_of_few_places(rng):
    """With small integers, most faces touch, lie in one plane or have no area."""
    for _ in range(30):
        positions = rng.integers(0, 3, size=(5, 3)).astype(float)
        two = positions[OVER_VERTEX]
        expected = simplices_meet(two[0, 1:], two[1]) or simplices_meet(two[1, 1:], two[0])
        assert (len(crossing_faces(positions, OVER_VERTEX)) == 1) == expected, positions


def shared_corners(pairs, faces):
    """Count the pairs of faces that share no vertex, one vertex, two vertices."""
    shared = (faces[pairs[:, 0], :, None] == faces[pairs[:, 1], None, :]).sum(axis=(1, 2))
    return np.bincount(shared).tolist()


def test_crossings_at_a_common_vertex_are_not_hidden():
    crumple = scene("crumple")
    pairs = crossing_faces(crumple.positions_t1, crumple.faces)
    assert pairs.tolist() == expected_pairs(crumple.positions_t1, crumple.faces)
    assert shared_corners(pairs, crumple.faces) == [189, 4]


@pytest.mark.data
def test_crossings_at_a_common_vertex_are_not_hidden_in_a_larger_step():
    step = load("cloth-ball")
    pairs = crossing_faces(step["positions_t1"], step["faces"])
    assert shared_corners(pairs, step["faces"]) == [97_320, 2_552]


def test_touches_are_mostly_found(rng):
    """A vertex lies exactly on a face, in integers and eighths, but fcl decides in floats."""
    missed, n = 0, 100
    for _ in range(n):
        a, b, c = 8.0 * rng.integers(-99, 100, (3, 3))
        i, j = rng.integers(1, 4, 2)
        tip = ((8 - i - j) * a + i * b + j * c) / 8.0
        up = np.cross(b - a, c - a)
        other = [tip, tip + up + (1, 2, 3), tip + up + (3, 1, -2)]
        positions = np.array([a, b, c, *other])
        missed += len(crossing_faces(positions, APART)) == 0
    print(f"\n{missed} of {n} touches missed")
    assert missed <= 0.05 * n
