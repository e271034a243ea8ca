import numpy as np
import pytest
from numba import njit

import izo_ref
from izo_ref.base.options import RULES
from izo_ref.detection.detector import Detector
from izo_ref.detection.formulas.advance import APART, CONTACT, MAX_STEPS, UNDECIDED, advance
from izo_ref.detection.serial.contacts import relative_nodes
from tests.helpers.contacts import NO_REACH, first_contact
from tests.helpers.shapes import grid, two_sheets, vertex_over_face
from tests.helpers.steps import load, load_step
from tests.naive.closest import distance
from validation.oracles import path
from validation.scenes.queries import degenerate_queries

VF, EE = False, True
SQUARE = [(0, 0, 1), (0, 0, 0), (1, 0, 0), (0, 1, 0)]  # a vertex over a face


def moved(points, *shifts):
    return [tuple(np.add(p, s)) for p, s in zip(points, shifts, strict=True)]


def drop(points, z, at=(0.25, 0.25)):
    lifted = [(*at, points[0][2]), *points[1:]]
    return lifted, moved(lifted, (0, 0, -z), (0, 0, 0), (0, 0, 0), (0, 0, 0))


REST = [(0, 0, 0)] * 4
CASES = {
    # name: (kind, start, end, meets, toi or None)
    "through": (VF, *drop(SQUARE, 2.0), True, 0.5),
    "short of it": (VF, *drop(SQUARE, 0.5), False, None),
    "contact exactly at t = 1": (VF, *drop(SQUARE, 1.0), True, 1.0),
    "beside the face": (VF, *drop(SQUARE, 2.0, (0.75, 0.75)), False, None),
    "onto an edge of the face": (VF, *drop(SQUARE, 2.0, (0.5, 0.5)), True, 0.5),
    "onto a corner": (VF, *drop(SQUARE, 2.0, (0.0, 0.0)), True, 0.5),
    "motionless": (VF, SQUARE, SQUARE, False, None),
    "motionless, coplanar, beside": (
        VF, [(2, 2, 0), *SQUARE[1:]], [(2, 2, 0), *SQUARE[1:]], False, None,
    ),
    "rigid translation": (VF, SQUARE, moved(SQUARE, *[(9, -7, 5)] * 4), False, None),
    "in the plane, into the face": (
        VF, [(-1, 0.2, 0), *SQUARE[1:]], [(1, 0.2, 0), *SQUARE[1:]], True, 0.5,
    ),
    "in the plane, past the face": (
        VF, [(-1, -0.2, 0), *SQUARE[1:]], [(2, -0.2, 0), *SQUARE[1:]], False, None,
    ),
    "face without area, hit": (
        VF, [(0.5, 0, 1), (0, 0, 0), (1, 0, 0), (2, 0, 0)],
        [(0.5, 0, -1), (0, 0, 0), (1, 0, 0), (2, 0, 0)], True, 0.5,
    ),
    "face without area, missed": (
        VF, [(0.5, 0.1, 1), (0, 0, 0), (1, 0, 0), (2, 0, 0)],
        [(0.5, 0.1, -1), (0, 0, 0), (1, 0, 0), (2, 0, 0)], False, None,
    ),
    "face that is a point, hit": (
        VF, [(0, 0, 1), *[(0, 0, 0)] * 3], [(0, 0, -1), *[(0, 0, 0)] * 3], True, 0.5,
    ),
    "face turns over under a still vertex": (
        VF, [(0.25, 0.25, 0.1), (0, 0, 0), (1, 0, 0), (0, 1, 0)],
        [(0.25, 0.25, 0.1), (0, 0, 1), (1, 0, 1), (0, 1, 1)], True, 0.1,
    ),
    "cubic with three roots": (
        # coplanar at 1/4, 1/2, 3/4, inside at the first
        VF, [(0.3, 0.3, 0.25), (0, 0, 0), (1, 0, 0), (0, 1, 0)],
        [(0.3, 0.3, -0.75), (0, 0, 0), (1, 0, 0), (0, 1, 0)], True, 0.25,
    ),
    "edges cross": (
        EE, [(-1, 0, 0), (1, 0, 0), (0, -1, 1), (0, 1, 1)],
        [(-1, 0, 0), (1, 0, 0), (0, -1, -1), (0, 1, -1)], True, 0.5,
    ),
    "edges pass beside": (
        EE, [(-1, 0, 0), (1, 0, 0), (2, -1, 1), (2, 1, 1)],
        [(-1, 0, 0), (1, 0, 0), (2, -1, -1), (2, 1, -1)], False, None,
    ),
    "parallel edges meet": (
        EE, [(0, 0, 0), (1, 0, 0), (0.5, 0, 1), (1.5, 0, 1)],
        [(0, 0, 0), (1, 0, 0), (0.5, 0, -1), (1.5, 0, -1)], True, 0.5,
    ),
    "parallel edges pass": (
        EE, [(0, 0, 0), (1, 0, 0), (1.5, 0, 1), (2.5, 0, 1)],
        [(0, 0, 0), (1, 0, 0), (1.5, 0, -1), (2.5, 0, -1)], False, None,
    ),
    "collinear edges run into each other": (
        EE, [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)],
        [(0, 0, 0), (1, 0, 0), (0.5, 0, 0), (1.5, 0, 0)], True, 2 / 3,
    ),
    "collinear edges stay apart": (
        EE, [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)],
        [(0, 0, 0), (1, 0, 0), (1.5, 0, 0), (2.5, 0, 0)], False, None,
    ),
    "edge without length hits an edge": (
        EE, [(-1, 0, 0), (1, 0, 0), (0, 0, 1), (0, 0, 1)],
        [(-1, 0, 0), (1, 0, 0), (0, 0, -1), (0, 0, -1)], True, 0.5,
    ),
    "edge without length misses an edge": (
        EE, [(-1, 0, 0), (1, 0, 0), (0, 0.1, 1), (0, 0.1, 1)],
        [(-1, 0, 0), (1, 0, 0), (0, 0.1, -1), (0, 0.1, -1)], False, None,
    ),
    "two edges without length": (
        EE, [(0, 0, 0), (0, 0, 0), (0, 0, 1), (0, 0, 1)],
        [(0, 0, 0), (0, 0, 0), (0, 0, -1), (0, 0, -1)], True, 0.5,
    ),
    "end touches end at t = 1": (
        EE, [(-1, 0, 0), (0, 0, 0), (1, 1, 0), (1, 2, 0)],
        [(-1, 0, 0), (0, 0, 0), (0, 0, 0), (1, 2, 0)], True, 1.0,
    ),
    "in the plane, edges slide past": (
        EE, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)],
        [(0, 0, 0), (1, 0, 0), (3, 0.5, 0), (4, 0.5, 0)], False, None,
    ),
}  # fmt: skip


