"""Vectors of stage S2: whether a pair meets, and when."""

import math
from fractions import Fraction

import numpy as np
import pytest

from izo_ref.detection.formulas.advance import advance
from izo_ref.porting.files import load_cases
from izo_ref.porting.generate.s02 import EARLY, MULTIPLE
from izo_ref.porting.reference.contact import Pair, cubic, meeting
from tests.helpers.frames import APART, pair_of, right_answer
from tests.ports.own.s02 import answer
from validation.ladders.stage_calls import relative_nodes
from validation.oracles.path import first_meeting

CASES = load_cases(stages=["S2"])
OWNED = (
    "linear-cubic",
    "coplanar-motion",
    "absolute-tolerance",
    "late-time",
    "ends-of-step",
    "beside-the-face",
    "many-roots",
    "starts-in-contact",
    "stays-coplanar",
    "float32-coordinates",
    "parallel-edges",
    "degenerate-elements",
    "still-nodes",
)
EPS = {"f8": 2.0**-52, "f4": 2.0**-23}


def is_right(case, reply, dtype="f8"):
    """Return whether a reply is right; a time may be early by a quarter of itself."""
    if case.expected["meets"]["values"] != [reply["meets"]]:
        return False
    if not reply["meets"]:
        return True
    expected = case.expected["toi"]
    tolerance = expected["multiple"] * EPS[dtype] * expected["scale"]
    low = (1 - expected["early"]) * expected["time"] - tolerance
    return low <= reply["toi"] <= expected["time"] + tolerance


def roots_of(pair):
    """Return the roots in [0, 1] of the cubic in floats; nothing if it is zero."""
    coefficients = [float(c) for c in cubic(pair)]
    roots = np.roots(coefficients[::-1]) if coefficients else np.empty(0)
    return sorted(float(r.real) for r in roots if abs(r.imag) < 1e-9 and 0 <= r.real <= 1)


def normal_at(pair, time):
    """Return the normal at a time, zero for parallel edges and for faces without area."""
    x = (1 - time) * np.array(pair.start) + time * np.array(pair.end)
    ends = (x[1] - x[0], x[3] - x[2]) if pair.is_edge_edge else (x[2] - x[1], x[3] - x[1])
    return np.cross(*ends)


def divides_by_the_leading_coefficient(pair, right):
    """Find roots by the formula for cubics, which needs a coefficient of t^3."""
    return right if len(cubic(pair)) == 4 else APART


def compares_the_ends(pair, right):
    """Look for roots only if the cubic has different signs at t = 0 and t = 1."""
    exact = cubic(pair)
    return right if exact and exact[0] * sum(exact) < 0 else APART


def has_a_fixed_tolerance(pair, right):
    return APART if max(map(abs, cubic(pair)), default=1) < 1e-12 else right


def adds_a_thickness(pair, right):
    """Take everything for a meeting that comes within 1e-6 of it at the end."""
    gap = abs(float(sum(cubic(pair)))) / max(np.linalg.norm(normal_at(pair, 1)), 1e-300)
    return {"meets": 1, "toi": 1.0} if gap < 1e-6 else right_answer(pair)


def looks_at_the_plane_alone(pair, right):
    roots = roots_of(pair)
    return {"meets": 1, "toi": roots[0]} if roots else right


def looks_at_the_first_root_alone(pair, right):
    roots = roots_of(pair)
    late = roots and right["meets"] and right["toi"] > roots[0] + 1e-6
    return APART if late else right


def rounds_to_float32(pair, right):
    start, end = (np.float32(points).tolist() for points in (pair.start, pair.end))
    return right_answer(Pair(pair.is_edge_edge, start, end))


def gives_up_without_a_normal(pair, right):
    gone = right["meets"] and not normal_at(pair, right["toi"]).any()
    return APART if gone else right


def skips_what_rests(pair, right):
    nodes = range(4 if pair.is_edge_edge else 1)
    return APART if any(pair.start[k] == pair.end[k] for k in nodes) else right


def without(condition, instead=APART):
    """Return a solver that answers `instead` where a condition on the pair and answer holds."""
    return lambda pair, right: instead if condition(pair, right) else right


# A solver with each mistake: from the pair and the right answer to what it says.
WRONG = [
    ("linear-cubic", divides_by_the_leading_coefficient),
    ("coplanar-motion", without(lambda pair, right: not cubic(pair))),
    ("coplanar-motion", without(lambda pair, _: not cubic(pair), {"meets": 1, "toi": 0.0})),
    ("stays-coplanar", compares_the_ends),
    ("absolute-tolerance", has_a_fixed_tolerance),
    ("absolute-tolerance", adds_a_thickness),
    ("late-time", lambda _, right: {**right, "toi": right.get("toi", 0) + 1e-6}),
    ("ends-of-step", without(lambda _, right: right.get("toi") == 1.0)),
    ("ends-of-step", lambda pair, right: adds_a_thickness(pair, right)),
    ("beside-the-face", looks_at_the_plane_alone),
    ("many-roots", looks_at_the_first_root_alone),
    ("many-roots", looks_at_the_plane_alone),
    ("starts-in-contact", without(lambda _, right: right.get("toi") == 0.0)),
    ("float32-coordinates", rounds_to_float32),
    ("parallel-edges", gives_up_without_a_normal),
    ("degenerate-elements", gives_up_without_a_normal),
    ("still-nodes", skips_what_rests),
]


