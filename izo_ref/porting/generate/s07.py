"""Cases of stage S7: the augmented Lagrangian of a zone and its gradient at a point."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from izo_ref.porting.cases import DTYPES, Case
from izo_ref.porting.generate.expected import CaseList, exact_inputs, values
from izo_ref.porting.generate.small_zones import (
    Inputs,
    dyadic,
    pair_weights,
    random_zone,
    with_all_digits,
    zone_above_face,
)
from izo_ref.porting.reference.zone import (
    Evaluation,
    constraints,
    curvatures,
    displacements,
    lagrangian,
    vectors,
    zone_of,
)

NODES = "node-order"
MASSES = "mass-weighting"
SIGN = "constraint-sign"
SUMS = "lost-sum"
KINK = "kink"
PENALTY = "penalty-scaling"
CLAMP = "multipliers-not-clamped"
ABSOLUTE = "absolute-tolerance"
DIGITS = "float32-coordinates"


def cases() -> list[Case]:
    """Return the cases of stage S7."""
    result = CaseList("S7")
    for part in (_nodes, _masses, _signs, _sums, _kinks, _penalties, _clamped, _tiny, _digits):
        part(result)
    return result


def evaluate(inputs: Inputs) -> Evaluation:
    """Return the augmented Lagrangian of a case."""
    zone, x = zone_of(inputs), vectors(inputs["positions"])
    moved, c, w = displacements(zone, x), constraints(zone, x), curvatures(zone)
    return lagrangian(zone, moved, c, inputs["multipliers"], inputs["penalty"], w)


def with_multipliers(inputs: Inputs, multipliers: Sequence[float], penalty: float) -> Inputs:
    """Return the inputs of a zone with multipliers and a penalty."""
    return {**inputs, "multipliers": list(multipliers), "penalty": penalty}


def random_multipliers(seed: int, count: int, size: float) -> list[float]:
    """Return multipliers between 0 and `size`, a power of 2."""
    random = Random(seed)
    return [size * dyadic(random, 0.0, 1.0, 6) for _ in range(count)]


def _add(
    result: CaseList,
    flags: str,
    grade: str,
    what: str,
    inputs: Inputs,
    dtypes: tuple[str, ...] = DTYPES,
) -> None:
    """Add a case with what the reference computes; without float32, all inputs are exact."""
    found = evaluate(inputs if "f4" in dtypes else exact_inputs(inputs))
    expected = {
        "value": values([found.value]),
        "gradient": values([a for vector in found.gradient for a in vector]),
    }
    result.add(flags.split()[0], flags, grade, what, inputs, expected, dtypes)


def _nodes(result: CaseList) -> None:
    inputs = with_multipliers(zone_above_face([0.125]), [1.0], 4.0)
    what = "A vertex above a face: the impact pushes the vertex up, and the corners down."
    _add(result, NODES, "easy", what, inputs)
    inputs = random_zone(Random(701), 1, 4) | {"nodes": [2, 0, 3, 1]}
    inputs["weights"] = pair_weights(Random(702), True)
    what = "Two edges whose ends are not in ascending order, with four different weights."
    _add(result, NODES, "medium", what, with_multipliers(inputs, [8.0], 8.0))
    inputs = with_multipliers(random_zone(Random(703), 6, 7), random_multipliers(704, 6, 4.0), 8.0)
    what = "Six pairs of both kinds share seven vertices in different places."
    _add(result, NODES, "hard", what, inputs)


def _masses(result: CaseList) -> None:
    def zone(seed: int, masses: tuple[float, ...], pinned: tuple[int, ...] = ()) -> Inputs:
        inputs = random_zone(Random(seed), 2, 6, masses=masses, pinned=pinned)
        return with_multipliers(inputs, [1.0, 0.5], 2.0)

    what = "Masses of 2 kg: g is divided by their sum, but the terms of the impacts are not."
    _add(result, MASSES, "easy", what, zone(711, (2.0,)))
    what = "Masses of 1, 2 and 4 kg."
    _add(result, MASSES, "medium", what, zone(712, (1.0, 2.0, 4.0)))
    what = "Two vertices are pinned, and masses of 2^30 kg are written for them."
    inputs = zone(713, (1.0, 0.5), (1, 4))
    inputs["masses"] = [2.0**30 if i in (1, 4) else m for i, m in enumerate(inputs["masses"])]
    _add(result, f"{MASSES} pinned-masses", "medium", what, inputs)
    what = "The masses differ by a factor of 2^30: impacts push light and heavy vertices alike."
    _add(result, MASSES, "hard", what, zone(714, (2.0**15, 2.0**-15, 1.0)))


def _signs(result: CaseList) -> None:
    what = "The vertex is behind the face: a step against the gradient moves it out."
    _add(result, SIGN, "easy", what, with_multipliers(zone_above_face([0.5]), [0.0], 2.0))
    what = "The vertex is above the face, but a multiplier holds it."
    _add(result, SIGN, "medium", what, with_multipliers(zone_above_face([-0.25]), [4.0], 2.0))
    what = "Eight pairs with normals in all directions and both signs of c."
    inputs = with_multipliers(random_zone(Random(721), 8, 10), random_multipliers(722, 8, 2.0), 4.0)
    _add(result, SIGN, "hard", what, inputs)


def _sums(result: CaseList) -> None:
    def zone(seed: int, impacts: int, vertices: int) -> Inputs:
        inputs = random_zone(Random(seed), impacts, vertices, masses=(1.0, 0.5), hub=True)
        return with_multipliers(inputs, random_multipliers(seed + 1, impacts, 1.0), 2.0)

    what = "Two impacts push the same vertex: both terms enter its gradient."
    _add(result, SUMS, "easy", what, zone(731, 2, 7))
    what = "Five vertices above one face: each of its corners is pushed five times."
    inputs = zone_above_face([0.25, 0.5, 0.125, 0.375, 0.0625], masses=(1.0, 2.0, 1.0, 4.0, 0.5))
    _add(result, SUMS, "medium", what, with_multipliers(inputs, [1.0, 0.0, 2.0, 0.5, 0.25], 4.0))
    what = "One vertex is in all of twelve impacts."
    _add(result, SUMS, "medium", what, zone(733, 12, 12))
    what = "One vertex is in all of 240 impacts on 20 vertices: sums without atomics lose terms."
    _add(result, SUMS, "hard", what, zone(735, 240, 20))
    what = "1100 impacts on 64 vertices: more than threads of the largest block."
    inputs = random_zone(Random(737), 1100, 64, masses=(1.0, 0.5))
    inputs = with_multipliers(inputs, random_multipliers(738, 1100, 1.0), 2.0)
    _add(result, SUMS, "hard", what, inputs)


def _kinks(result: CaseList) -> None:
    def add(grade: str, what: str, wanted: list[float], multipliers: list[float]) -> None:
        inputs = zone_above_face(wanted, masses=(1.0, 2.0, 0.5))
        _add(result, KINK, grade, what, with_multipliers(inputs, multipliers, 4.0))

    above, below = 1.0 + 2.0**-23, 1.0 - 2.0**-24  # the float32 next to 1 on each side
    what = "c is negative, but c + l / mu is positive: the impact is active."
    add("easy", what, [-0.25], [3.0])
    what = "c is negative, and c + l / mu too: only -l^2 / (2 mu) is left of the impact."
    add("easy", what, [-0.5], [1.0])
    what = "c + l / mu is exactly 0: nothing pushes, and -l^2 / (2 mu) stays."
    add("medium", what, [-0.25], [1.0])
    what = "c is exactly 0 and l is 0."
    add("medium", what, [0.0], [0.0])
    what = "c + l / mu is positive by one part in 2^20."
    add("medium", what, [-0.25], [1.0 + 2.0**-20])
    what = "c + l / mu is negative by one part in 2^20."
    add("hard", what, [-0.25], [1.0 - 2.0**-20])
    what = "Four impacts: on the kink, one float32 above it, one below it, and c = 0 with l > 0."
    add("hard", what, [-0.25, -0.25, -0.25, 0.0], [1.0, above, below, 1.0])
    what = "Eight impacts are exactly on the kink, each with another c."
    depths = [-(2.0**-k) for k in range(8)]
    add("hard", what, depths, [-4.0 * c for c in depths])


def _penalties(result: CaseList) -> None:
    def add(grade: str, what: str, seed: int, penalty: float, size: float) -> None:
        inputs = random_zone(Random(seed), 4, 8, masses=(1.0, 2.0))
        multipliers = random_multipliers(seed + 1, 4, size)
        _add(result, PENALTY, grade, what, with_multipliers(inputs, multipliers, penalty))

    add("easy", "mu is 1: the forms c + l / mu and c + l mu are equal.", 741, 1.0, 1.0)
    add("easy", "mu is 2.", 743, 2.0, 1.0)
    add("medium", "mu is 1000, as in ARCSim, I-Cloth and XRTailor.", 745, 1000.0, 64.0)
    what = "mu is 2^-7, and multipliers are large: most of the value cancels."
    add("medium", what, 747, 2.0**-7, 4.0)
    add("hard", "mu is 2^20, and the multipliers are as large.", 749, 2.0**20, 2.0**20)
    add(
        "hard", "mu is 2^40: nothing overflows, even with floats of 32 bits.", 751, 2.0**40, 2.0**30
    )


def _clamped(result: CaseList) -> None:
    def add(grade: str, what: str, wanted: list[float], multipliers: list[float]) -> None:
        _add(
            result, CLAMP, grade, what, with_multipliers(zone_above_face(wanted), multipliers, 8.0)
        )

    what = "l is 0 and c is negative: the impact does not pull."
    add("easy", what, [-0.5], [0.0])
    what = "l + mu c is negative although l is positive."
    add("medium", what, [-0.5], [1.0])
    what = "Three impacts, of which one pushes; the two others must not pull."
    add("medium", what, [-0.5, 0.25, -0.125], [0.0, 0.0, 0.5])
    what = "All multipliers are 0, as at the start, and no constraint is violated: L is g."
    add("medium", what, [-0.25, -0.5, -1.0, 0.0], [0.0, 0.0, 0.0, 0.0])
    what = "Large multipliers of impacts that are far apart: they change L, but not its gradient."
    add("hard", what, [-16.0, -8.0, 0.125], [64.0, 32.0, 0.5])


def _tiny(result: CaseList) -> None:
    inputs = zone_above_face([2.0**-31], 2.0**-20, fall=2.0**-24)
    what = "A violation of 5e-10 m, as at the end of a solve: it is no less active."
    _add(result, ABSOLUTE, "easy", what, with_multipliers(inputs, [0.0], 2.0**20))
    inputs = zone_above_face([2.0**-34, -(2.0**-34)], 2.0**-13, fall=2.0**-20)
    what = "Violations of 6e-11 m and of the opposite sign, one with a small multiplier."
    _add(result, ABSOLUTE, "medium", what, with_multipliers(inputs, [2.0**-24, 0.0], 2.0**20))
    inputs = random_zone(Random(761), 3, 8, size=2.0**-30)
    what = "A zone of a nanometre: all lengths are below 1e-9 m."
    inputs = with_multipliers(inputs, [0.0, 2.0**-30, 2.0**-29], 4.0)
    _add(result, ABSOLUTE, "hard", what, inputs)


def _digits(result: CaseList) -> None:
    inputs = random_zone(Random(771), 4, 8, masses=(1.0, 0.5))
    inputs = with_multipliers(inputs, [0.75, 0.5, 0.0, 0.625], 3.0)
    what = "All inputs have the digits of a float64; none of them may be kept in float32."
    _add(result, DIGITS, "medium", what, with_all_digits(Random(772), inputs), ("f8",))