@pytest.mark.parametrize("scale", [1.0, 1e-6, 1e6, 1e-100, 1e60])
@pytest.mark.parametrize("name", CASES)
def test_degenerate_cases(name, scale):
    is_edge_edge, start, end, meets, toi = CASES[name]
    start, end = scale * np.array(start, float), scale * np.array(end, float)
    status, found, _, _ = first_contact(is_edge_edge, start, end)
    assert (status != APART) is meets
    if toi is not None:
        assert found == pytest.approx(toi, abs=1e-12)


def test_rotating_neighbours_of_a_flat_grid_are_apart(rng):
    """Coplanar at all times: only a direction in the plane can tell."""
    for _ in range(50):
        flat = np.column_stack((rng.normal(size=(4, 2)), np.zeros(4)))
        flat[1:, 0] += 6.0
        angle = rng.uniform(0.0, 1.0)
        c, s = np.cos(angle), np.sin(angle)
        turned = flat @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]).T
        assert first_contact(VF, flat, turned)[0] == APART


def test_against_exact_arithmetic_on_small_integers(rng):
    """Many of these touch, overlap or are degenerate; a miss is never allowed."""
    counts = {"meets": 0, "apart": 0}
    false_alarms = 0
    for _ in range(400):
        start, end = rng.integers(-3, 4, (2, 4, 3)).astype(float)
        is_edge_edge = bool(rng.integers(2))
        expected = path.meets(is_edge_edge, start, end)
        status, *_ = first_contact(is_edge_edge, start, end)
        if expected:
            counts["meets"] += 1
            assert status != APART, (is_edge_edge, start, end)
        else:
            counts["apart"] += 1
            false_alarms += status != APART
    assert false_alarms == 0, counts
    assert min(counts.values()) > 5, counts


