"""Precision: digits are counted rightly, noise is what it says, and the quick rungs are right."""

import math

import numpy as np
import pytest

from validation.ladders import noise, precision, precision_of_coordinates, precision_of_steps
from validation.ladders.ladder import RIGHT, WRONG
from validation.ladders.noise import MOST_DIGITS, UNIT
from validation.ladders.stage_answer import Answer
from validation.ladders.stage_calls import CALLS
from validation.ladders.stage_pairs import candidate_pairs
from validation.ladders.stage_references import REFERENCES, Right

LADDER = {ladder.name: ladder for ladder in precision.LADDERS}
QUICK = [(name, rung) for name, ladder in LADDER.items() for rung in ladder.quick]


@pytest.mark.parametrize(("name", "rung"), QUICK)
def test_quick_rungs_are_right(name, rung):
    (outcome,) = LADDER[name].run(rung)
    assert outcome.verdict == RIGHT, outcome


def test_ladders_have_names_of_their_own():
    assert len(LADDER) == len(precision.LADDERS)


@pytest.mark.parametrize("stage", CALLS)
@pytest.mark.parametrize("size", [UNIT, 1e-6])
def test_stages_are_right_with_noise(stage, size):
    (outcome,) = precision.judge_noise(stage, precision.inputs_of(stage)[::12], 3, size)
    assert outcome.verdict == RIGHT, outcome


@pytest.mark.parametrize("stage", precision.SLOW)
@pytest.mark.parametrize("dtype", ["f8", "f4"])
def test_slow_stages_are_right_for_some_vectors(stage, dtype):
    (outcome,) = precision.judge_stage(stage, dtype, every=8)
    assert outcome.verdict == RIGHT, outcome


def test_pairs_of_boxes_in_float32_are_right_with_noise(monkeypatch):
    """Noise gives positions all digits of a float64, so each box has to grow when it is rounded."""
    stage = "S1 candidate pairs"
    monkeypatch.setitem(CALLS, stage, lambda inputs: candidate_pairs(inputs, np.float32))
    (outcome,) = precision.judge_noise(stage, precision.inputs_of(stage)[9:26], 5, UNIT)
    assert outcome.verdict == RIGHT, outcome


def with_another(name, change):
    def wrong(answer):
        return answer._replace(numbers=answer.numbers | {name: change(answer.numbers[name])})

    return wrong


WRONG_ANSWERS = {
    "the pairs are missing": ("S1 candidate pairs", lambda a: a._replace(decision=frozenset())),
    "a step is too long": ("S8 line search", with_another("step", lambda a: a * (1 + 1e-8))),
    "a change is another": ("S8 line search", with_another("change", lambda a: a * (1 - 1e-8))),
    "a step is no number": ("S8 line search", with_another("step", lambda a: a * math.nan)),
    "no step is found": ("S8 line search", lambda a: a._replace(decision="no step")),
    "x is a bit off": ("S10 first iterations", with_another("positions", lambda a: a + 1e-9)),
    "a violation is another": (
        "S10 first iterations",
        with_another("violations", lambda a: a * (1 + 1e-8)),
    ),
    "a step is not in the trace": (
        "S10 first iterations",
        with_another("objectives", lambda a: a[1:]),
    ),
    "there is a step less": (
        "S10 first iterations",
        lambda a: a._replace(decision=a.decision - 1),
    ),
}


@pytest.mark.parametrize("name", WRONG_ANSWERS)
def test_a_wrong_answer_of_a_stage_is_noticed(name, monkeypatch):
    stage, change = WRONG_ANSWERS[name]
    call = CALLS[stage]
    monkeypatch.setitem(CALLS, stage, lambda inputs: change(call(inputs)))
    for outcome in (
        *precision.judge_stage(stage, "f8", every=16),
        *precision.judge_noise(stage, precision.inputs_of(stage)[:4], 1, 1e-9),
    ):
        assert outcome.verdict == WRONG, outcome