def test_ids_are_unique_and_each_flag_has_three_cases_an_easy_and_a_hard_one():
    assert len({case.id for case in CASES}) == len(CASES) >= 70
    for flag in OWNED:
        grades = [case.grade for case in CASES if flag in case.flags]
        assert len(grades) >= 3, flag
        assert {"easy", "hard"} <= set(grades), flag


def test_inputs_are_float32_wherever_a_float32_is_judged():
    for case in CASES:
        if "f4" in case.dtypes:
            numbers = np.array(case.inputs["start"] + case.inputs["end"])
            assert (np.float32(numbers) == numbers).all(), case.id


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_our_own_answers_pass(case):
    assert is_right(case, answer(case.inputs, "f8"))


@pytest.mark.parametrize("flag", OWNED)
def test_a_wrong_solver_fails_a_case_of_its_flag(flag):
    wrong_ones = [wrong for name, wrong in WRONG if name == flag]
    assert wrong_ones
    for wrong in wrong_ones:
        failed = []
        for case in CASES:
            pair = pair_of(case.inputs)
            if flag in case.flags and not is_right(case, wrong(pair, right_answer(pair))):
                failed.append(case.id)
        assert failed, wrong


def bisect(coefficients, low, high, number):
    """Return where a cubic changes its sign, in floats of one type, without any tolerance."""

    def value(t):
        result = number(0)
        for c in reversed(coefficients):
            result = result * t + c
        return result

    low, high = number(low), number(high)
    below = value(low) > 0
    while True:
        middle = (low + high) / number(2)
        if middle in (low, high):
            return float(high)
        if (value(middle) > 0) == below:
            low = middle
        else:
            high = middle


@pytest.mark.parametrize(("dtype", "number"), [("f8", np.float64), ("f4", np.float32)])
def test_a_root_of_the_cubic_in_floats_is_within_the_tolerance(dtype, number):
    """Wherever the cubic changes its sign at the time, and is a cubic in powers of t."""
    checked, largest = 0, 0.0
    for case in CASES:
        pair = pair_of(case.inputs)
        exact = cubic(pair)
        if dtype not in case.dtypes or "toi" not in case.expected or not exact:
            continue
        time, scale = case.expected["toi"]["time"], case.expected["toi"]["scale"]
        width = max(64 * EPS[dtype] * scale, 1e-4 * time)
        ends = [Fraction(time - width), Fraction(time + width)]
        if len({sum(c * t**k for k, c in enumerate(exact)) > 0 for t in ends}) == 1:
            continue
        start, end = (np.array(x, number) for x in (pair.start, pair.end))
        a, d = (start - start[0])[1:], (end - end[0])[1:] - (start - start[0])[1:]
        terms = [number(0)] * 4
        for bits in range(8):
            rows = [d[k] if bits >> k & 1 else a[k] for k in range(3)]
            terms[bits.bit_count()] += np.dot(rows[0], np.cross(rows[1], rows[2]))
        found = bisect(terms, *map(float, ends), number)
        largest = max(largest, abs(found - time) / (EPS[dtype] * scale))
        checked += 1
    assert checked > 30
    assert 0.01 < largest <= MULTIPLE  # neither too strict nor far from what happens


def test_pairs_that_turn_past_each_other_take_the_steps_that_their_sentences_say():
    found = [case for case in CASES if "step-cap" in case.flags]
    assert found
    for case in found:
        start, end = (relative_nodes(case.inputs[name]) for name in ("start", "end"))
        with np.errstate(all="ignore"):
            steps = advance(bool(case.inputs["is_edge_edge"]), *start, *end)[3]
        assert f" {steps} steps" in case.what


def random_pairs():
    """Yield pairs of small integers, many of them degenerate."""
    rng = np.random.default_rng(20)
    for k in range(400):
        size = 1 + k % 4
        start, end = rng.integers(-size, size + 1, (2, 4, 3)).astype(float)
        if k % 3 == 0:
            start[:, 2] = end[:, 2] = 0.0
        yield Pair(bool(k % 2), start.tolist(), end.tolist())


def test_times_are_those_of_an_independent_oracle():
    met = 0
    for pair in random_pairs():
        found, expected = meeting(pair, MULTIPLE), first_meeting(*pair)
        assert (found is None) == (expected is None), pair
        if found is not None and expected is not None:
            met += 1
            # both are narrowed to at least 2^-64
            assert expected[0] - Fraction(1, 2**64) <= found.time, pair
            assert found.time <= expected[1] + Fraction(1, 2**64), pair
            assert math.isfinite(found.scale)
            assert found.scale >= 0.5
    assert met > 100


def test_a_time_may_be_early_by_what_published_methods_do():
    assert EARLY > 1 - 0.8


def test_the_time_of_a_meeting_is_found_however_its_root_is_enclosed():
    """The exact decision encloses this root twice as narrowly as one that only asks for a float."""
    tiny, low, high = 5e-324, 1.0 - 2.0**-53, 1.0 + 2.0**-52
    start = ((-2.0, -tiny, tiny), (2.0 * low, tiny, 0.0), (tiny, -low, low), (tiny, high, low))
    end = ((-2.0 * low, 0.0, 2.0 * low), (2.0, 0.0, 2.0), (tiny, -high, -1.0), (tiny, 1.0, -low))
    found = meeting(Pair(True, start, end), MULTIPLE)
    assert found is not None
    low, high = first_meeting(True, start, end)
    assert low - Fraction(1, 2**60) <= found.time <= high + Fraction(1, 2**60)