def test_against_exact_arithmetic_on_random_pairs(rng):
    meeting = 0
    for _ in range(300):
        start = rng.normal(size=(4, 3))
        end = start + rng.normal(size=(4, 3)) * rng.choice([0.1, 1.0, 3.0])
        is_edge_edge = bool(rng.integers(2))
        expected = path.meets(is_edge_edge, start, end)
        status, *_ = first_contact(is_edge_edge, start, end)
        assert (status == CONTACT) is expected
        meeting += expected
    assert meeting > 10


def constructed_meetings(rng, n, is_edge_edge):
    """Pairs that meet exactly, at times and with weights that are multiples of 1/16 and 1/8.

    Integers and powers of two throughout, so that every position is a float and the meeting
    is no approximation. Some are flat, some graze, some have elements without size.
    """
    largest = 2 ** int(rng.integers(1, 22))
    x, v = rng.integers(-largest, largest + 1, (2, n, 4, 3)).astype(float)
    x *= 2.0 ** rng.integers(-12, 1, (n, 1, 3))
    v *= 2.0 ** rng.integers(-12, 1, (n, 1, 3))
    kind = rng.integers(5)
    if kind == 0:
        x[..., 2] = v[..., 2] = 0.0
    elif kind == 1:
        v[:, 1:] = v[:, 1:2]
    elif kind == 2:
        x[:, 3], v[:, 3] = x[:, 2], v[:, 2]
    steps = 1 if kind == 3 else 8  # corners and ends only
    if is_edge_edge:
        s, r = rng.integers(0, steps + 1, (2, n)) / steps
        weights = np.column_stack((1 - s, s, -(1 - r), -r))
        moved = slice(0, 2)
    else:
        corners = rng.multinomial(steps, [1 / 3] * 3, n) / steps
        weights = np.column_stack((np.ones(n), -corners))
        moved = slice(0, 1)
    apart = np.einsum("jk,jkx->jx", weights, x)
    x[:, moved] -= apart[:, None, :]
    if kind == 4:  # the velocity at the contact lies in the plane
        slide = x[:, 2] - x[:, 3] if is_edge_edge else x[:, 1] - x[:, 2]
        relative = np.einsum("jk,jkx->jx", weights, v)
        v[:, moved] += (rng.integers(-2, 3, (n, 1)) * slide - relative)[:, None, :]
    t = rng.integers(0, 17, n)[:, None, None] / 16
    return x - t * v, x + (1 - t) * v, t.ravel()


@njit(error_model="numpy")
def first_contacts(is_edge_edge, start, end):
    statuses, toi = np.empty(len(start), np.int8), np.empty(len(start))
    nodes = (0, 1, 2, 3)
    for i in range(len(start)):
        a1, a2, a3 = relative_nodes(start[i], nodes)
        b1, b2, b3 = relative_nodes(end[i], nodes)
        statuses[i], toi[i], _, _ = advance(
            is_edge_edge, a1, a2, a3, b1, b2, b3, NO_REACH, MAX_STEPS
        )
    return statuses, toi


