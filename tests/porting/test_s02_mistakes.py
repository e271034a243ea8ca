"""Wrong times of impact: plausible ports of stage S2, each of which fails cases of its flag."""

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.judge.outcome import PASSED
from izo_ref.porting.judge.verdict import judge
from izo_ref.porting.reference.contact import cubic
from tests.helpers.frames import (
    APART,
    NUMBERS,
    coordinates,
    fractions,
    nodes_at,
    pair_of,
    right_answer,
)
from tests.naive.closest import distance

CASES = load_cases(stages=["S2"])


def coefficients(pair, number):
    """Return the coefficients of the cubic in floats, the constant first."""
    start, end = (np.array(points, number) for points in (pair.start, pair.end))
    begin = (start - start[0])[1:]
    change = (end - end[0])[1:] - begin
    terms = [number(0)] * 4
    for bits in range(8):
        rows = [change[k] if bits >> k & 1 else begin[k] for k in range(3)]
        terms[bits.bit_count()] += np.dot(rows[0], np.cross(rows[1], rows[2]))
    return terms


def quadratic_roots(c, b, a):
    if a == 0:
        return [-c / b] if b else []
    square = b * b - 4 * a * c
    return [] if square < 0 else [(-b + s * np.sqrt(square)) / (2 * a) for s in (-1, 1)]


def roots_by_cardano(terms):
    """Solve the cubic by Cardano's formulas, as they are in books."""
    d, c, b, a = terms
    if a == 0:
        return quadratic_roots(d, c, b)
    b, c, d = b / a, c / a, d / a
    p, q = c - b * b / 3, 2 * b**3 / 27 - b * c / 3 + d
    square = q * q / 4 + p**3 / 27
    if square > 0:
        s = np.sqrt(square)
        return [np.cbrt(s - q / 2) + np.cbrt(-s - q / 2) - b / 3]
    if p == 0:
        return [-b / 3]
    r = np.sqrt(-p / 3)
    angle = np.arccos(np.clip(3 * q / (2 * p) / r, -1, 1))
    return [2 * r * np.cos((angle - 2 * np.pi * k) / 3) - b / 3 for k in range(3)]


def all_roots(pair):
    """Return the real roots of the cubic, also outside of the step."""
    exact = [float(c) for c in cubic(pair)]
    roots = np.roots(exact[::-1]) if exact else []
    return sorted(float(r.real) for r in roots if abs(r.imag) < 1e-9)


def is_inside(pair, time, tolerance, number=np.float64):
    start, end = (np.array(points, number) for points in (pair.start, pair.end))
    x = nodes_at(start, end, number(time))
    with np.errstate(all="ignore"):
        found = fractions(x) if pair.is_edge_edge else coordinates(x)
    return min(found) >= -tolerance and (not pair.is_edge_edge or max(found) <= 1 + tolerance)


def first_inside(pair, times, tolerance, number=np.float64):
    for time in sorted(map(float, times)):
        if is_inside(pair, time, tolerance, number):
            return {"meets": 1, "toi": time}
    return APART


def takes_a_small_cubic_for_zero(pair, right, number):
    return APART if cubic(pair) and max(map(abs, cubic(pair))) < 1e-9 else right


def takes_a_small_volume_for_contact(pair, right, number):
    small = cubic(pair) and abs(cubic(pair)[0]) < 1e-9
    return {"meets": 1, "toi": 0.0} if small and is_inside(pair, 0.0, 1e-9) else right


def solves_by_cardano(pair, right, number):
    if not cubic(pair):
        return right
    with np.errstate(all="ignore"):
        roots = roots_by_cardano(coefficients(pair, number))
    return first_inside(pair, [r for r in roots if 0 <= r <= 1], 0.0, number)


def inflates_the_face(pair, right, number):
    within = [r for r in all_roots(pair) if 0 <= r <= 1]
    return right if right["meets"] else first_inside(pair, within, 1e-6)


def shrinks_the_face(pair, right, number):
    gone = right["meets"] and cubic(pair) and not is_inside(pair, right["toi"], -1e-6)
    return APART if gone else right


def looks_inside_faces_alone(pair, right, number):
    """Take edges for met at the first time at which they are in one plane."""
    within = [r for r in all_roots(pair) if 0 <= r <= 1]
    return {"meets": 1, "toi": within[0]} if pair.is_edge_edge and within else right


def forgets_the_ends_of_the_step(pair, right, number):
    return first_inside(pair, all_roots(pair), 0.0) if cubic(pair) else right


def clamps_the_time(pair, right, number):
    times = [min(max(r, 0.0), 1.0) for r in all_roots(pair)]
    return first_inside(pair, times, 0.0) if cubic(pair) else right


def takes_one_step_of_newton(pair, right, number):
    """Improve a time that is early by a tenth; a tangent may end behind the root."""
    exact = [float(c) for c in cubic(pair)]
    if not right["meets"] or not exact:
        return right
    t = 0.9 * right["toi"]
    value = sum(c * t**k for k, c in enumerate(exact))
    slope = sum(k * c * t ** (k - 1) for k, c in enumerate(exact) if k)
    return {"meets": 1, "toi": t - value / slope if slope else t}


def advances_eight_times(pair, right, number):
    """Advance by distance over speed, and count what is not decided then as contact."""
    start, end = np.array(pair.start), np.array(pair.end)
    split, t = (2 if pair.is_edge_edge else 1), 0.0
    moves = (end - start)[:split, None] - (end - start)[split:]
    speed = np.sqrt((moves**2).sum(axis=2)).max()
    for _ in range(8):
        t += 0.9 * distance(pair.is_edge_edge, start, end, t) / speed if speed else 1.0
        if t >= 1.0:
            return right  # what is decided is right
    return {"meets": 1, "toi": t}


BOTH, DOUBLE = ("f8", "f4"), ("f8",)
# Wrong ports, and the types of floats in which they fail at least three cases of the flag.
WRONG = [
    ("absolute-tolerance", takes_a_small_cubic_for_zero, BOTH),
    ("absolute-tolerance", takes_a_small_volume_for_contact, BOTH),
    ("linear-cubic", solves_by_cardano, BOTH),
    ("beside-the-face", inflates_the_face, DOUBLE),  # float32 rounds by more than 1e-6
    ("beside-the-face", shrinks_the_face, BOTH),
    ("beside-the-face", looks_inside_faces_alone, DOUBLE),
    ("ends-of-step", clamps_the_time, DOUBLE),
    ("late-time", takes_one_step_of_newton, BOTH),
    ("step-cap", advances_eight_times, BOTH),
]


def failing(wrong, dtype, chosen=CASES):
    """Return the ids of the cases at which a port is wrong."""
    found = []
    for case in chosen:
        if dtype in case.dtypes:
            pair = pair_of(case.inputs)
            output = wrong(pair, right_answer(pair), NUMBERS[dtype])
            if judge(case, {"status": "ok", "output": output}, dtype).result != PASSED:
                found.append(case.id)
    return found


@pytest.mark.parametrize(("flag", "wrong", "dtypes"), WRONG)
def test_a_wrong_port_fails_three_cases_of_its_flag(flag, wrong, dtypes):
    owned = [case for case in CASES if flag in case.flags]
    for dtype in dtypes:
        assert len(failing(wrong, dtype, owned)) >= 3, failing(wrong, dtype, owned)


@pytest.mark.parametrize("dtype", NUMBERS)
def test_roots_outside_of_the_step_fail(dtype):
    assert len(failing(forgets_the_ends_of_the_step, dtype)) >= 3