def test_noise_of_a_unit_is_a_unit_in_the_last_place():
    rng = np.random.default_rng(0)
    numbers = np.array([1.0, -3.0, 1e-200, math.inf, 0.0, math.nan] * 50)
    found = noise.perturbed(rng, numbers, UNIT)
    for value, unit in ((1.0, 2.0**-52), (-3.0, 2.0**-51), (1e-200, np.spacing(1e-200))):
        own = found[numbers == value] - value
        assert set(own) == {-unit, 0.0, unit}
    assert (found[numbers == math.inf] == math.inf).all()
    assert np.isnan(found[np.isnan(numbers)]).all()
    # a zero changes as the largest number does
    assert set(np.abs(found[numbers == 0.0])) == {0.0, 2.0**-51}


def test_noise_of_a_size_stays_within_it():
    numbers = np.array([2.0, -5.0, 0.0])
    changes = [
        noise.perturbed(np.random.default_rng(seed), numbers, 1e-3) - numbers for seed in range(200)
    ]
    largest = np.abs(changes).max(axis=0)
    assert (largest <= 1e-3 * np.array([2.0, 5.0, 5.0])).all()
    assert (largest >= 0.9e-3 * np.array([2.0, 5.0, 5.0])).all()


def test_noise_keeps_what_a_stage_relies_on():
    stages = ("S6 objective, gradient, constraints", "S8 line search", "S11 optimum of a zone")
    for stage in stages:
        for inputs in precision.inputs_of(stage)[:12]:
            found = noise.with_noise(np.random.default_rng(1), stage, inputs, 1e-3)
            assert found != inputs
            weights = np.reshape(found["weights"], (-1, 4))
            assert np.abs(weights.sum(axis=1)).max() < 1e-15
            if "positions" in inputs:
                pinned = np.array(inputs["pinned"], bool)
                ends = [np.reshape(found[n], (-1, 3))[pinned] for n in ("positions", "proposed")]
                np.testing.assert_array_equal(*ends)
                if "direction" in inputs:
                    assert not np.reshape(found["direction"], (-1, 3))[pinned].any()


def test_digits_are_those_of_samples_with_a_known_spread():
    rng = np.random.default_rng(2)
    spread = 1e-6 * rng.normal(size=(1000, 3)) * (1.0, 0.01, 0.0)
    assert noise.shared_digits(spread) == pytest.approx(6.0 - math.log10(3.5), abs=0.2)
    # 95 % of a normal distribution is within 1.96 standard deviations
    assert noise.estimated_digits(spread) == pytest.approx(6.0 - math.log10(1.96), abs=0.1)
    assert noise.shared_digits(np.zeros((5, 2))) == MOST_DIGITS
    assert noise.estimated_digits(np.zeros((5, 2))) == MOST_DIGITS


def test_the_judge_of_a_stage_can_fail():
    right = Right({"toi": np.array([0.5])}, {"toi": np.array([1e-14])}, True)
    stage = "S2 time of impact"
    assert noise.judged(stage, Answer({"toi": np.array([0.5])}, True), right) == (0.0, "")
    assert noise.judged(stage, Answer({"toi": np.array([0.4])}, True), right)[1] == ""
    assert noise.judged(stage, Answer({"toi": np.array([0.5 + 1e-13])}, True), right)[0] > 9.0
    assert noise.judged(stage, Answer({}, False), right)[1]
    zone = "S11 optimum of a zone"
    moves = Right({"displacements": np.ones(3)}, {"displacements": np.full(3, 1e-9)})
    off = Answer({"displacements": np.ones(3) + 1e-8}, (True, ()))
    assert noise.judged(zone, off, moves)[0] == pytest.approx(10.0, rel=1e-6)
    assert noise.judged(zone, Answer({"displacements": np.ones(3)}, (True, ())), Right({}, {}))[1]


