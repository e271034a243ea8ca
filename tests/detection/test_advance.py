"""The decision of single pairs: whether the two sides meet on their path, and when."""

import numpy as np
import pytest
from numba import njit

from izo_ref.detection.formulas import advance as advance_module
from izo_ref.detection.formulas.advance import APART, CONTACT, UNDECIDED, advance
from izo_ref.detection.serial.contacts import relative_nodes
from tests.helpers.contacts import first_contact
from tests.helpers.queries import constructed_meetings
from tests.helpers.rounding import pure
from tests.helpers.steps import load
from tests.naive.closest import distance
from validation.oracles import path
from validation.scenes.queries import degenerate_queries

VF, EE = False, True
SQUARE = [(0, 0, 1), (0, 0, 0), (1, 0, 0), (0, 1, 0)]  # a vertex over a face


def moved(points, *shifts):
    """Return the points, each moved by its own shift."""
    return [tuple(np.add(p, s)) for p, s in zip(points, shifts, strict=True)]


def drop(points, z, at=(0.25, 0.25)):
    """Return start and end of a vertex that falls by z onto the place `at` of a face at rest."""
    lifted = [(*at, points[0][2]), *points[1:]]
    return lifted, moved(lifted, (0, 0, -z), (0, 0, 0), (0, 0, 0), (0, 0, 0))


CASES = {
    # name: (kind, start, end, whether the pair meets, time of impact or None)
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
        # The pair is coplanar at 1/4, 1/2 and 3/4; at the first the vertex is in the face.
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
def test_degenerate_cases_meet_at_the_known_times(name, scale):
    is_edge_edge, start, end, meets, toi = CASES[name]
    start, end = scale * np.array(start, float), scale * np.array(end, float)
    status, found, *_ = first_contact(is_edge_edge, start, end)
    assert (status != APART) is meets
    if toi is not None:
        assert found == pytest.approx(toi, abs=1e-12)


def test_pairs_in_a_rotating_plane_are_apart(rng):
    """These pairs are coplanar at all times, so only a direction in the plane separates them."""
    for _ in range(50):
        flat = np.column_stack((rng.normal(size=(4, 2)), np.zeros(4)))
        flat[1:, 0] += 6.0
        angle = rng.uniform(0.0, 1.0)
        c, s = np.cos(angle), np.sin(angle)
        turned = flat @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]).T
        assert first_contact(VF, flat, turned)[0] == APART


@pytest.mark.parametrize(("first", "second"), [(0.25, 0.5), (0.5, 0.25), (0.5, -1.0), (-1.0, 0.5)])
def test_the_next_step_begins_where_the_better_direction_ends(first, second):
    """The time that each of the two directions reaches is given here, and so is no root."""
    times, begun = [first, second, 2.0], []

    def reaches(*arguments):
        begun.append(arguments[-2])
        return times.pop(0)

    start, end = np.array(SQUARE, float), np.array(SQUARE, float) + (0.0, 0.0, 0.1)
    a, b = ([tuple(row) for row in (p[1:] - p[0]).tolist()] for p in (start, end))
    given = {"separated_until": reaches, "root_free_until": lambda *_: 0.0}
    search = pure(advance_module._first_contact, given)
    status, toi, _, steps, _ = search(VF, *a, *b, 1e-14, (1.0, 1.0, 1.0, 1.0), 1e-14)
    assert (status, toi, steps) == (APART, 1.0, 2)
    assert begun == [0.0, 0.0, 0.5 - advance_module.MIN_STEP]


def test_small_integer_pairs_are_decided_as_in_exact_arithmetic(rng):
    """Many of these pairs touch, overlap or are degenerate; none that meets may be missed."""
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


def test_random_pairs_are_decided_as_in_exact_arithmetic(rng):
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


