"""Meetings that floats can prove: no proof is wrong, and few pairs are left to exact arithmetic."""

import itertools

import numpy as np
import pytest

from izo_ref.base.exact_path import first_meeting
from izo_ref.certificate.cpu.meetings import decide_meetings
from izo_ref.certificate.formulas.meeting import _areas, _sign3, _sum3
from izo_ref.detection.formulas.advance import APART
from tests.helpers.contacts import first_contact

FACE = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]


def certain(is_edge_edge, start, end, toi):
    """Return whether floats prove that the pair meets near the time `toi`."""
    meets = np.empty(1, bool)
    nodes = np.arange(4, dtype=np.int32)[None]
    decide_meetings(start, end, nodes, np.array([is_edge_edge]), np.array([toi]), meets)
    return bool(meets[0])


def test_certain_meetings_are_true_and_few_meetings_stay_uncertain(rng):
    met = certainly = 0
    for _ in range(3000):
        is_edge_edge = bool(rng.integers(2))
        start, end = 10.0 ** rng.integers(-3, 3) * rng.normal(size=(2, 4, 3)) + rng.normal(size=3)
        status, toi, *_ = first_contact(is_edge_edge, start, end)
        if status == APART:
            continue
        time = first_meeting(is_edge_edge, start, end)
        met += time is not None
        if certain(is_edge_edge, start, end, toi):
            certainly += 1
            assert time is not None
            assert toi <= time <= toi + 1e-9
    assert met > 300
    assert certainly >= met - 2


def test_pairs_that_barely_touch_or_miss_are_never_certain(rng):
    """The vertex is within a few ulps of a side of the face: only exact arithmetic can decide."""
    start = np.array([[2, 2, 1], *FACE], float)
    for _ in range(200):
        end = start.copy()
        end[0] = 2 + rng.integers(-4, 5) * 2.0**-52, 2 - rng.integers(-4, 5) * 2.0**-52, -1
        assert not certain(False, start, end, 0.5)


@pytest.mark.parametrize(
    ("is_edge_edge", "at", "meets"),
    [
        (True, (0, 0), True),
        (True, (3, 0), False),
        (True, (-3, 0), False),
        (True, (0, 3), False),
        (True, (0, -3), False),
        (True, (3, 3), False),
        (False, (0.25, 0.25), True),
        (False, (-0.5, 0.5), False),
        (False, (0.5, -0.5), False),
        (False, (1, 1), False),
        (False, (-1, -1), False),
    ],
)
def test_sides_that_become_coplanar_beside_each_other_do_not_meet(is_edge_edge, at, meets):
    """The first side falls at the place `at` through the plane of the second one, at t = 1/2."""
    if is_edge_edge:
        start = np.array([[-1, 0, 1], [1, 0, 1], [0, -1, 0], [0, 1, 0.0]])
        falling = slice(0, 2)
    else:
        start = np.array([[0, 0, 1], [0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
        falling = slice(0, 1)
    start[falling, :2] += at
    end = start.copy()
    end[falling, 2] = -1.0
    for order in ([0, 1, 2, 3], [2, 3, 0, 1]) if is_edge_edge else ([0, 1, 2, 3], [0, 3, 1, 2]):
        found = np.empty(1, bool)
        nodes, kind = np.array([order], np.int32), np.array([is_edge_edge])
        decide_meetings(start, end, nodes, kind, np.array([0.5]), found)
        assert bool(found[0]) is meets


@pytest.mark.parametrize("is_edge_edge", [False, True])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_sides_that_stay_on_one_side_of_each_other_do_not_meet(is_edge_edge, side):
    """Seen along the normal they overlap all the time, but neither passes through the other."""
    if is_edge_edge:
        start = np.array([[-1, 0, side], [1, 0, side], [0, -1, 0], [0, 1, 0.0]])
    else:
        start = np.array([[0.25, 0.25, side], [0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    upper = slice(0, 2 if is_edge_edge else 1)
    for height, meets in ((0.5, False), (1e-3, False), (0.0, False), (2.0, False), (-1.0, True)):
        end = start.copy()
        end[upper, 2] = height * side
        for first, last in ((start, end), (end, start)):
            assert certain(is_edge_edge, first, last, 0.5) is meets


def test_a_sign_is_certain_only_if_all_three_coefficients_have_it():
    for coefficients in itertools.product((-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0), repeat=3):
        above = all(c > 1.0 for c in coefficients)
        below = all(c < -1.0 for c in coefficients)
        assert _sign3(coefficients, 1.0) == int(above) - int(below)


def test_coefficients_of_an_area_are_those_of_the_area_at_three_times(rng):
    """A quadratic is its first coefficient at the begin, and their mean, 1 2 1, in the middle."""
    for _ in range(50):
        d, u0, v0, u1, v1 = rng.integers(-9, 10, (5, 3)).astype(float)
        first, middle, last = _areas(*(tuple(x.tolist()) for x in (d, u0, v0, u1, v1)))
        assert first == d @ np.cross(u0, v0)
        assert last == d @ np.cross(u1, v1)
        halfway = d @ np.cross((u0 + u1) / 2, (v0 + v1) / 2)
        assert (first + 2.0 * middle + last) / 4 == pytest.approx(halfway, abs=1e-12)
        assert _sum3(tuple(d), tuple(u0), tuple(v0)) == tuple(d + u0 + v0)
