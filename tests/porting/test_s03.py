"""Vectors of stage S3: weights and normals."""

from fractions import Fraction

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.reference.closest import closest
from tests.naive.closest import closest_vector
from tests.ports.own.s03 import answer

CASES = load_cases(stages=["S3"])
OWNED = (
    "normal-sign",
    "frame-time",
    "weights-order",
    "coplanar-motion",
    "float32-coordinates",
    "parallel-edges",
    "degenerate-elements",
    "absolute-tolerance",
    "clamped-points",
)
EPS = {"f8": 2.0**-52, "f4": 2.0**-23}


def positions(inputs, time, number=np.float64):
    """Return the nodes at a time relative to the first one, (4, 3)."""
    start, end = (np.array(inputs[k], number).reshape(4, 3) for k in ("start", "end"))
    return (1 - number(time)) * (start - start[0]) + number(time) * (end - end[0])


def is_right(case, reply, dtype="f8"):
    """Return whether weights and normal are right, or have the properties that are asked for."""
    weights, normal = np.array(reply["weights"]), np.array(reply["normal"])
    first = 2 if case.inputs["is_edge_edge"] else 1
    for expected, got in ((case.expected["weights"], weights), (case.expected["normal"], normal)):
        tolerance = expected["multiple"] * EPS[dtype] * expected["scale"][0]
        rounding = expected["multiple"] * EPS[dtype]
        if expected["judge"] == "values":
            good = (np.abs(got - expected["values"]) <= tolerance).all()
        elif expected["judge"] == "weights":
            between = weights @ positions(case.inputs, case.inputs["toi"])
            good = abs(np.linalg.norm(between) - expected["distance"]) <= tolerance
            good &= abs(weights.sum()) <= rounding
            good &= (weights[:first] >= 0).all() and (weights[first:] <= 0).all()
        else:
            gap = normal @ (weights @ positions(case.inputs, 0.0))
            good = gap >= expected["least_gap"] - tolerance
            good &= abs(np.linalg.norm(normal) - 1) <= rounding
        if not good:
            return False
    return True


def plane_normal(inputs, time):
    """Return the unit normal of the plane at a time, NaN where it does not exist."""
    x = positions(inputs, time)
    ends = (x[1] - x[0], x[3] - x[2]) if inputs["is_edge_edge"] else (x[2] - x[1], x[3] - x[1])
    n = np.cross(*ends)
    with np.errstate(all="ignore"):
        return n / np.linalg.norm(n)


def keeps_the_side_of_the_plane(inputs):
    """Never turn the normal."""
    return {**answer(inputs, "f8"), "normal": plane_normal(inputs, inputs["toi"])}


def takes_the_side_at_the_start(inputs):
    """Turn the normal as the plane at t = 0 says."""
    normal, x = plane_normal(inputs, inputs["toi"]), positions(inputs, 0.0)
    side = plane_normal(inputs, 0.0) @ (x[0] - x[2])
    return {**answer(inputs, "f8"), "normal": normal if side > 0 else -normal}


def takes_the_frame_at(time):
    return lambda inputs: answer({**inputs, "toi": time}, "f8")


def orders_the_weights_otherwise(inputs):
    reply = answer(inputs, "f8")
    a, b, c, d = reply["weights"]
    return {**reply, "weights": [b, a, d, c] if inputs["is_edge_edge"] else [a, d, b, c]}


def takes_the_normal_of_the_plane_anyway(inputs):
    """Turn the normal to the right side, and have no answer where that is not defined."""
    reply = answer(inputs, "f8")
    normal = plane_normal(inputs, inputs["toi"])
    gap = normal @ (np.array(reply["weights"]) @ positions(inputs, 0.0))
    return {**reply, "normal": normal if gap > 0 else -normal}


def has_a_fixed_tolerance(inputs):
    x = positions(inputs, inputs["toi"])
    ends = (x[1] - x[0], x[3] - x[2]) if inputs["is_edge_edge"] else (x[2] - x[1], x[3] - x[1])
    small = np.linalg.norm(np.cross(*ends)) < 1e-10
    return {**answer(inputs, "f8"), "normal": [0.0, 0.0, 1.0]} if small else answer(inputs, "f8")


