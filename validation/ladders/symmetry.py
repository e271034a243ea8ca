"""Symmetries: a step that is written in another way has the same answer.

Some answers have to have the same bits, because docs/limits and docs/porting-numbers promise it.
The others are rounded differently. In a light step, whose impacts are at most as deep as an edge is
long, rounding stays rounding: within LIGHT_TOLERANCE of the largest move. A deep step, or a
regular one with many impacts at the same time, may take another way, because rounding decides which
impact is first. Its answer is then another local optimum that is about as good; what is measured is
its objective.
"""

import time
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from validation.ladders import symmetry_of_pairs, symmetry_of_zones
from validation.ladders.ladder import (
    ANOTHER,
    RIGHT,
    SAYS_SO,
    VERDICTS,
    WRONG,
    Ladder,
    Outcome,
    Rung,
)
from validation.ladders.twins import Compared, Symmetry, by_twin, resolved
from validation.ladders.twins_rounded import ROUNDED, beside, turned
from validation.ladders.twins_same_bits import SAME_BITS
from validation.scenes.crossing import Step, crossing_sheets, regular_layers

FAMILY = "symmetry"
SEED = 20240607
LIGHT_TOLERANCE = 1e-9  # the relative error that the project promises for zones
# Largest difference of objectives of two ways, relative to the first one. Docs say that the other
# answer is "as good"; the largest difference measured is in the notes of the rows.
OBJECTIVE_TOLERANCE = 0.1
STEPS = {"sample": 12, "light": 150, "deep": 30, "ties": 20}
DEPTHS = (0.03125, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 256.0)
DISTANCES = (4.0, 16.0, 2.0**6, 2.0**9, 2.0**12, 2.0**16, 2.0**20, 2.0**24, 2.0**28)
PROMISED = "docs promise the same bits"
MEASURED = "the same bits are not promised, but found"
KINDS = {
    "sample": "steps of crossing sheets, most of them light",
    "light": "steps with impacts of 0.03 to 1 edge lengths",
    "deep": "steps with impacts of 1 to 64 edge lengths",
    "ties": "steps of regular sheets, in which many impacts happen at the same time",
}


def draw_step(kind: str, number: int) -> tuple[np.random.Generator, Step]:
    """Draw a step of a kind of KINDS, and return the generator too."""
    rng = np.random.default_rng([SEED, sorted(KINDS).index(kind), number])
    if kind == "ties" or (kind == "sample" and number % 6 == 5):
        return rng, regular_layers(rng)
    low, high = (0.0, 3.0) if kind == "deep" else (-2.5, 0.0)
    return rng, crossing_sheets(rng, 4.0 ** rng.uniform(low, high))


def judge_symmetry(
    symmetry: Symmetry,
    steps: Sequence[tuple[np.random.Generator, Step]],
    verdict: Callable[[Sequence[Compared]], str],
    note: str,
) -> list[Outcome]:
    """Resolve steps and their twins, and compare the answers.

    Args:
        symmetry: What is done to each step.
        steps: Steps, each with the generator that goes on to draw the twin.
        verdict: Judges all comparisons.
        note: What is promised.

    Returns:
        One outcome: its error is the largest deviation, over the largest move.
    """
    begin = time.perf_counter()
    found = []
    for rng, step in steps:
        found.append(symmetry(rng, step, resolved(step)))
    seconds = (time.perf_counter() - begin) / len(found)
    other = sum(not one.same_way for one in found)
    unequal = sum(one.statuses[0] != one.statuses[1] for one in found)
    far = sum(one.deviation > LIGHT_TOLERANCE for one in found)
    objectives = [one.objective for one in found]
    note = (
        f"{len(found)} steps; {other} with other impacts or iterations; {far} deviate by more than "
        f"{LIGHT_TOLERANCE:.0e}; {unequal} with another status; objectives differ by "
        f"{min(objectives):+.1e} to {max(objectives):+.1e}; {note}"
    )
    statuses = sorted({status for one in found for status in one.statuses})
    error = max(one.deviation for one in found)
    return [Outcome(verdict(found), ", ".join(statuses), error=error, seconds=seconds, note=note)]


def same_bits(found: Sequence[Compared]) -> str:
    """Judge: all bits are equal, and the statuses too."""
    equal = all(one.deviation == 0.0 and one.statuses[0] == one.statuses[1] for one in found)
    return RIGHT if equal else WRONG


def same_up_to_rounding(found: Sequence[Compared]) -> str:
    """Judge: positions are equal within LIGHT_TOLERANCE; another status says that they are not.

    No page promises equal positions: both answers are certified, and the path to them may branch.
    """
    far = [one for one in found if one.deviation > LIGHT_TOLERANCE]
    if all(one.statuses[0] == one.statuses[1] for one in found) and not far:
        return RIGHT
    return SAYS_SO if all(one.statuses[1] != "FREE" for one in far) else ANOTHER


def as_good(found: Sequence[Compared]) -> str:
    """Judge: the objectives are equal within OBJECTIVE_TOLERANCE, or a status is not FREE.

    No page promises equal objectives, so FREE is not wrong where they differ.
    """
    worse = [one for one in found if abs(one.objective) > OBJECTIVE_TOLERANCE]
    if all(one.statuses == ("FREE", "FREE") for one in found) and not worse:
        return RIGHT
    return SAYS_SO if all(one.statuses != ("FREE", "FREE") for one in worse) else ANOTHER