@pytest.mark.parametrize("is_edge_edge", [VF, EE])
def test_no_exact_meeting_is_missed_and_no_time_comes_late(rng, is_edge_edge):
    n = 4000
    for _ in range(25):
        start, end, t = constructed_meetings(rng, n, is_edge_edge)
        statuses, toi = first_contacts(is_edge_edge, start, end)
        assert (statuses != APART).all()
        assert (toi <= t).all()


def test_frames_of_impacts():
    impacts = izo_ref.find_impacts(vertex_over_face())
    i = np.flatnonzero((impacts.nodes == [3, 0, 1, 2]).all(axis=1))
    assert len(i) == 1
    assert impacts.toi[i] == pytest.approx([0.5])
    np.testing.assert_allclose(impacts.weights[i], [[1, -0.5, -0.25, -0.25]], atol=1e-12)
    np.testing.assert_allclose(impacts.normals[i], [[0, 0, 1]], atol=1e-12)


def test_every_impact_has_a_sound_frame(rng):
    scene = two_sheets(rng, 10)
    impacts = izo_ref.find_impacts(scene)
    assert len(impacts.toi) > 50
    np.testing.assert_allclose(impacts.weights.sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(impacts.normals, axis=1), 1.0, atol=1e-12)
    first = np.where(impacts.is_edge_edge, 2, 1)
    for weights, k in zip(impacts.weights, first, strict=True):
        assert (weights[:k] >= 0).all()
        assert (weights[k:] <= 0).all()

    def gaps(t):
        x = (1 - t) * scene.positions_t0[impacts.nodes] + t * scene.positions_t1[impacts.nodes]
        return np.einsum("jk,jkx,jx->j", impacts.weights, x, impacts.normals)

    assert (gaps(0.0) > 0.0).all()
    np.testing.assert_allclose(gaps(impacts.toi[:, None, None]), 0.0, atol=1e-12)
    assert (gaps(1.0) < 0.0).all()


def test_in_plane_contact_gets_a_normal_in_the_plane():
    start = np.array([[-1, 0.2, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0.0], [-1, 0.2, 5], [-2, 0.2, 5]])
    end = start.copy()
    end[0, 0] = 1.0
    impacts = izo_ref.find_impacts(izo_ref.Scene(start, end, [[1, 2, 3], [0, 4, 5]]))
    i = np.flatnonzero((impacts.nodes == [0, 1, 2, 3]).all(axis=1))
    np.testing.assert_allclose(impacts.normals[i], [[-1, 0, 0]], atol=1e-9)


def test_order_and_times_depend_on_the_scene_alone(rng):
    scene = two_sheets(rng)
    first, again = izo_ref.find_impacts(scene), izo_ref.find_impacts(scene)
    for a, b in zip(first, again, strict=True):
        np.testing.assert_array_equal(a, b)
    kinds = first.is_edge_edge.astype(int)
    assert (np.diff(kinds) >= 0).all()


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scaling_a_scene_changes_no_decision(rng, scale):
    scene = two_sheets(rng)
    scaled = izo_ref.Scene(scale * scene.positions_t0, scale * scene.positions_t1, scene.faces)
    a, b = izo_ref.find_impacts(scene), izo_ref.find_impacts(scaled)
    np.testing.assert_array_equal(a.nodes, b.nodes)
    np.testing.assert_allclose(a.toi, b.toi, atol=1e-12)


def same_impacts(a, b):
    for x, y in zip(a, b, strict=True):
        np.testing.assert_array_equal(x, y)


@pytest.mark.parametrize("rules", [frozenset(RULES), frozenset()])
@pytest.mark.parametrize("share", [0.02, 0.3, 1.0])
def test_a_detector_that_follows_a_path_finds_what_a_new_one_finds(rng, share, rules):
    """Ends that move far, then less and less, as they do in the loop; some go back."""
    scene = two_sheets(rng)
    mesh = scene.positions_t0, scene.edges, scene.faces
    detector = Detector(*mesh, rules=rules)
    end = scene.positions_t1.copy()
    sizes, found = [], detector.find(end)
    for size in (0.1, 0.03, 0.01, 1e-3, 1e-3, 1e-5, 0.05, 1e-7, 1e-9, 0.0):
        same_impacts(found, Detector(*mesh).find(end))
        sizes.append(len(found.toi))
        part = rng.random((len(end), 1)) < share
        back = rng.random((len(end), 1)) < 0.1
        step = size * rng.normal(size=end.shape)
        end = np.where(part, np.where(back, scene.positions_t0, end + step), end)
        found = detector.find(end)
    assert len(set(sizes)) > 3


