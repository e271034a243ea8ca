"""Cases of stage S9: the update of the multipliers."""

from __future__ import annotations

from random import Random

from izo_ref.porting.cases import DTYPES, Case
from izo_ref.porting.generate.expected import CaseList, exact_inputs, values
from izo_ref.porting.generate.small_zones import dyadic
from izo_ref.porting.reference.zone import updated

CLAMP = "multipliers-not-clamped"
PENALTY = "penalty-scaling"
KINK = "kink"
SIGN = "constraint-sign"
ABSOLUTE = "absolute-tolerance"
DIGITS = "float32-coordinates"
FLUSHED = 2.0**-128  # with this scale a float32 port may flush 2^-149 to zero


def cases() -> list[Case]:
    """Return the cases of stage S9."""
    result = CaseList("S9")
    for part in (_clamped, _penalties, _kinks, _signs, _tiny, _long, _digits):
        part(result)
    return result


def _add(
    result: CaseList,
    flags: str,
    grade: str,
    what: str,
    numbers: tuple[list[float], list[float], float],
    least: float = 0.0,
    dtypes: tuple[str, ...] = DTYPES,
) -> None:
    """Add a case; `numbers` are the multipliers, the constraints and the penalty.

    The update is also written l + mu max(c, -l / mu). Where l ends at 0, this form rounds the
    quotient and the product, each by half a unit of l, so its error is l in place of 0.
    """
    multipliers, c, penalty = numbers
    inputs = {"multipliers": multipliers, "constraints": c, "penalty": penalty}
    known = inputs if "f4" in dtypes else exact_inputs(inputs)
    wanted = values(updated(*known.values()), least=least)
    wanted["scale"] = [
        max(scale, abs(old)) if new == 0.0 else scale
        for scale, new, old in zip(wanted["scale"], wanted["values"], multipliers, strict=True)
    ]
    expected = {"multipliers": wanted}
    result.add(flags.split()[0], flags, grade, what, inputs, expected, dtypes)


def _clamped(result: CaseList) -> None:
    what = "c is negative, and l is 0: it stays 0."
    _add(result, CLAMP, "easy", what, ([0.0], [-0.5], 2.0))
    what = "l + mu c is negative: the new l is 0."
    _add(result, CLAMP, "easy", what, ([1.0], [-0.75], 2.0))
    what = "c is negative, and l shrinks, but not to 0."
    _add(result, CLAMP, "easy", what, ([2.0], [-0.5], 2.0))
    what = "Each constraint is clamped alone: one of four ends at 0."
    _add(result, CLAMP, "medium", what, ([1.0, 1.0, 0.0, 3.0], [0.5, -1.0, 0.25, -1.0], 2.0))
    what = "l + mu c is negative by one part in 2^20."
    _add(result, CLAMP, "medium", what, ([1.0 - 2.0**-20], [-0.5], 2.0))
    what = "Pairs that are kilometres apart with a large mu: the new l is 0."
    _add(result, CLAMP, "hard", what, ([2.0**10, 2.0**20], [-(2.0**10), -(2.0**12)], 2.0**20))
    what = "l and c are negative zeros: the new l is a zero of any sign."
    _add(result, CLAMP, "hard", what, ([0.0, -0.0, -0.0], [-0.0, 0.0, -0.0], 4.0))


def _penalties(result: CaseList) -> None:
    what = "mu is 1: c is added."
    _add(result, PENALTY, "easy", what, ([0.5], [0.25], 1.0))
    what = "mu is 8: mu c is added."
    _add(result, PENALTY, "easy", what, ([0.5], [0.25], 8.0))
    what = "mu is 1000, as in ARCSim, I-Cloth and XRTailor, with violations of about 1 mm."
    c = [2.0**-10, 3.0 * 2.0**-12, -(2.0**-11)]
    _add(result, PENALTY, "medium", what, ([0.0, 0.25, 0.75], c, 1000.0))
    what = "mu is 2^-10: l hardly changes."
    _add(result, PENALTY, "medium", what, ([1.0, 2.0], [0.5, -0.5], 2.0**-10))
    what = "mu is 2^60, with violations of 2^-40 m."
    _add(result, PENALTY, "hard", what, ([0.0, 2.0**20], [2.0**-40, -(2.0**-41)], 2.0**60))
    what = "mu is 2^-60: a large l stays as it is, and an l of 0 becomes tiny."
    _add(result, PENALTY, "hard", what, ([3.0, 0.0], [1.0, 1.0], 2.0**-60))
    what = "mu is 2^30, and multipliers are huge: they are not cut off at a largest value."
    _add(result, PENALTY, "hard", what, ([2.0**60, 0.0], [2.0**10, 2.0**20], 2.0**30))


