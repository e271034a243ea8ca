"""First meetings on a path in exact arithmetic."""

from fractions import Fraction

import numpy as np
import pytest

import izo_ref
from izo_ref.base.algebraic import roots_in_unit_interval, sign_at
from izo_ref.base.exact_path import (
    crosses_after_start,
    first_meeting,
    first_meeting_after_start,
)
from tests.helpers.queries import SOURCES, queries_of
from tests.naive.simplices import simplices_meet
from validation.oracles import path as path_oracle

Z, X, Y, FAR = [0, 0, 0], [1, 0, 0], [0, 1, 0], [3, 0, 0]
LEFT, RIGHT, BACK, FRONT = [-1, 0, 1], [1, 0, 1], [0, -1, 1], [0, 1, 1]
FACE = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]


def path(start, end):
    """Return both as arrays of floats."""
    return np.array(start, float), np.array(end, float)


def test_roots_are_isolated_and_signs_there_are_exact():
    """(2 t^2 - 1) (3 t - 1)^2 t has three different roots in [0, 1], one of them irrational."""
    square = [-1, 0, 2]
    zero, rational, irrational = roots_in_unit_interval([0, -1, 6, -7, -12, 18])
    assert (zero.low, zero.high) == (0, 0)
    assert Fraction(rational.low, rational.unit) < Fraction(1, 3)
    assert Fraction(rational.high, rational.unit) >= Fraction(1, 3)
    assert sign_at([-1, 3], rational) == 0
    assert sign_at(square, irrational) == 0
    assert sign_at([0, -1, 0, 2], irrational) == 0  # shares this root, and has two others
    assert sign_at([-707106781, 10**9], irrational) == 1  # sqrt(1/2) = 0.70710678118...
    assert sign_at([-707106782, 10**9], irrational) == -1
    assert sign_at([], irrational) == 0
    assert roots_in_unit_interval([5]) == []
    assert [(t.low, t.high, t.unit) for t in roots_in_unit_interval([-1, 1])] == [(1, 1, 1)]


@pytest.mark.parametrize(
    ("is_edge_edge", "start", "end", "time"),
    [
        # through the inside, at a time that is a float and at one that is not
        (False, [[1, 1, 1], *FACE], [[1, 1, -1], *FACE], 0.5),
        (False, [[1, 1, 1], *FACE], [[1, 1, -2], *FACE], 1 / 3),
        # onto a side; onto a corner; outside of a side and inside of it by half an ulp
        (False, [[2, 2, 1], *FACE], [[2, 2, -1], *FACE], 0.5),
        (False, [[4, 0, 1], *FACE], [[4, 0, 0], *FACE], 1.0),
        (False, [[2, 2 + 2**-51, 1], *FACE], [[2, 2, -1], *FACE], None),
        (False, [[2, 2 - 2**-52, 1], *FACE], [[2, 2, -1], *FACE], 0.5),
        # stops just before the face; starts on the face
        (False, [[1, 1, 1], *FACE], [[1, 1, 5e-324], *FACE], None),
        (False, [[1, 1, 0], *FACE], [[1, 1, 1], *FACE], 0.0),
        # a double root: the corners turn through a line that contains the vertex, or does not
        (False, [Z, LEFT, BACK, [0, 0, -1]], [Z, RIGHT, FRONT, [0, 0, -1]], 0.5),
        (False, [Z, LEFT, BACK, [0, 0, 1]], [Z, RIGHT, FRONT, [0, 0, 1]], None),
        # in the plane of the face all the time: into its side, past it
        (False, [[-1, 1, 0], *FACE], [[1, 1, 0], *FACE], 0.5),
        (False, [[-1, 5, 0], *FACE], [[5, 5, 0], *FACE], None),
        # on one line all the time, with a face that has no area; all in one point
        (False, [[-2, 0, 0], Z, X, [2, 0, 0]], [[2, 0, 0], Z, X, [2, 0, 0]], 0.5),
        (False, [[-2, 0, 0], Z, Z, Z], [[-1, 0, 0], Z, Z, Z], None),
        (False, [Z] * 4, [X] * 4, 0.0),
        # edges: crossing, end on end, parallel, past each other, on one line, without length
        (True, [LEFT, RIGHT, [0, -1, 0], Y], [[-1, 0, -1], [1, 0, -1], [0, -1, 0], Y], 0.5),
        (True, [[0, 0, 1], [1, 0, 1], Z, Y], [[0, 0, -1], [1, 0, -1], Z, Y], 0.5),
        (True, [[0, 0, 1], [1, 0, 1], Z, X], [[0, 0, -1], [1, 0, -1], Z, X], 0.5),
        (True, [[0, 0, 1], RIGHT, [2, 0, 0], FAR], [[0, 0, -1], [1, 0, -1], [2, 0, 0], FAR], None),
        (True, [Z, X, [2, 0, 0], FAR], [X, [2, 0, 0], X, [2, 0, 0]], 0.5),
        (True, [Z, Z, [2, 0, 0], [2, 1, 0]], [[4, 2, 0], [4, 2, 0], [2, 0, 0], [2, 1, 0]], 0.5),
    ],
)  # fmt: skip
def test_meeting_times_are_those_worked_out_by_hand(is_edge_edge, start, end, time):
    assert first_meeting(is_edge_edge, *path(start, end)) == time


