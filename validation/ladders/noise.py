"""Change the inputs of a stage a little, many times, and count the digits of the output that stay.

Two measures of significant digits stand side by side. The obvious one is the number of decimal
digits that all samples share with the exact answer: -log10 of the largest deviation, relative to
the largest number of the output. The other one is that of the package `significantdigits`, which
estimates from the samples, with a confidence of 95 %, how many digits 95 % of all answers share.

Source: D. Sohier, P. de Oliveira Castro, F. Fevotte, B. Lathuiliere, E. Petit, O. Jamond,
Confidence intervals for stochastic arithmetic, ACM TOMS 47 (2021).
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyFloats, Floats
from izo_ref.porting.stages import FLOAT, STAGE
from validation.ladders.stage_answer import Answer, Inputs
from validation.ladders.stage_calls import CALLS
from validation.ladders.stage_references import REFERENCES, Right

MOST_DIGITS = 53.0 * math.log10(2.0)  # of a float64
UNIT = 0.0  # size of the noise that stands for one unit in the last place


class Noise(NamedTuple):
    """What noise does to the outputs of a stage.

    Attributes:
        questions: Inputs that were asked.
        unknown: Inputs without a known answer, at which any counts as right.
        wrong: Answers that are farther from the exact one than floats may be, or wrong decisions.
        refused: Zones that have a solution, very far away, and count as infeasible.
        flips: Decisions that differ from that of the input without noise.
        worst: Largest error over its bound; both for the input with noise.
        deviation: Largest deviation from the exact answer without noise, over the largest number.
        digits: Digits that all samples share with the exact answer, the least of all cases.
        median_digits: The same, the median of all cases.
        estimated: Digits by `significantdigits`, the least of all cases and numbers.
        first_wrong: The first wrong answer, in words.
    """

    questions: int
    unknown: int
    wrong: int
    refused: int
    flips: int
    worst: float
    deviation: float
    digits: float
    median_digits: float
    estimated: float
    first_wrong: str


def perturbed(rng: np.random.Generator, numbers: AnyFloats, size: float) -> AnyFloats:
    """Return numbers with noise.

    Args:
        rng: Draws the noise.
        numbers: Floats; infinities and NaN stay.
        size: Largest relative change; UNIT for a unit in the last place up, down, or no change. A
            zero changes as the largest number does.
    """
    finite = np.isfinite(numbers)
    largest = np.abs(numbers[finite]).max(initial=0.0)
    sizes = np.where(numbers == 0.0, largest, np.abs(numbers))
    if size == UNIT:
        changes = np.spacing(sizes) * rng.integers(-1, 2, numbers.shape)
    else:
        changes = size * sizes * rng.uniform(-1.0, 1.0, numbers.shape)
    return np.where(finite, numbers + np.where(finite, changes, 0.0), numbers)


def with_noise(rng: np.random.Generator, stage: str, inputs: Inputs, size: float) -> Inputs:
    """Return the inputs of a stage with noise on every float.

    What the stage relies on stays: a time is up to 1, the weights of an impact sum to zero (up to
    rounding), and pinned vertices are where they are proposed to be and do not move. A direction of
    zeros stays: units of 5e-324 would ask for a step that no float holds.
    """
    result = dict(inputs)
    for field in STAGE[stage.split()[0]].inputs:
        if field.kind == FLOAT and field.name in inputs:
            found = perturbed(rng, np.array(inputs[field.name], float), size)
            if field.name == "toi":
                found = np.clip(found, 0.0, 1.0)
            if field.name == "weights" and len(found) % 4 == 0:
                rows = found.reshape(-1, 4)
                rows[:, 0] = -rows[:, 1:].sum(axis=1)
            result[field.name] = found.tolist()
    if "positions" in result and "pinned" in result:
        pinned = np.array(result["pinned"], bool)[:, None]
        ends = [np.reshape(result[name], (-1, 3)) for name in ("proposed", "positions")]
        result["positions"] = np.where(pinned, *ends).ravel().tolist()
        if "direction" in result:
            direction = np.reshape(result["direction"], (-1, 3))
            still = pinned | (not any(inputs["direction"]))
            result["direction"] = np.where(still, 0.0, direction).ravel().tolist()
    return result


def measure_noise(stage: str, cases: Sequence[Inputs], count: int, size: float, seed: int) -> Noise:
    """Ask a stage for each case and for noisy copies of it, and compare with the exact answers.

    Args:
        stage: Name in `CALLS`.
        cases: Inputs without noise.
        count: Noisy copies of each case.
        size: Size of the noise, as for `perturbed`.
        seed: Seed of the noise.
    """
    call, reference = CALLS[stage], REFERENCES[stage]
    questions = unknown = wrong = refused = flips = 0
    worst, first_wrong, lost, shared, estimated = 0.0, "", [], [], []
    for number, inputs in enumerate(cases):
        rng = np.random.default_rng([seed, number])
        base, known = call(inputs), reference(inputs)
        samples = []
        for _ in range(count):
            noisy = with_noise(rng, stage, inputs, size)
            answer, right = call(noisy), reference(noisy)
            ratio, sentence = judged(stage, answer, right)
            questions, worst = questions + 1, max(worst, ratio)
            unknown += right.decision is None and not right.numbers
            flips += answer.decision != base.decision
            refused += answer.decision is False and bool(right.numbers)
            if sentence:
                wrong, first_wrong = wrong + 1, first_wrong or f"case {number}: {sentence}"
            if known.numbers and _are_comparable(answer, known):
                samples.append(_relative(answer, known))
        if samples:
            deviations = np.array(samples)
            lost.append(float(np.abs(deviations).max(initial=0.0)))
            shared.append(shared_digits(deviations))
            estimated.append(estimated_digits(deviations))
    return Noise(
        questions,
        unknown,
        wrong,
        refused,
        flips,
        worst,
        max(lost, default=0.0),
        min(shared, default=MOST_DIGITS),
        float(np.median(shared)) if shared else MOST_DIGITS,
        min(estimated, default=MOST_DIGITS),
        first_wrong,
    )


def judged(stage: str, answer: Answer, right: Right) -> tuple[float, str]:
    """Return the largest error over its bound, and what is wrong, in words.

    A time of impact may be early: detection stops where it cannot prove a pair apart any further,
    and an early time is sound. It must not be late.
    """
    if isinstance(right.decision, frozenset):
        missing = right.decision - answer.decision
        return 0.0, f"{len(missing)} are missing, such as {next(iter(missing))}" if missing else ""
    if right.decision is not None and answer.decision != right.decision:
        return 0.0, f"the decision is {answer.decision}, and the right one {right.decision}"
    if not right.numbers:
        claims = stage.startswith("S11") and answer.decision and answer.decision[0] is True
        wrong = bool(claims)
        return 0.0, "a zone without a solution counts as solved" if wrong else ""
    if stage.startswith("S11") and answer.decision is False:
        return 0.0, ""  # it says that it has no answer
    if answer.numbers.keys() != right.numbers.keys():
        return math.inf, "there is no answer, and there is a right one"
    worst = 0.0
    for name, numbers in right.numbers.items():
        found, bounds = answer.numbers[name], right.bounds[name]
        if found.shape != numbers.shape or not np.isfinite(found).all():
            return math.inf, f"{name} has another length, or a number that is not finite"
        off = found - (np.clip(found, *right.ranges[name]) if name in right.ranges else numbers)
        if name == "toi":
            bounds = np.where(off < 0.0, math.inf, bounds)
        with np.errstate(all="ignore"):
            ratios = np.where(off == 0.0, 0.0, np.abs(off) / bounds)
        worst = max(worst, float(ratios.max(initial=0.0)))
    return worst, f"an error of {worst:.3g} times its bound" if worst > 1.0 else ""


def shared_digits(deviations: Floats) -> float:
    """Return the decimal digits that all samples share with the exact answer.

    Args:
        deviations: (n_samples, n_numbers), each relative to the largest number of its output.
    """
    largest = float(np.abs(deviations).max(initial=0.0))
    return MOST_DIGITS if largest == 0.0 else min(MOST_DIGITS, -math.log10(largest))


def estimated_digits(deviations: Floats) -> float:
    """Return the significant decimal digits by the package `significantdigits`.

    Args:
        deviations: As for `shared_digits`; at least two samples.
    """
    from significantdigits import significant_digits

    moving = deviations[:, np.ptp(deviations, axis=0) > 0.0]
    if moving.shape[1] == 0:  # a standard deviation of 0 has no logarithm
        return shared_digits(deviations)
    digits: Any = significant_digits(
        moving, reference=np.zeros(moving.shape[1]), axis=0, basis=10, error="absolute"
    )
    return float(np.clip(np.asarray(digits, float), 0.0, MOST_DIGITS).min())


def _are_comparable(answer: Answer, known: Right) -> bool:
    """Return whether an answer has the outputs of another one, with as many numbers."""
    return answer.numbers.keys() == known.numbers.keys() and all(
        answer.numbers[name].shape == numbers.shape for name, numbers in known.numbers.items()
    )


def _relative(answer: Answer, known: Right) -> Floats:
    """Return the deviations of all outputs, each relative to its largest number, flat.

    Numbers that are not unique do not deviate.
    """
    parts = []
    for name, numbers in known.numbers.items():
        size = float(np.abs(numbers).max(initial=0.0))
        unique = np.isfinite(known.bounds[name]) & (name not in known.ranges)
        off = np.where(unique, answer.numbers[name] - numbers, 0.0)
        parts.append(off / size if size > 0.0 else off)
    return np.concatenate(parts)