@pytest.mark.parametrize("mover", ["lower", "upper"])
@pytest.mark.parametrize(
    "steps",  # of 0.05; an edge is 1 / 7, far is 0.03 of that
    [(0.045, 0.003, 0.0029), (0.04, 0.003, 0.0029, 0.0028, 0.0027)],
    ids=["in one step", "creeping"],
)
def test_what_meets_within_its_reach_is_found(rng, mover, steps):
    """A sheet comes nearer by less each time, each time within the reach it first had."""
    start, faces = grid(8, 0.0, jitter=1e-5 * rng.normal(size=(64, 3)))
    start = np.concatenate((start, start + (0.013, 0.021, 0.05)))
    faces = np.concatenate((faces, faces + 64)).astype(np.int32)
    edges = izo_ref.Scene(start, start, faces).edges
    detector = Detector(start, edges, faces)
    moves = slice(0, 64) if mover == "lower" else slice(64, 128)
    end, found = start + (1e-4, 0.0, 0.0), []  # what rests is in no tree
    for nearer in steps:
        end[moves, 2] += nearer if mover == "lower" else -nearer
        found.append(detector.find(end))
    assert [len(impacts.toi) > 0 for impacts in found] == [False] * (len(steps) - 1) + [True]
    same_impacts(found[-1], Detector(start, edges, faces).find(end))


def test_a_reach_holds_for_every_end_within(rng):
    """What is proved apart with a reach is apart wherever the nodes end in there."""
    proved, met = 0, 0
    for _ in range(4000):
        is_edge_edge = bool(rng.random() < 0.5)
        start, end = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
        end = start + 0.3 * end
        reach = (10.0 ** rng.uniform(-6, 0)) * rng.random(4)
        if rng.random() < 0.5:  # what is forgotten of one must not hide behind another
            reach = rng.random() * (np.arange(4) == rng.integers(4))
        reach = tuple(reach)
        relative = [tuple(p[k] - p[0]) for p in (start, end) for k in (1, 2, 3)]
        status, _, _, _ = advance(is_edge_edge, *relative, reach, 4)
        if status != APART:
            continue
        proved += 1
        for _ in range(8):  # corners of the boxes in which the nodes end
            other = end + np.array(reach)[:, None] * rng.choice([-1.0, 1.0], (4, 3))
            met += path.first_meeting(is_edge_edge, start, other) is not None
    assert proved > 1000
    assert met == 0


def test_a_part_at_rest_is_found_once_something_gets_there(rng):
    """Sheets far from each other, and a path that leads to the other one later."""
    scene = two_sheets(rng)
    n = len(scene.positions_t0) // 2
    start = scene.positions_t0.copy()
    start[n:, 2] += 100.0
    mesh = start, scene.edges, scene.faces
    detector = Detector(*mesh)
    end = start.copy()
    end[:n, 2] += 1.0
    assert len(detector.find(end).toi) == 0
    every = Detector(*mesh, rules=frozenset())
    every.find(end)
    assert sum(detector.counts.pairs.values()) < sum(every.counts.pairs.values())
    end[:n, 2] += 200.0
    found = detector.find(end)
    assert len(found.toi) > 100
    same_impacts(found, Detector(*mesh, rules=frozenset()).find(end))