def test_a_step_in_a_range_is_right():
    """Wolfe's conditions accept any step of an interval, and more pairs may be listed."""
    right = Right({"step": np.array([1.5])}, {"step": np.array([1e-9])}, None, {"step": (1.0, 2.0)})
    for step, expected in ((1.0, 0.0), (1.9, 0.0), (2.0 + 5e-10, 0.5), (1.0 - 3e-9, 3.0)):
        worst, sentence = noise.judged("S8 line search", Answer({"step": np.array([step])}), right)
        assert worst == pytest.approx(expected, rel=1e-6)
        assert bool(sentence) == (expected > 1.0)
    pairs = Right({}, {}, frozenset({1, 2}))
    stage = "S1 candidate pairs"
    assert noise.judged(stage, Answer({}, frozenset({1, 2, 3})), pairs)[1] == ""
    assert "1 are missing, such as 2" in noise.judged(stage, Answer({}, frozenset({1})), pairs)[1]


def test_a_search_may_pass_by_a_step_that_is_shorter_than_the_smallest_one():
    """Noise of one unit on a direction along which L is flat leaves a step of about 1e-17."""
    stage = "S8 line search"
    flat = [
        inputs
        for inputs in precision.inputs_of(stage)
        if inputs["search"] == "exact" and set(inputs["direction"]) == {0.0, 1.0}
    ]
    assert len(flat) == 1
    downhill = [a - 2.0**-53 * (i % 3 == 2) for i, a in enumerate(flat[0]["direction"][:3])]
    uphill = [-a if i % 3 == 2 else a for i, a in enumerate(downhill)]
    found = [
        REFERENCES[stage]({**flat[0], "direction": p + flat[0]["direction"][3:]})
        for p in (downhill, uphill)
    ]
    (right,) = (one for one in found if one.ranges)
    least, most = right.ranges["step"]
    assert (least, right.decision) == (0.0, None)
    assert 0.0 < most < 1e-15
    step, change = (np.array([right.numbers[name][0]]) for name in ("step", "change"))
    for factor, is_right in ((0.0, True), (0.5, True), (1.0, True), (2.0, False)):
        answer = Answer({"step": factor * step, "change": change}, "")
        assert (noise.judged(stage, answer, right)[1] == "") == is_right


def test_the_reference_of_a_zone_is_the_closed_form():
    """One vertex of mass 2 kg and a pinned face: it goes up to the thickness."""
    inputs = {
        "nodes": [0, 1, 2, 3],
        "weights": [1.0, -0.5, -0.25, -0.25],
        "normals": [0.0, 0.0, 1.0],
        "proposed": [0.25, 0.25, -0.4, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        "masses": [2.0, 1.0, 1.0, 1.0],
        "pinned": [0, 1, 1, 1],
        "thickness": 0.1,
    }
    moves = REFERENCES["S11 optimum of a zone"](inputs).numbers["displacements"]
    np.testing.assert_allclose(moves, [0.0, 0.0, 0.5] + [0.0] * 9, rtol=1e-15)


@pytest.mark.parametrize("name", ["float16", "1 decimal"])
def test_rounded_starts_are_judged_as_exact_arithmetic_does(name):
    (outcome,) = precision_of_coordinates.judge_rounded(precision_of_coordinates.FORMATS[name], 4)
    assert outcome.verdict == RIGHT, outcome
    assert ("refused" in outcome.status) == (name == "1 decimal")


def test_a_door_that_accepts_a_start_that_touches_is_wrong(monkeypatch):
    """If exact arithmetic said that every start touches, accepting one would be a fault."""
    monkeypatch.setattr(precision_of_coordinates, "_meets", lambda step, positions: True)
    (outcome,) = precision_of_coordinates.judge_rounded(lambda positions: positions, 1)
    assert outcome.verdict == WRONG


@pytest.mark.parametrize("size", [UNIT, 1e-6])
def test_steps_with_noise_end_free(size):
    (outcome,) = precision_of_steps.judge_noisy_steps("light", size, 2, 3)
    assert outcome.verdict == RIGHT, outcome
    assert outcome.error < (1e-9 if size == UNIT else 1e-2)