def _kinks(result: CaseList) -> None:
    above, below = 1.0 + 2.0**-23, 1.0 - 2.0**-24
    what = "c is negative; l + mu c is exactly 0 for one impact and positive for the other."
    _add(result, KINK, "easy", what, ([3.0, 4.0], [-0.75, -0.75], 4.0))
    what = "l + mu c is 1, 0, and as near to 0 as a float32 next to 1 is to 1, on both sides."
    _add(result, KINK, "medium", what, ([2.0, 1.0, above, below], [-0.25] * 4, 4.0))
    third = 11184811.0 * 2.0**-25  # the float32 next to 1/3
    what = "mu c is rounded before it is added, or not, with a fused operation: both are right."
    _add(result, KINK, "hard", what, ([1.0, 1.0], [-third, third], 3.0))


def _signs(result: CaseList) -> None:
    what = "A violation, c > 0, makes l larger."
    _add(result, SIGN, "easy", what, ([1.0], [0.5], 4.0))
    what = "A constraint that is satisfied, c < 0, makes l smaller."
    _add(result, SIGN, "medium", what, ([4.0], [-0.5], 4.0))
    what = "c is 0: l does not change."
    _add(result, SIGN, "hard", what, ([0.0, 1.0, 5.0], [0.0, 0.0, -0.0], 4.0))


def _tiny(result: CaseList) -> None:
    what = "A violation of 2^-40 m changes l."
    _add(result, ABSOLUTE, "easy", what, ([0.0], [2.0**-40], 4.0))
    what = "A multiplier of 2^-60 does not vanish."
    _add(result, ABSOLUTE, "medium", what, ([2.0**-60], [-(2.0**-64)], 4.0))
    what = "The smallest float32, which a port may flush to zero, but not to anything else."
    _add(
        result, ABSOLUTE, "hard", what, ([2.0**-149, 0.0, 1.0], [0.0, 2.0**-149, 0.5], 1.0), FLUSHED
    )


def _long(result: CaseList) -> None:
    random = Random(901)
    multipliers = [dyadic(random, 0.0, 4.0, 6) for _ in range(65)]
    c = [dyadic(random, -1.0, 1.0, 8) for _ in range(65)]
    what = "65 impacts: more than the threads of one or two warps."
    _add(result, f"{CLAMP} {PENALTY} {SIGN}", "medium", what, (multipliers, c, 3.0))
    multipliers = [0.0 if random.random() < 0.5 else m for m in multipliers]
    what = "65 impacts, about half of which have l = 0, as after the first update."
    _add(result, f"{CLAMP} {PENALTY} {SIGN}", "medium", what, (multipliers, c, 100.0))
    multipliers = [dyadic(random, 0.0, 4.0, 6) for _ in range(1100)]
    c = [dyadic(random, -1.0, 1.0, 8) for _ in range(1100)]
    what = "1100 impacts: more than the threads of the largest block."
    _add(result, f"{CLAMP} {PENALTY} {SIGN}", "hard", what, (multipliers, c, 3.0))


def _digits(result: CaseList) -> None:
    random = Random(902)
    for number, name in enumerate(("multipliers", "constraints", "digits of the penalty")):
        numbers = [[0.5, 1.0, 0.25], [0.5, -0.25, 0.125], [3.0]]
        numbers[number] = [a + dyadic(random, 0.0, 2.0**-10, 48) for a in numbers[number]]
        multipliers, c, (penalty,) = numbers
        what = f"The {name} are beyond float32, and a port of float64 keeps them."
        _add(result, DIGITS, "medium", what, (multipliers, c, penalty), dtypes=("f8",))
