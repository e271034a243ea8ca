"""Our own compiled functions pass all vectors through the harness, as a port would."""

from __future__ import annotations

import sys
from collections import Counter

from izo_ref.porting.conform.run import Choice, requests_of, run_program
from izo_ref.porting.files import load_cases
from izo_ref.porting.judge.outcome import NOT_SUPPORTED, PASSED
from izo_ref.porting.stages import STAGES

SECONDS = 120.0  # of the first case of a stage, which may compile


def results_of(module: str, *stages: str) -> dict[str, Counter[str]]:
    """Return how often a port of this folder passed and failed, by stage."""
    requests = requests_of(load_cases(), Choice(stages=stages, dtypes=("f8",)))
    run = run_program([sys.executable, "-m", module], requests, seconds=SECONDS)
    assert not run.notes
    results: dict[str, Counter[str]] = {}
    for row in run.rows:
        results.setdefault(row.request.case.stage, Counter())[row.outcome.result] += 1
    return results


def test_our_own_functions_conform_in_every_stage():
    results = results_of("tests.ports.own")
    assert set(results) == {stage.name for stage in STAGES}
    for name, counts in results.items():
        assert set(counts) <= {PASSED, NOT_SUPPORTED}, name
        assert counts[PASSED] > 0.9 * counts.total(), name


def test_slsqp_of_scipy_conforms_in_the_stage_that_it_has():
    results = results_of("tests.ports.slsqp", "S11")
    assert set(results["S11"]) == {PASSED}