def test_small_integer_pairs_are_decided_as_by_another_exact_oracle(rng):
    """Pairs with small integers include every degenerate case."""
    met = 0
    for _ in range(1500):
        is_edge_edge = bool(rng.integers(2))
        start, end = rng.integers(-2, 3, (2, 4, 3)).astype(float)
        expected = path_oracle.meets(is_edge_edge, start, end)
        time = first_meeting(is_edge_edge, start, end)
        assert (time is not None) == expected, (is_edge_edge, start, end)
        met += expected
        # Compare with the hulls at rest at one moment.
        moment = Fraction(int(rng.integers(5)), 4)
        at = (1 - float(moment)) * start + float(moment) * end  # exact, in multiples of 1/4
        split = 2 if is_edge_edge else 1
        if simplices_meet(at[:split], at[split:]):
            assert time is not None
            assert time <= moment
    assert 200 < met < 1300


@pytest.mark.parametrize("source", SOURCES)
def test_every_query_gets_its_known_answer(source, rng):
    queries = queries_of(source, rng)
    for i, (vertices, truth) in enumerate(zip(queries.vertices, queries.truth, strict=True)):
        time = first_meeting(bool(queries.is_edge_edge[i]), vertices[:4], vertices[4:])
        assert (time is not None) == truth, f"query {i}, {queries.names[i]}"


def test_a_certificate_decides_what_floats_cannot():
    """A vertex lands on the face z = y, or stops short of it by the last bit."""
    start = [Z, X, [0, 1, 1], [0.25, 0.25, 1], [0.3, 0.2, 9], [0.2, 0.3, 9]]
    start = np.array(start, float)
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    for height, free in ((0.25, False), (np.nextafter(0.25, 1.0), True)):
        end = start.copy()
        end[3, 2] = height
        certificate = izo_ref.certify_path(izo_ref.Scene(start, end, faces), end)
        assert certificate.free is free
        assert certificate.exact > 0
        assert certificate.time_free == 1.0


AFTER_START = [
    # lifts off its face, goes through it, stays in it, slides off over its side
    (False, [[1, 1, 0], *FACE], [[1, 1, 1], *FACE], None),
    (False, [[1, 1, 0], *FACE], [[1, 1, -1], *FACE], None),
    (False, [[1, 1, 0], *FACE], [[1, 1, 0], *FACE], 0.0),
    (False, [[2, 2, 0], *FACE], [[3, 3, 0], *FACE], None),
    (False, [[1, 1, 0], *FACE], [[3, 3, 0], *FACE], 0.0),
    # lifts off and comes back, because the face turns about the y axis
    (False, [[2, 1, 0], *FACE], [[2, 1, 0.5], [0, 0, 0], [4, 0, 4], [0, 4, 0]], None),
    # along its side, which it leaves, or enters; onto a corner at the end
    (False, [[-1, 1, 0], *FACE], [[1, 1, 0], *FACE], 0.5),
    (False, [[0, 1, 0], *FACE], [[-1, 1, 0], *FACE], None),
    # two edges that cross in a point, part, or stay on each other
    (True, [LEFT, RIGHT, BACK, FRONT], [[-1, 0, 2], [1, 0, 2], BACK, FRONT], None),
    (True, [LEFT, RIGHT, BACK, FRONT], [LEFT, RIGHT, BACK, FRONT], 0.0),
    (True, [Z, X, X, FAR], [Z, X, FAR, [4, 0, 0]], None),
    (True, [Z, FAR, X, FAR], [Z, FAR, [2, 0, 0], [4, 0, 0]], 0.0),
]


@pytest.mark.parametrize(("is_edge_edge", "start", "end", "time"), AFTER_START)
def test_meetings_after_the_start_are_those_worked_out_by_hand(is_edge_edge, start, end, time):
    start, end = path(start, end)
    assert first_meeting_after_start(is_edge_edge, start, end) == time
    assert path_oracle.meets_after_start(is_edge_edge, start, end) is (time is not None)


@pytest.mark.parametrize("is_edge_edge", [False, True])
def test_meetings_after_the_start_agree_with_the_oracle(rng, is_edge_edge):
    """Integer coordinates, most of them equal: every second pair touches at the start."""
    touching = meeting = 0
    for _ in range(600):
        start, end = rng.integers(-1, 2, (2, 4, 3)).astype(float)
        if rng.random() < 0.3:
            start[0] = start[rng.integers(1, 4)]
        time = first_meeting_after_start(is_edge_edge, start, end)
        assert path_oracle.meets_after_start(is_edge_edge, start, end) is (time is not None)
        first = first_meeting(is_edge_edge, start, end)
        if first is None or first > 0.0:
            assert time == first
        touching += first == 0.0
        meeting += first == 0.0 and time is None
    assert touching > 100
    assert meeting > 20


def test_edges_go_through_faces_after_the_start_as_the_oracles_say(rng):
    """Against the oracle, and at rest at a time close enough to 0."""
    count = 0
    for _ in range(600):
        start, end = rng.integers(-1, 2, (2, 5, 3)).astype(float)
        if rng.random() < 0.5:
            start[0] = start[2:].mean(axis=0).round()
        goes = crosses_after_start(start, end)
        assert goes is path_oracle.goes_through_after_start(start, end)
        soon = start * (1.0 - 2.0**-30) + end * 2.0**-30  # exact for these numbers
        assert simplices_meet(soon[:2], soon[2:]) or not goes
        count += goes
    assert count > 20