Run: TypeAlias = Callable[[Rung], list[Outcome]]
Verdict: TypeAlias = Callable[[Sequence[Compared]], str]


def _kinds(kind: str, names: dict[str, Symmetry], verdict: Verdict, note: str) -> Run:
    def run(rung: Rung) -> list[Outcome]:
        steps = [draw_step(kind, number) for number in range(STEPS[kind])]
        own = MEASURED if rung == "numbered anew" else note
        return judge_symmetry(names[str(rung)], steps, verdict, own)

    return run


def _sample(rung: Rung) -> list[Outcome]:
    """Judge a few steps; regular ones by their objective alone."""
    name = str(rung)
    if name in SAME_BITS:
        return _kinds("sample", SAME_BITS, same_bits, PROMISED)(rung)

    def verdict(found: Sequence[Compared]) -> str:
        light = [one for number, one in enumerate(found) if number % 6 != 5]
        verdicts = same_up_to_rounding(light), as_good(found)
        return max(verdicts, key=VERDICTS.index)

    return _kinds("sample", ROUNDED, verdict, "regular steps count by objective alone")(rung)


def _depth(rung: Rung) -> list[Outcome]:
    depth = float(rung)
    steps = []
    for number in range(20):
        rng = np.random.default_rng([SEED, 99, number])
        steps.append((rng, crossing_sheets(rng, depth)))
    verdict = same_up_to_rounding if depth <= 1.0 else as_good
    return judge_symmetry(by_twin(turned), steps, verdict, "beyond one edge length, by objective")


def _distance(rung: Rung) -> list[Outcome]:
    steps = [draw_step("light", 1000 + number) for number in range(20)]
    return _beside(steps, float(rung))


def _depth_beside(rung: Rung) -> list[Outcome]:
    steps = []
    for number in range(20):
        rng = np.random.default_rng([SEED, 98, number])
        steps.append((rng, crossing_sheets(rng, float(rung))))
    return _beside(steps, 64.0)


def _beside(steps: Sequence[tuple[np.random.Generator, Step]], distance: float) -> list[Outcome]:
    symmetry = by_twin(lambda rng, step: beside(rng, step, distance))
    note = "that zones far apart do not depend on each other is not promised"
    return judge_symmetry(symmetry, steps, as_good, note)


def _ladder(
    name: str,
    sentence: str,
    rungs: Sequence[Rung],
    run: Run,
    quick: Sequence[Rung] = (),
    unit: str = "kind",
    wanted: Rung | None = None,
) -> Ladder:
    wanted = rungs[-1] if wanted is None else wanted
    return Ladder(FAMILY, name, sentence, unit, rungs, run, quick, 300.0, wanted)


def _steps_of(kind: str) -> list[Ladder]:
    bits, rounded = tuple(SAME_BITS), tuple(ROUNDED)
    exact = (
        f"{STEPS[kind]} {KINDS[kind]}, written in another way. The positions have the same bits."
    )
    light = (
        f"{STEPS[kind]} {KINDS[kind]}, written in another way. The positions are the same, within "
        f"{LIGHT_TOLERANCE:.0e} of the largest move."
    )
    good = (
        f"{STEPS[kind]} {KINDS[kind]}, written in another way. Rounding decides which impact is "
        f"first, so the answer may be another local optimum. Its objective is within "
        f"{100.0 * OBJECTIVE_TOLERANCE:.0f} % of the first one."
    )
    verdict, sentence = (same_up_to_rounding, light) if kind == "light" else (as_good, good)
    return [
        _ladder(f"same bits, {kind}", exact, bits, _kinds(kind, SAME_BITS, same_bits, PROMISED)),
        _ladder(f"rounded, {kind}", sentence, rounded, _kinds(kind, ROUNDED, verdict, "")),
    ]


LADDERS: list[Ladder] = [
    _ladder(
        "sample",
        f"{STEPS['sample']} steps of crossing sheets, written in another way. The positions have "
        f"the same bits, or are the same within {LIGHT_TOLERANCE:.0e} of the largest move.",
        (*SAME_BITS, *ROUNDED),
        _sample,
        (*SAME_BITS, *ROUNDED),
    ),
    *(ladder for kind in ("light", "deep", "ties") for ladder in _steps_of(kind)),
    _ladder(
        "turned, by depth",
        "Sheets go through each other, ever deeper, and the step is turned by the angles of the "
        "triangle 3-4-5, which is exact. The error is the largest deviation of the answer. Up to "
        f"one edge length it is below {LIGHT_TOLERANCE:.0e}; beyond, the objectives are as good.",
        DEPTHS,
        _depth,
        unit="depth / edge length",
    ),
    _ladder(
        "another step far away",
        "A light step is resolved alone, and together with another light step that is ever farther "
        "away. The error is the largest deviation of its answer. Its objective is as good.",
        DISTANCES,
        _distance,
        unit="distance / size",
    ),
    _ladder(
        "another step beside it, by depth",
        "An ever deeper step is resolved alone, and together with a light step 64 m away. The "
        "error is the largest deviation of its answer. Its objective is as good. One decision is "
        "taken for the whole scene: whether a round of new normals pays.",
        DEPTHS,
        _depth_beside,
        quick=(32.0,),
        unit="depth / edge length",
    ),
    *symmetry_of_zones.LADDERS,
    *symmetry_of_pairs.LADDERS,
]
