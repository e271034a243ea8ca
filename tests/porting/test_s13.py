"""The vectors of stage S13: our own code passes, and sloppy checks do not."""

import math
import re
from itertools import combinations

import pytest

from izo_ref import IzoError
from izo_ref.porting.cases import VALID
from izo_ref.porting.files import load_cases
from tests.helpers.vectors import caught, require_good_cases
from tests.ports.own.s13 import answer

CASES = load_cases(stages=["S13"])
# In compiled code, x / 0 is inf without a warning; without compilation numpy warns.
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")
OWNED = ("bad-shape", "bad-number", "bad-index", "bad-mass", "bad-thickness", "bad-start")


def expects_refusal(case):
    return case.expected["status"]["values"] == ["refused"]


def test_the_cases_are_complete():
    require_good_cases(CASES, (*OWNED, "over-strict", "degenerate-elements"))
    assert all(expects_refusal(case) == (case.verdict != VALID) for case in CASES)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_our_own_code_refuses_what_it_has_to(case):
    if not expects_refusal(case):
        assert answer(dict(case.inputs), "f8") == {}
        return
    with pytest.raises(IzoError) as error:
        answer(dict(case.inputs), "f8")
    if "offender" in case.expected:
        (offender,) = case.expected["offender"]["values"]
        assert offender in map(int, re.findall(r"\b\d+\b", str(error.value)))


def counts(own):
    """Return numbers of coordinates at the start and at the end, of masses, flags and corners."""
    names = ("positions_t0", "positions_t1", "masses", "pinned", "faces")
    return [len(own[name]) for name in names]


def no_nan(own, name):
    return all(math.isfinite(value) for value in own[name])


# Checks, each without one thing; True if the check finds nothing.
SLOPPY = {
    "bad-shape": lambda own: counts(own)[0] % 3 == 0 and counts(own)[4] % 3 == 0,
    "bad-number": lambda own: no_nan(own, "positions_t0"),
    "bad-index": lambda own: max(own["faces"], default=0) < len(own["masses"]),
    "bad-mass": lambda own: not any(m <= 0.0 for m in own["masses"]),
    "bad-thickness": lambda own: not own["thickness"] <= 0.0,
    "bad-start": lambda own: True,
    "degenerate-elements": lambda own: all(
        own["faces"][i] != own["faces"][i + 1] for i in range(0, len(own["faces"]) - 1, 3)
    ),
}
STRICT = {
    "positive masses everywhere": lambda own: all(m > 0.0 for m in own["masses"]),
    "something to do": lambda own: bool(own["faces"]),
    "ordinary sizes": lambda own: 1e-3 < max(map(abs, own["positions_t0"])) < 1e3,
    "finite masses": lambda own: math.inf not in own["masses"],
    "ordinary masses": lambda own: max(own["masses"]) < 1e3,
    "each face once": lambda own: len({tuple(f) for f in faces(own)}) == len(faces(own)),
}


def faces(own):
    return [own["faces"][i : i + 3] for i in range(0, len(own["faces"]), 3)]


# Checks that leave out some faces or corners; True if the check sees nothing in the case.
BLIND = {
    "S13-repeated-04": lambda own: all(a not in (b, c) for a, b, c in faces(own)),
    "S13-start-07": lambda own: all(set(a) & set(b) for a, b in combinations(faces(own), 2)),
    "S13-start-08": lambda own: sum(any(cross(own, face)) for face in faces(own)) < 2,
}


def cross(own, face):
    """Return twice the area of a face at the start, as a vector."""
    at = [own["positions_t0"][3 * v : 3 * v + 3] for v in face]
    (a, b, c), (d, e, f) = ([q - p for p, q in zip(at[0], at[k], strict=True)] for k in (1, 2))
    return b * f - c * e, c * d - a * f, a * e - b * d


@pytest.mark.parametrize("name", BLIND)
def test_a_check_that_skips_some_faces_is_caught(name):
    (case,) = (case for case in CASES if case.id == name)
    assert expects_refusal(case)
    assert BLIND[name](case.inputs)


@pytest.mark.parametrize("flag", SLOPPY)
def test_a_check_that_misses_something_is_caught(flag):
    wrong = caught(flag, CASES, lambda case: SLOPPY[flag](case.inputs) != expects_refusal(case))
    assert wrong
    assert set(SLOPPY) >= set(OWNED)


@pytest.mark.parametrize("name", STRICT)
def test_a_check_that_refuses_too_much_is_caught(name):
    assert caught("over-strict", CASES, lambda case: STRICT[name](case.inputs))