def interpolates_in_float32(inputs):
    """Interpolate coordinates in float32, far from the origin, and subtract afterwards."""
    start, end, toi = (np.array(inputs[k], np.float32) for k in ("start", "end", "toi"))
    at = ((1 - toi) * start + toi * end).tolist()
    reply = answer({**inputs, "start": at, "end": at, "toi": 0.0}, "f8")
    return {**answer(inputs, "f8"), "weights": reply["weights"]}


# A function with each mistake; `test_s03_mistakes.py` has more, which fail three cases each.
WRONG = [
    ("normal-sign", keeps_the_side_of_the_plane),
    ("normal-sign", takes_the_side_at_the_start),
    ("frame-time", takes_the_frame_at(0.0)),
    ("frame-time", takes_the_frame_at(1.0)),
    ("weights-order", orders_the_weights_otherwise),
    ("coplanar-motion", takes_the_normal_of_the_plane_anyway),
    ("float32-coordinates", interpolates_in_float32),
    ("parallel-edges", takes_the_normal_of_the_plane_anyway),
    ("degenerate-elements", takes_the_normal_of_the_plane_anyway),
    ("degenerate-elements", has_a_fixed_tolerance),
]


def test_ids_are_unique_and_each_flag_has_three_cases_an_easy_and_a_hard_one():
    assert len({case.id for case in CASES}) == len(CASES) >= 80
    for flag in OWNED:
        grades = [case.grade for case in CASES if flag in case.flags]
        assert len(grades) >= 3, flag
        assert {"easy", "hard"} <= set(grades), flag


def test_inputs_are_float32_wherever_a_float32_is_judged():
    for case in CASES:
        if "f4" in case.dtypes:
            numbers = np.array([*case.inputs["start"], *case.inputs["end"], case.inputs["toi"]])
            assert (np.float32(numbers) == numbers).all(), case.id


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_our_own_answers_pass(case):
    assert is_right(case, answer(case.inputs, "f8"))


@pytest.mark.parametrize(("flag", "wrong"), WRONG)
def test_a_wrong_frame_fails_a_case_of_its_flag(flag, wrong):
    owned = [case for case in CASES if flag in case.flags]
    assert any(not is_right(case, wrong(case.inputs)) for case in owned)


def test_closest_points_are_those_of_an_independent_oracle(rng):
    """Random pairs at rest, with coordinates in eighths; every third one is degenerate."""
    for k in range(600):
        is_edge_edge = bool(k % 2)
        points = rng.integers(-8, 9, (4, 3)) / 8.0
        if k % 3 == 0:
            points[3] = points[2] if k % 9 else (points[1] + points[2]) / 2
        nodes = [[Fraction(float(x)) for x in point] for point in points]
        weights, _, vector, _ = closest(is_edge_edge, nodes)
        first = 2 if is_edge_edge else 1
        assert sum(weights[:first]) == 1 == -sum(weights[first:])
        assert min(weights[:first]) >= 0 >= max(weights[first:])
        length = float(sum(x * x for x in vector)) ** 0.5
        expected = np.linalg.norm(np.asarray(closest_vector(is_edge_edge, points), float))
        assert length == pytest.approx(expected, rel=1e-14, abs=1e-15)


def test_the_closest_points_of_a_general_pair_are_unique_and_of_parallel_edges_are_not():
    def unique(is_edge_edge, points):
        return closest(is_edge_edge, [[Fraction(x) for x in p] for p in points])[3]

    face = [(0, 0, 0), (4, 0, 0), (0, 4, 0)]
    assert unique(False, [(1, 1, 1), *face])
    assert unique(False, [(9, 0, 1), *face])
    assert unique(True, [(0, 0, 0), (4, 0, 0), (1, -1, 1), (1, 1, 1)])
    assert not unique(True, [(0, 0, 0), (4, 0, 0), (1, 0, 1), (6, 0, 1)])
    assert unique(True, [(0, 0, 0), (4, 0, 0), (5, 0, 1), (6, 0, 1)])
    assert not unique(False, [(1, 0, 1), (0, 0, 0), (4, 0, 0), (2, 0, 0)])