@njit(error_model="numpy")
def first_contacts(is_edge_edge, start, end):
    """Decide many pairs of one kind: statuses (n,) and times (n,)."""
    statuses, toi = np.empty(len(start), np.int8), np.empty(len(start))
    nodes = (0, 1, 2, 3)
    for i in range(len(start)):
        a1, a2, a3 = relative_nodes(start[i], nodes)
        b1, b2, b3 = relative_nodes(end[i], nodes)
        statuses[i], toi[i], _, _, _ = advance(is_edge_edge, a1, a2, a3, b1, b2, b3)
    return statuses, toi


@pytest.mark.parametrize("is_edge_edge", [VF, EE])
def test_no_exact_meeting_is_missed_and_no_time_comes_late(rng, is_edge_edge):
    n = 4000
    for _ in range(25):
        start, end, t = constructed_meetings(rng, n, is_edge_edge)
        statuses, toi = first_contacts(is_edge_edge, start, end)
        assert (statuses != APART).all()
        assert (toi <= t).all()


@pytest.mark.parametrize("is_edge_edge", [VF, EE])
def test_a_proof_holds_for_every_end_within_its_margin(rng, is_edge_edge):
    """The margins of all kinds of proof: axes, the cubic, one direction, and two."""
    kinds, met = dict.fromkeys(("axes", "cubic", "one", "two"), 0), 0
    for _ in range(6000):
        start = rng.normal(size=(4, 3))
        end = start + rng.choice([0.1, 0.5, 2.0]) * rng.normal(size=(4, 3))
        status, _, direction, steps, margin = first_contact(is_edge_edge, start, end)
        assert margin >= 0.0
        assert status == APART or margin == 0.0
        if margin == 0.0:
            continue
        kinds[("axes", "one" if any(direction) else "cubic", "two")[steps]] += 1
        for _ in range(4):  # random corners of the boxes in which the nodes may end
            nodes = rng.random(4) < 0.7
            other = end + margin * nodes[:, None] * rng.choice([-1.0, 1.0], (4, 3))
            met += path.first_meeting(is_edge_edge, start, other) is not None
    print(kinds)
    assert min(kinds.values()) > 20
    assert met == 0


# In these cases, rounding decides which two points count as the closest. `advance` then tries no
# direction that separates the two sides. It reports a contact of pairs that pass each other at up
# to 1e-4 of their size. 60 draws of 740 queries had 14 such pairs, all of them of these cases.
CLOSEST_POINTS_ARE_ROUNDED = (
    "slides in the plane just past a corner",
    "just misses a face without area",
    "parallel edges just pass beside",
)
DOUBLE_ROOTS = ("corners turn through the vertex", "edge turns through the other")


def test_no_degenerate_query_of_our_own_is_missed(rng):
    """Each false alarm touches within rounding, as in the next test, or is of a named case."""
    queries = degenerate_queries(rng, 20)
    alarms = undecided = 0
    for name, is_edge_edge, truth, vertices in zip(
        queries.names, queries.is_edge_edge, queries.truth, queries.vertices, strict=True
    ):
        start, end = vertices[:4], vertices[4:]
        status, toi, *_ = first_contact(bool(is_edge_edge), start, end)
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
def test_no_published_query_is_missed_and_every_false_alarm_touches():
    """Decide the 3640 published queries, which are handcrafted degenerate cases.

    Each false alarm has to be explained: at the time of impact, the pair touches within
    rounding. `advance` stops at two kinds of places. At the first, no direction leaves a gap
    above its threshold, 48 u |n|_1 times the size, with |n|_1 <= sqrt 3. At the second, a proof
    reaches less than 32 u farther in time, over which the sides come closer by at most 4 sqrt 3
    sizes. Together this is 305 u = 3.4e-14 of the size.
    """
    data = load("ccd-queries")
    is_edge_edge = data["kind_names"][data["kind"]] == "ee"
    alarms, undecided = {}, 0
    for i, (vertices, truth) in enumerate(zip(data["vertices"], data["truth"], strict=True)):
        start, end = vertices[:4], vertices[4:]
        status, toi, *_ = first_contact(bool(is_edge_edge[i]), start, end)
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
