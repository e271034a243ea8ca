"""Strange input is refused with a message, or is computed; a quick part of the study of input."""

import os
import time
import warnings
import zlib

import numpy as np
import pytest

from izo_ref.base import errors
from validation.fuzz import trial as trials
from validation.fuzz.families import FAMILIES, SEED, count_of
from validation.fuzz.run import Family, run_batch, run_family
from validation.fuzz.trial import Trial, Wrong, run_trial
from validation.limits import CAN_LIMIT
from validation.study import fuzz

# Solvers of every kind take minutes to compile. So the quick part has the families that compile
# little; the study has all of them.
QUICK = [name for name in FAMILIES if name not in ("resolve", "solve_zone", "Scene.after")]
INPUTS = 1000


@pytest.mark.parametrize("name", QUICK)
def test_strange_input_is_no_problem(name):
    tally = run_batch(name, FAMILIES[name], SEED, range(count_of(FAMILIES[name], INPUTS)))
    assert tally.problems == []
    assert sum(tally.kinds.values()) == count_of(FAMILIES[name], INPUTS)


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
