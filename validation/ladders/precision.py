"""Precision: how many digits survive, stage by stage, and which decisions turn.

Each stage is compared with the exact answer for the very numbers that it was asked about: those of
the vectors of the porting kit, the same with noise on every number, or steps whose coordinates
were rounded. So an answer is wrong if it is farther from the exact one than floats may be. How many
digits are left of the answer without noise is in the notes.

Three stages are not asked here. S5, the zones, has integers alone. S12, whole steps, has ladders of
its own (`precision_of_steps.py`), and S13, bad input, is what the fuzzer asks.
"""

import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from izo_ref.porting.files import load_cases
from validation.ladders import precision_of_coordinates, precision_of_steps
from validation.ladders.judge_zone import judge_zone
from validation.ladders.ladder import RIGHT, SAYS_SO, WRONG, Ladder, Outcome, Rung
from validation.ladders.noise import UNIT, judged, measure_noise, shared_digits
from validation.ladders.stage_answer import Answer, Inputs
from validation.ladders.stage_calls import CALLS, IN_FLOAT32
from validation.ladders.stage_references import REFERENCES, Right
from validation.scenes.piles import stack_zone
from validation.scenes.zones import random_zone

FAMILY = "precision"
SEED = 20240609
SAMPLES = 100  # noisy copies of each case
FEWER_SAMPLES = 20  # of S1 and S10, whose references take 6 to 8 s for all vectors
NOISES = (UNIT, 1e-15, 1e-14, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
MASS_RATIOS = (1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e8, 1e10, 1e12)
SINGLE = ("newton", "lbfgs", "cg", "apgs")  # methods that offer float32
# Docs promise a relative gap of the objective of 1e-6; the error of positions is about its root.
SINGLE_TOLERANCE = 3e-3
BETWEEN = "S3 normal and weights"
SEARCH = "S8 line search"
FIRST_STEPS = "S10 first iterations"
ZONES = "S11 optimum of a zone"
SLOW = ("S1 candidate pairs", FIRST_STEPS)


def inputs_of(stage: str, dtype: str = "f8") -> list[Inputs]:
    """Return the inputs of the vectors of a stage that are valid for a type of floats."""
    cases = load_cases(stages=[stage.split()[0]])
    return [c.inputs for c in cases if c.verdict == "valid" and dtype in c.dtypes]


def samples_by_size(stage: str) -> int:
    """Return how many noisy copies of each case a ladder of growing noise asks for."""
    return 2 if stage in SLOW else 10


def judge_stage(stage: str, dtype: str, every: int = 1) -> list[Outcome]:
    """Ask a stage for the vectors, and compare the answers with the references.

    Args:
        stage: Name in `CALLS`.
        dtype: `f8` or `f4`.
        every: 1 for all vectors, n for each n-th.
    """
    call = CALLS[stage] if dtype == "f8" else partial(CALLS[stage], kind=np.float32)
    begin, wrong, worst, digits, first = time.perf_counter(), 0, 0.0, [], ""
    cases = inputs_of(stage, dtype)[::every]
    for inputs in cases:
        answer, right = call(inputs), REFERENCES[stage](inputs, dtype)
        ratio, sentence = judged(stage, answer, right)
        worst, wrong, first = max(worst, ratio), wrong + bool(sentence), first or sentence
        digits += _digits_of(answer, right)
    least, median = (min(digits), float(np.median(digits))) if digits else (np.inf, np.inf)
    note = (
        f"{len(cases)} cases: at least {least:.1f} digits, median {median:.1f}; the largest error "
        f"is {worst:.2g} of its bound"
        if digits
        else f"{len(cases)} cases of decisions only"
    )
    seconds = (time.perf_counter() - begin) / len(cases)
    verdict = WRONG if wrong else RIGHT
    error = 10.0**-least if digits else None
    return [Outcome(verdict, first or "right", error=error, seconds=seconds, note=note)]


def _digits_of(answer: Answer, right: Right) -> list[float]:
    """Return the digits of each output that is unique, and not zero throughout."""
    return [
        shared_digits((answer.numbers[name] - numbers)[None] / np.abs(numbers).max())
        for name, numbers in right.numbers.items()
        if name in answer.numbers
        and answer.numbers[name].shape == numbers.shape
        and name not in right.ranges
        and np.isfinite(right.bounds[name]).all()
        and numbers.any()
    ]


def judge_noise(stage: str, cases: Sequence[Inputs], count: int, size: float) -> list[Outcome]:
    """Ask a stage with noise on its inputs; `measure_noise` has the arguments."""
    begin = time.perf_counter()
    found = measure_noise(stage, cases, count, size, SEED)
    verdict = WRONG if found.wrong else RIGHT
    status = found.first_wrong or "right"
    note = (
        f"{found.questions} questions, {found.flips} other decisions than without noise, "
        f"{found.refused} refused, {found.unknown} without a known answer; shared digits "
        f"{found.digits:.1f}, median {found.median_digits:.1f}; by significantdigits "
        f"{found.estimated:.1f}; the largest error is {found.worst:.2g} of its bound"
    )
    seconds = (time.perf_counter() - begin) / max(found.questions, 1)
    return [Outcome(verdict, status, error=found.deviation, seconds=seconds, note=note)]


def _in_float64(rung: Rung) -> list[Outcome]:
    return judge_stage(str(rung), "f8")


def _in_float32(rung: Rung) -> list[Outcome]:
    return judge_stage(str(rung), "f4")


def _one_unit(rung: Rung) -> list[Outcome]:
    stage = str(rung)
    return judge_noise(stage, inputs_of(stage), FEWER_SAMPLES if stage in SLOW else SAMPLES, UNIT)


def _by_size(stage: str, rung: Rung) -> list[Outcome]:
    return judge_noise(stage, inputs_of(stage), samples_by_size(stage), float(rung))


def _zone_in_float32(method: str, rung: Rung) -> list[Outcome]:
    """Solve zones of one mass ratio in float32, and return the worst outcome."""
    outcomes = []
    for number in range(4):
        rng = np.random.default_rng([SEED, number])
        problem = (
            stack_zone(rng, 3, 3, float(rung)) if number % 2 else random_zone(rng, 8, float(rung))
        )
        outcomes += judge_zone(
            problem, tolerance=SINGLE_TOLERANCE, method=method, precision="float32"
        )
    return [max(outcomes, key=lambda o: ((RIGHT, SAYS_SO, WRONG).index(o.verdict), o.error or 0.0))]


def _ladder(
    name: str,
    sentence: str,
    unit: str,
    rungs: Sequence[Rung],
    run: Callable[[Rung], list[Outcome]],
    wanted: Rung | None = None,
    quick: Sequence[Rung] = (),
) -> Ladder:
    wanted = rungs[-1] if wanted is None else wanted
    return Ladder(FAMILY, name, sentence, unit, rungs, run, quick, 600.0, wanted)


LADDERS: list[Ladder] = [
    _ladder(
        "stages in float64",
        "Each stage is asked for the vectors of the porting kit. Its numbers are within the "
        "rounding bounds of references in 60 digits or rational numbers; times may be early, but "
        "never late.",
        "kind",
        tuple(CALLS),
        _in_float64,
        quick=("S4 selection", SEARCH, "S9 multiplier update", ZONES),
    ),
    _ladder(
        "stages in float32",
        "The stages of the augmented Lagrangian with arrays of float32, and candidate pairs from "
        "boxes of float32, for the vectors that float32 numbers hold. The answers are within the "
        "rounding bounds of float32.",
        "kind",
        IN_FLOAT32,
        _in_float32,
        quick=[stage for stage in IN_FLOAT32 if stage not in SLOW],
    ),
    _ladder(
        "one unit in the last place",
        f"Every number that goes into a stage changes by one unit in the last place or not, "
        f"{SAMPLES} times; in S1 and S10, whose references are slow, {FEWER_SAMPLES} times. "
        "Each answer is compared with the exact answer for the changed numbers. "
        "The error is the largest deviation from the answer without noise.",
        "kind",
        tuple(CALLS),
        _one_unit,
        quick=("S4 selection",),
    ),
    *(
        _ladder(
            f"noise on {stage}",
            "Every number that goes into the stage changes by up to a fraction of itself, "
            f"{samples_by_size(stage)} times. Each answer is compared with the exact answer for "
            "the changed numbers. The error is the largest deviation from the answer without "
            "noise.",
            "noise / number (0: one unit in the last place)",
            NOISES,
            partial(_by_size, stage),
        )
        for stage in ("S2 time of impact", BETWEEN, SEARCH, FIRST_STEPS, ZONES)
    ),
    *(
        _ladder(
            f"zones in float32 by {method}",
            "Zones of 8 to 20 impacts are solved with arrays of float32, and compared with the "
            f"exact optimum. Right is an error of at most {SINGLE_TOLERANCE:g} of the moves; the "
            "residuals, which are float64, say what is not reached.",
            "mass ratio",
            MASS_RATIOS,
            partial(_zone_in_float32, method),
            wanted=1.0,
        )
        for method in SINGLE
    ),
    *precision_of_steps.LADDERS,
    *precision_of_coordinates.LADDERS,
]
