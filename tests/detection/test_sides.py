"""Which side the mesh tells of pairs that touch, against cases by hand and a linear program."""

import numpy as np
import pytest
from scipy.optimize import linprog

import izo_ref
from izo_ref.base.records import Exclusion, PairState
from izo_ref.detection.sides import Side, Sides
from tests.helpers.touching import PARTS, TURNS

FLOOR = "face above"


def placed(*parts):
    """Return the positions and faces of parts; each is a name, a turn and a shift."""
    positions, faces, n = [], [], 0
    for name, turn, shift in parts:
        points, own = PARTS[name]
        positions.append(np.array(points, float) @ np.asarray(turn).T + shift)
        faces.append(np.array(own) + n)
        n += len(points)
    return np.concatenate(positions), np.concatenate(faces).astype(np.int32)


UP, DOWN = np.eye(3), np.diag([1.0, 1.0, -1.0])
SIDEWAYS = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, 1]])
CASES = {
    "vertex on a face": ([(FLOOR, UP, 0), ("tip", UP, 0)], "told"),
    "vertex under a face": ([(FLOOR, UP, 0), ("tip", DOWN, 0)], "told"),
    "vertex on an edge": ([(FLOOR, UP, (0, 2, 0)), ("tip", UP, 0)], "told"),
    "vertex on a vertex": ([("tip", DOWN, 0), ("tip", UP, 0)], "told"),
    "edge across an edge": ([("ridge", DOWN, 0), ("ridge", SIDEWAYS, 0)], "told"),
    "edge along an edge": ([("ridge", DOWN, 0), ("ridge", UP, 0)], "told"),
    "edge along a part of an edge": ([("ridge", DOWN, 0), ("ridge", UP, (3, 0, 0))], "told"),
    "edge on a face": ([(FLOOR, UP, 0), ("blade", UP, 0)], "told"),
    "layers in one plane": ([("fan", UP, 0), ("fan", UP, (0.5, 0.25, 0))], "untold"),
    "sides along each other, in one plane": (
        [(FLOOR, UP, 0), ("triangle", -UP, (0, -2, 0))],
        "told",
    ),
    "through a face at a vertex": ([(FLOOR, UP, 0), ("needle", UP, (0, 0, -1))], "crossing"),
    "through a face": ([(FLOOR, UP, 0), ("needle", UP, 0)], "crossing"),
    "two valleys": ([("ridge", UP, 0), ("ridge", SIDEWAYS, 0)], "crossing"),
}


@pytest.mark.parametrize("name", CASES)
def test_starts_are_sorted_as_worked_out_by_hand(name):
    parts, expected = CASES[name]
    positions, faces = placed(*parts)
    with pytest.raises(izo_ref.errors.InitialIntersectionError, match="ratchet"):
        izo_ref.Scene(positions, positions, faces)
    scene = izo_ref.Scene(positions, positions, faces, initial_intersections="ratchet")
    if expected == "told":
        assert scene.excluded is None
        assert len(scene.touching.nodes) > 0
        np.testing.assert_allclose(np.linalg.norm(scene.touching.normals, axis=1), 1.0)
    else:
        assert scene.touching is None
        reasons = set(scene.excluded.reasons.tolist())
        crosses = expected == "crossing"
        assert reasons == {Exclusion.CROSSING if crosses else Exclusion.TOUCHING}


@pytest.mark.parametrize("name", [name for name, (_, told) in CASES.items() if told == "told"])
def test_told_pairs_are_pushed_apart_and_never_through(name):
    """The second part is proposed on the other side of the first, or just stays."""
    parts, _ = CASES[name]
    positions, faces = placed(*parts)
    n = len(PARTS[parts[0][0]][0])
    for shift in (0.0, -0.3, 0.3):
        end = positions.copy()
        end[n:, 2] += shift
        scene = izo_ref.Scene(positions, end, faces, initial_intersections="ratchet")
        result = izo_ref.resolve(scene, 1e-2)
        assert result.status is izo_ref.Status.FREE
        up = np.sign(scene.touching.normals[0, 2]) * (1 if scene.touching.nodes[0, 0] >= n else -1)
        if shift * up > 0 or (shift and up == 0):
            np.testing.assert_array_equal(result.positions, end)
        else:
            assert result.objective > 0.0
        following = scene.after(result, end)
        assert following.touching is None
        assert following.excluded is None


def test_a_told_side_is_one_that_a_plane_separates(rng):
    """A linear program looks for the plane that is farthest from the stars of both features."""
    seen = {True: 0, False: 0}
    for _ in range(300):
        names = rng.choice(list(PARTS), 2)
        turns = [TURNS[rng.integers(len(TURNS))] for _ in names]
        shifts = [rng.integers(-1, 2, 3) * 0.5 for _ in names]
        positions, faces = placed(*zip(names, turns, shifts, strict=True))
        scene = izo_ref.Scene(positions, positions, faces, initial_intersections="exclude")
        pairs = [part for part in (scene.excluded, scene.touching) if part is not None]
        for part in pairs:
            sides = Sides(positions, faces, part.nodes)
            for nodes, is_edge_edge in zip(part.nodes.tolist(), part.is_edge_edge, strict=True):
                points = positions[nodes]
                split = 2 if is_edge_edge else 1
                if state_of(points, split) is not PairState.TOUCHING:
                    continue
                contact = sides.contact(bool(is_edge_edge), nodes)
                told = sides.side(contact)[0] is Side.TOLD
                assert told is separable(positions, faces, contact)
                seen[told] += 1
    assert min(seen.values()) > 50


def state_of(points, split):
    """Return whether the two sides of a pair touch at rest."""
    from tests.naive.simplices import simplices_meet

    meet = simplices_meet(points[:split], points[split:])
    return PairState.TOUCHING if meet else PairState.APART


def separable(positions, faces, contact):
    """Return whether a plane through both features separates the faces around them.

    Maximise the sum of n . x over the corners of the first star, less that over the second, with
    n . x of the right sign each, and zero on the features. Then it is positive.
    """
    rows, equal = [], []
    for sign, feature in ((1.0, contact.first), (-1.0, contact.second)):
        base = positions[feature[0]]
        equal += [positions[v] - base for v in feature[1:]]
        around = faces[[set(feature) <= set(face) for face in faces.tolist()]]
        rows += [sign * (positions[v] - base) for v in sorted(set(around.ravel()) - set(feature))]
    if not rows:
        return False
    rows = np.array(rows)
    solution = linprog(
        -rows.sum(axis=0),
        A_ub=-rows,
        b_ub=np.zeros(len(rows)),
        A_eq=np.array(equal) if equal else None,
        b_eq=np.zeros(len(equal)) if equal else None,
        bounds=[(-1, 1)] * 3,
    )
    return bool(-solution.fun > 1e-9)