@pytest.mark.data
def test_armadillo_rollers_gives_exactly_the_published_pairs():
    truth = load("armadillo-rollers")
    impacts = izo_ref.find_impacts(load_step("armadillo-rollers"))

    def key(row, is_edge_edge):
        a, b = (row[:2], row[2:]) if is_edge_edge else (row[:1], row[1:])
        sides = tuple(sorted(a)), tuple(sorted(b))
        return tuple(sorted(sides)) if is_edge_edge else sides

    for is_edge_edge, name, count in ((False, "vf", 4650), (True, "ee", 19308)):
        rows = impacts.nodes[impacts.is_edge_edge == is_edge_edge].tolist()
        found = {key(row, is_edge_edge) for row in rows}
        expected = {key(row, is_edge_edge) for row in truth[f"true_{name}"].tolist()}
        assert len(rows) == len(found) == len(expected) == count
        assert found == expected


# Cases in which rounding decides which two points count as the closest. `advance` then tries no
# direction that separates the sides, and calls pairs a contact that pass each other at up to 1e-4
# of their size. In 60 draws of 740 queries there were 14 such pairs, all of these cases.
CLOSEST_POINTS_ARE_ROUNDED = (
    "slides in the plane just past a corner",
    "just misses a face without area",
    "parallel edges just pass beside",
)
DOUBLE_ROOTS = ("corners turn through the vertex", "edge turns through the other")


def test_no_degenerate_query_of_our_own_is_missed(rng):
    """Each false alarm touches but for rounding, as below, or is of a named case."""
    queries = degenerate_queries(rng, 20)
    alarms = undecided = 0
    for name, is_edge_edge, truth, vertices in zip(
        queries.names, queries.is_edge_edge, queries.truth, queries.vertices, strict=True
    ):
        start, end = vertices[:4], vertices[4:]
        status, toi, _, _ = first_contact(bool(is_edge_edge), start, end)
        assert status != APART or not truth, f"{name} missed"
        if status == UNDECIDED:
            assert name in DOUBLE_ROOTS
            undecided += 1
        if status != APART and not truth:
            alarms += 1
            size = np.abs(vertices - vertices[[0, 0, 0, 0, 4, 4, 4, 4]]).max()
            rounding = distance(is_edge_edge, start, end, toi) <= 3.4e-14 * size
            assert rounding or name in CLOSEST_POINTS_ARE_ROUNDED, f"{name} is no touching pair"
    print(f"\n{alarms} false alarms, {undecided} undecided, of {len(queries.names)} queries")
    assert alarms <= 12
    assert undecided <= 2


@pytest.mark.data
def test_no_query_is_missed_and_every_false_alarm_touches():
    """3640 queries of handcrafted degenerate cases, through the scalar code.

    A false alarm has to be explained: at the time of impact the pair touches but for
    rounding. `advance` stops where no direction leaves more than its threshold, 48 u |n|_1
    times the size, |n|_1 <= sqrt 3, or where a proof reaches less than 32 u farther, over
    which the sides come closer by at most 4 sqrt 3 sizes: 305 u = 3.4e-14 of the size.
    """
    data = load("ccd-queries")
    is_edge_edge = data["kind_names"][data["kind"]] == "ee"
    alarms, undecided = {}, 0
    for i, (vertices, truth) in enumerate(zip(data["vertices"], data["truth"], strict=True)):
        start, end = vertices[:4], vertices[4:]
        status, toi, _, _ = first_contact(bool(is_edge_edge[i]), start, end)
        assert status != APART or not truth, f"query {i} missed"
        undecided += status == UNDECIDED
        if status != APART and not truth:
            gap = distance(is_edge_edge[i], start, end, toi)
            size = np.abs(vertices - vertices[[0, 0, 0, 0, 4, 4, 4, 4]]).max()
            assert gap <= 3.4e-14 * size, f"query {i} is no touching pair"
            name = str(data["names"][data["name"][i]])
            alarms[name] = alarms.get(name, 0) + 1
    assert undecided == 0
    print(f"\nfalse alarms, all of pairs that touch within 3.4e-14 of their size: {alarms}")
    assert sum(alarms.values()) <= 130
