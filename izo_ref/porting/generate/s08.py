"""Cases of stage S8: the line searches."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import Any

from izo_ref.porting.cases import Case
from izo_ref.porting.generate.expected import CaseList
from izo_ref.porting.generate.lines import (
    BACKTRACKING,
    EXACT,
    WOLFE,
    add_search,
    case_line_of,
    downhill,
    minimum,
    with_search,
)
from izo_ref.porting.generate.s07 import random_multipliers, with_multipliers
from izo_ref.porting.generate.small_zones import (
    Inputs,
    float32,
    random_zone,
    with_all_digits,
    zone_above_face,
)
from izo_ref.porting.reference.line_search import exact

OF_ARMIJO = "armijo"
OF_WOLFE = "wolfe-gradient"
OF_EXACT = "exact-search"
NO_STEP = "no-step"
CHANGE = "change-by-difference"
ABSOLUTE = "absolute-tolerance"
DIGITS = "float32-coordinates"
SEVENTH = float32(0.7)


def cases() -> list[Case]:
    """Return the cases of stage S8."""
    result = CaseList("S8")
    for part in (_armijo, _more_armijo, _exact, _wolfe, _no_steps, _changes, _near_minimum):
        part(result)
    _tiny(result)
    _digits(result)
    return result


def _pushed(penalty: float = 4.0) -> Inputs:
    """Return a vertex behind a face, and one that is free above it."""
    zone = zone_above_face([0.25, -0.5], masses=(1.0, 2.0, 1.0))
    return with_multipliers(zone, [1.0, 0.0], penalty)


def _held() -> Inputs:
    """Return a vertex behind a face that its impact pushes all the way to the minimum."""
    return with_multipliers(zone_above_face([0.5], masses=(1.0, 2.0)), [8.0], 4.0)


def _falling(penalty: float) -> Inputs:
    """Return a vertex above a face that falls toward its proposed position, behind the face."""
    return with_multipliers(zone_above_face([-0.25], fall=1.0), [0.0], penalty)


def _tangle(seed: int, impacts: int, vertices: int, penalty: float = 4.0, **changes: Any) -> Inputs:
    """Return a random zone with random multipliers."""
    zone = random_zone(Random(seed), impacts, vertices, **changes)
    return with_multipliers(zone, random_multipliers(seed + 1, impacts, 1.0), penalty)


def _best(inputs: Inputs, direction: Sequence[float], factor: float) -> float:
    """Return `factor` times the step to the minimum along the line, as a float32."""
    line = case_line_of({**inputs, "direction": list(direction)})
    return float32(factor * float(exact(line).step))


def _armijo(result: CaseList) -> None:
    def add(grade: str, what: str, inputs: Inputs, **changes: float) -> None:
        p = downhill(inputs)
        add_search(result, OF_ARMIJO, grade, what, with_search(inputs, p, BACKTRACKING, **changes))

    inputs = _pushed()
    add("easy", "The first step is accepted.", inputs, first=0.125)
    add("easy", "The first step is too long, and is halved until phi falls.", inputs, first=64.0)
    first = _best(inputs, downhill(inputs), 1.5)
    what = "c_1 is 2^-13, about 1e-4: a step half as long again as the best one is accepted."
    add("medium", what, inputs, first=first)
    what = "c_1 is 0.5, as in XRTailor: the same step is too long."
    add("medium", what, inputs, first=first, armijo=0.5)
    what = "c_1 is 0.5 and steps shrink by 0.7, as in XRTailor."
    add("medium", what, inputs, first=first, armijo=0.5, shrink=SEVENTH)
    what = "The first step is far too short. It is accepted all the same, and does not grow."
    add("medium", what, inputs, first=2.0**-20)


def _more_armijo(result: CaseList) -> None:
    def add(grade: str, what: str, inputs: Inputs, p: Sequence[float], **changes: float) -> None:
        add_search(result, OF_ARMIJO, grade, what, with_search(inputs, p, BACKTRACKING, **changes))

    inputs = _pushed()
    p = downhill(inputs, (16.0,))
    what = "p is 16 times the steepest direction, so the slope is not -|p|^2."
    add("medium", what, inputs, p, first=_best(inputs, p, 0.75), armijo=0.25)
    inputs = _falling(64.0)
    what = "An impact that is not active at x stops the vertex on its way: phi has a kink."
    add("medium", what, inputs, downhill(inputs), first=2.0, armijo=0.25)
    inputs = _tangle(801, 8, 10)
    p = downhill(inputs, (1.0, 2.0, 0.5))
    what = "Eight impacts become active or inactive along a direction that is not the steepest."
    add("hard", what, inputs, p, first=4.0, armijo=0.5, shrink=SEVENTH)
    what = "A first step of 2^30 is halved more than thirty times."
    add("hard", what, inputs, p, first=2.0**30)
    origin = (512.0, -512.0, 256.0)
    inputs = _tangle(803, 4, 9, masses=(1.0, 2.0**-12), pinned=(2, 5), origin=origin)
    what = "Masses differ by 2^12, two vertices are pinned, and the origin is 700 m away."
    add("hard", what, inputs, downhill(inputs), first=16.0, armijo=0.25)


def _exact(result: CaseList) -> None:
    def add(
        grade: str, what: str, inputs: Inputs, factors: Sequence[float] = (1.0,), first: float = 1.0
    ) -> None:
        p = downhill(inputs, factors)
        add_search(result, OF_EXACT, grade, what, with_search(inputs, p, EXACT, first=first))

    what = "No impact is active: phi is a parabola."
    add("easy", what, with_multipliers(zone_above_face([-0.5]), [0.0], 4.0))
    what = "The impact is active before and after the minimum."
    add("easy", what, with_multipliers(zone_above_face([0.5]), [8.0], 4.0))
    what = "The impact becomes inactive before the minimum: Newton's step from x is too short."
    inputs = with_multipliers(zone_above_face([0.0625], fall=-1.0), [0.0], 64.0)
    add("medium", what, inputs)
    what = "The impact becomes active before the minimum: Newton's step from x is too long."
    add("medium", what, _falling(64.0))
    what = "p is short: the best step is about 177."
    add("medium", what, _pushed(), (2.0**-10,))
    what = "p is long: the best step is about 2^-23, and the search begins at 1."
    add("hard", what, _pushed(), (2.0**20,))
    what = "Twelve impacts on twelve vertices: many kinks, on both sides of the minimum."
    add("hard", what, _tangle(811, 12, 12, 8.0), (1.0, 4.0), 64.0)
    what = "mu is 2^20, so phi'' is a million times larger behind the kink."
    add("hard", what, _falling(2.0**20), (1.0,), 2.0)


def _wolfe(result: CaseList) -> None:
    def add(grade: str, what: str, inputs: Inputs, factor: float, **changes: float) -> None:
        p = downhill(inputs)
        first = _best(inputs, p, factor)
        inputs = with_search(inputs, p, WOLFE, first=first, **changes)
        add_search(result, OF_WOLFE, grade, what, inputs)

    what = "The first step satisfies both conditions, and others do, too."
    add("easy", what, _held(), 1.0)
    what = "The first step is too short: Armijo's condition alone would accept it."
    add("easy", what, _held(), 0.25)
    what = "The first step is too long: phi rises there, and phi' >= c_2 phi'(0) would accept it."
    add("medium", what, _held(), 1.75)
    what = "phi' is nearly 0 in the middle of the first step, but not at its end."
    add("medium", what, _held(), 1.9375)
    what = "The first step is shorter than the best one by a factor of 2^20."
    add("medium", what, _held(), 2.0**-20)
    what = "c_1 is 0.4375 and c_2 is 0.9375: Armijo's condition alone limits the steps above."
    add("hard", what, _held(), 1.75, armijo=0.4375, wolfe=0.9375)
    what = "c_2 is 2^-6 and twelve impacts have their kinks: the steps that do are few."
    add("hard", what, _tangle(821, 12, 12, 8.0), 2.0, wolfe=2.0**-6)
    what = (
        "mu is 2^12: phi' rises steeply behind the kink, and the middle of the step is before it."
    )
    add("hard", what, _falling(2.0**12), 1.5)
    what = "c_2 is 2^-4, and |phi'| at the first step is 5/64 of |phi'(0)|: not small enough."
    add("medium", what, _held(), 1.078125, wolfe=2.0**-4)
    what = "c_2 is 1/4: phi' is small enough from 0.25 to 0.7 of the first step, not at its end."
    add("easy", what, _held(), 3.71875, wolfe=0.25)


def _no_steps(result: CaseList) -> None:
    def add(grade: str, what: str, p: Sequence[float], search: str, **changes: float) -> None:
        add_search(result, NO_STEP, grade, what, with_search(inputs, p, search, **changes))

    inputs = _pushed()
    uphill = downhill(inputs, (-1.0,))
    what = "p points uphill: no step satisfies Armijo's condition, and the answer is 0."
    add("easy", what, uphill, BACKTRACKING, smallest_step=3.0 * 2.0**-12)
    what = "p points uphill: the minimum of phi is at a negative step."
    add("medium", what, uphill, EXACT)
    add("medium", "p points uphill.", uphill, WOLFE)
    what = "The step that would be accepted is below the smallest one."
    add("medium", what, downhill(inputs), BACKTRACKING, first=64.0, smallest_step=1.5)
    sideways = [1.0 if i % 3 == 0 else 0.0 for i in range(len(uphill))]
    what = "phi'(0) is exactly 0: the inequality is strict, so no step is accepted."
    add("hard", what, sideways, BACKTRACKING, smallest_step=3.0 * 2.0**-8)
    what = "phi'(0) is exactly 0, and the minimum is at 0."
    add("hard", what, sideways, EXACT)
    nothing = [0.0 for _ in uphill]
    what = "p is 0, as at a minimum: the change is 0, and the inequality is strict."
    add("hard", what, nothing, BACKTRACKING, smallest_step=3.0 * 2.0**-8)
    what = "p is 0, as at a minimum: any step will do, but Newton's is 0 / 0."
    add("hard", what, nothing, EXACT)


def _changes(result: CaseList) -> None:
    def add(grade: str, what: str, p: Sequence[float], search: str, **changes: float) -> None:
        inputs_of_case = with_search(inputs, p, search, **changes)
        add_search(result, CHANGE, grade, what, inputs_of_case)

    inputs = _pushed()
    what = "The first step is 2^-46: the change is about 1e-13 m^2, which a difference would lose."
    small = {"first": 2.0**-46, "smallest_step": 2.0**-60}
    add("easy", what, downhill(inputs), BACKTRACKING, **small)
    zone = zone_above_face([-0.5, -8.0, -0.5], fall=2.0**-20, masses=(1.0, 2.0, 4.0))
    inputs = with_multipliers(zone, [0.0, 28.0, 0.0], 4.0)
    p = [a if i < 3 else 0.0 for i, a in enumerate(downhill(inputs))]
    what = "A large multiplier of an impact that is apart: L is -98, and the change is 1e-13."
    add("medium", what, p, EXACT)
    add("medium", f"{what[:-1]}, by backtracking from a step of 16.", p, BACKTRACKING, first=16.0)
    inputs["proposed"] = [a - 8.0 if i == 6 else a for i, a in enumerate(inputs["proposed"])]
    what = "One vertex is 8 m away from its proposed position and does not move along p."
    add("hard", what, p, WOLFE, first=0.5)


def _near_minimum(result: CaseList) -> None:
    inputs = _tangle(831, 4, 9, 0.5)
    inputs = minimum(inputs, 40)
    p = downhill(inputs)
    first = _best(inputs, p, 4.0)
    what = "x is the minimum of L to seven digits: what is left to gain is 1e-14 of L."
    add_search(result, CHANGE, "hard", what, with_search(inputs, p, EXACT, first=first))
    what = f"{what[:-1]}. Backtracking begins at four times the best step."
    searched = with_search(inputs, p, BACKTRACKING, first=first, armijo=0.25)
    add_search(result, CHANGE, "hard", what, searched)


def _tiny(result: CaseList) -> None:
    def add(grade: str, what: str, inputs: Inputs, search: str, factor: float) -> None:
        p = downhill(inputs)
        first = _best(inputs, p, factor)
        add_search(result, ABSOLUTE, grade, what, with_search(inputs, p, search, first=first))

    zone = zone_above_face([2.0**-24, -(2.0**-23)], 2.0**-20, fall=2.0**-21)
    what = "A violation of 6e-8 m, as at the end of a solve: it is no less active."
    add("easy", what, with_multipliers(zone, [0.0, 0.0], 64.0), EXACT, 1.0)
    for grade, seed, size, search in (
        ("medium", 841, 2.0**-30, EXACT),
        ("hard", 843, 2.0**-40, BACKTRACKING),
    ):
        zone = random_zone(Random(seed), 6, 8, size=size)
        inputs = with_multipliers(zone, random_multipliers(seed + 1, 6, size), 16.0)
        what = f"A zone of {size:.0e} m: the steps are those of a zone of any size."
        add(grade, what, inputs, search, 6.0)


def _digits(result: CaseList) -> None:
    random = Random(851)
    inputs = _tangle(852, 4, 8, 3.0, masses=(1.0, 0.5))
    what = "All inputs have the digits of a float64; none of them may be kept in float32."
    for search in (EXACT, BACKTRACKING):
        searched = with_search(inputs, downhill(inputs), search, shrink=SEVENTH)
        add_search(result, DIGITS, "medium", what, with_all_digits(random, searched), ("f8",))
        what = f"{what[:-1]}, not even the first step."
