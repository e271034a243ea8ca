"""Strange input is refused with a message, or is computed; a quick part of the study of input."""

import dataclasses
import os
import time
import warnings
import zlib

import numpy as np
import pytest

import izo_ref
from izo_ref.base import errors
from tests.helpers.shapes import two_sheets, vertex_over_face
from validation.check import check
from validation.fuzz import trial as trials
from validation.fuzz.calls_check import verdict_problem
from validation.fuzz.calls_detection import impacts_problem, plan_problem
from validation.fuzz.families import FAMILIES, SEED, count_of
from validation.fuzz.run import Family, run_batch, run_family
from validation.fuzz.trial import Trial, Wrong, run_trial
from validation.limits import CAN_LIMIT
from validation.study import fuzz

# Solvers of every kind take minutes to compile. So the quick part has the families that compile
# little; the study has all of them.
QUICK = [name for name in FAMILIES if name not in ("resolve", "solve_zone", "Scene.after")]
INPUTS = 1000
FEW = 200  # of inputs whose judges start processes of their own, which takes half a second each


@pytest.mark.parametrize("name", QUICK)
def test_strange_input_is_no_problem(name):
    count = count_of(FAMILIES[name], FEW if name == "check" else INPUTS)
    tally = run_batch(name, FAMILIES[name], SEED, range(count))
    assert tally.problems == []
    assert sum(tally.kinds.values()) == count


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILIES)
def test_much_strange_input_is_no_problem(name):
    row = run_family(name, FAMILIES[name], SEED + 7, 500, print)
    assert sum(row[kind.replace(" ", "_")] for kind in trials.PROBLEMS) == 0, row["first_problem"]


def outcome_of(call, wrongs=(), judge=lambda result: ""):
    return run_trial(Trial(call, wrongs, judge, "made up"))


def raising(error):
    def call():
        raise error

    return call


def test_each_kind_of_problem_is_noticed(monkeypatch):
    """A fuzzer that never complains would find nothing."""
    monkeypatch.setattr(trials, "LONGEST_S", 0.2)
    named = errors.ShapeError("faces: expected integers, got a text in row 3")
    wrong = [Wrong("faces", "row 3")]
    assert outcome_of(lambda: 1).kind == trials.ACCEPTED
    assert outcome_of(raising(named), wrong).kind == trials.REFUSED
    assert outcome_of(raising(named), [Wrong("faces", "row 4")]).kind == trials.UNNAMED
    assert outcome_of(raising(named), [Wrong("masses")]).kind == trials.UNNAMED
    assert outcome_of(raising(named)).kind == trials.UNFAIR
    assert outcome_of(raising(named), None).kind == trials.REFUSED
    assert outcome_of(raising(ValueError("x")), wrong).kind == trials.CRASH
    assert outcome_of(lambda: warnings.warn("x", stacklevel=1)).kind == trials.CRASH
    assert outcome_of(lambda: 1, wrong).kind == trials.SILENT
    assert outcome_of(lambda: 1, (), lambda result: "NaN").kind == trials.SILENT
    assert outcome_of(lambda: time.sleep(5)).kind == trials.HANG
    advice = errors.FileFormatError("f: set allow_pickle=True")
    assert outcome_of(raising(advice), [Wrong("f")]).kind == trials.UNNAMED


def test_the_judge_of_impacts_notices_each_fault(rng):
    scene = two_sheets(rng, 3)
    impacts = izo_ref.find_impacts(scene)
    assert impacts_problem(impacts, scene) == ""

    def problem(rows=slice(None), **changed):
        parts = {name: part[rows] for name, part in impacts._asdict().items()}
        return impacts_problem(izo_ref.Impacts(**parts | changed), scene)

    assert "is missing" in problem(slice(1, None))
    assert "is missing" in problem(slice(-1))
    assert "edge-edge pair is before" in problem(slice(None, None, -1))
    assert "is there twice" in problem([0, *range(len(impacts.toi))])
    assert "is found at" in problem(toi=np.ones_like(impacts.toi))
    assert "from 0 to 1" in problem(toi=impacts.toi + 1.5)
    assert "unit vector" in problem(normals=2.0 * impacts.normals)
    assert "at the start" in problem(normals=-impacts.normals)
    assert "sum to zero" in problem(weights=impacts.weights + 0.1)
    assert "sign" in problem(weights=-impacts.weights)
    assert "shapes" in problem(weights=impacts.weights[:, :3])


def test_the_judge_of_plans_notices_each_fault():
    scene, other = vertex_over_face(), vertex_over_face(drop=0.0)
    plan = izo_ref.plan(scene)
    assert plan_problem(plan, None, scene) == ""
    assert "not true" in plan_problem(plan, None, other)
    assert "switched off" in plan_problem(plan, izo_ref.Options(plan=()), scene)
    first = plan.lines[0]
    for line in (first._replace(needed="few"), first._replace(rule="x")):
        assert "needed or rule" in plan_problem(plan._replace(lines=(line,)), None, scene)
    assert "words" in plan_problem(plan._replace(lines=(first._replace(reason=""),)), None, scene)
    assert "stages" in plan_problem(plan._replace(lines=plan.lines[:-1]), None, scene)


def test_the_judge_of_verdicts_notices_each_fault():
    scene = vertex_over_face(pinned=(True, True, True, False))
    good, bad = check(scene, None, 1e-3), scene.positions_t1
    assert verdict_problem(good, scene, good.positions, True) == ""
    assert "other positions" in verdict_problem(good, scene, bad, True)
    moved = dataclasses.replace(good, positions=bad)
    assert "meet, not" in verdict_problem(moved, scene, bad, False)
    meeting = izo_ref.certify_path(scene, bad).meeting
    assert "passed, but pairs meet" in verdict_problem(
        dataclasses.replace(moved, meeting=meeting), scene, bad, False
    )
    failed = dataclasses.replace(good, passed=False)
    assert verdict_problem(failed, scene, good.positions, True).startswith("failed")
    assert "negative" in verdict_problem(
        dataclasses.replace(good, thickness=-1.0), scene, good.positions, True
    )


@pytest.mark.skipif(not CAN_LIMIT, reason="processes cannot be forked here")
def test_a_process_that_dies_is_a_crash_of_its_input(tmp_path):
    def make(rng, folder):
        kill = rng.random() < 0.1
        return Trial(lambda: os._exit(7) if kill else 1, (), lambda result: "", "made up")

    family = Family(make, 1)
    key = [3, zlib.crc32(b"a")]
    kills = sum(np.random.default_rng([*key, k]).random() < 0.1 for k in range(60))
    row = run_family("a", family, 3, 60, lambda line: None, warm=0)
    assert (row["accepted"], row["crash"]) == (60 - kills, kills)
    assert kills > 0


def test_the_study_resumes(tmp_path, monkeypatch):
    made = {"known failures": FAMILIES["known failures"], "index": FAMILIES["index of a trace"]}
    monkeypatch.setattr(fuzz, "FAMILIES", made)
    monkeypatch.setattr(fuzz, "warm_up", lambda: None)
    lines: list[str] = []
    fuzz.measure(tmp_path, lines.append, 1000, SEED)
    first = (tmp_path / "fuzz.csv").read_text()
    assert len(lines) == 2
    fuzz.measure(tmp_path, lines.append, 1000, SEED)
    assert (tmp_path / "fuzz.csv").read_text() == first
