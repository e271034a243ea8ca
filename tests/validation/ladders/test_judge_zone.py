"""The judge of a zone: what it calls right, and that it notices what is wrong."""

import copy
import math

import numpy as np
import pytest

from izo_ref.solvers.solve import solve_zone
from validation.ladders import judge_large, judge_zone
from validation.ladders.judge_zone import Errors, judge_answer
from validation.ladders.ladder import RIGHT, SAYS_SO, WRONG
from validation.oracles.answer import Answer
from validation.scenes.piles import chain_zone
from validation.scenes.stiff_zones import slab_zone


def answer_off(monkeypatch, module, by):
    """Let our solver answer with vertex 0 off by a fraction of the largest move."""
    plain = solve_zone

    def wrong(problem, **settings):
        solution = plain(problem, **settings)
        moves = solution.displacements.copy()
        moves[0, 0] += by * np.abs(moves).max()
        return solution._replace(displacements=moves, positions=problem.proposed + moves)

    monkeypatch.setattr(module, "solve_zone", wrong)


@pytest.mark.parametrize(("by", "verdict"), [(0.0, RIGHT), (1e-12, RIGHT), (1e-2, WRONG)])
def test_an_answer_that_is_off_is_noticed(rng, monkeypatch, by, verdict):
    answer_off(monkeypatch, judge_zone, by)
    (own,) = judge_zone.judge_zone(chain_zone(rng, 4, 1.0))
    assert own.verdict == verdict
    assert own.error == pytest.approx(by, abs=1e-13, rel=0.5)


@pytest.mark.parametrize(
    ("errors", "verdict"),
    [
        (Errors(1e-12, 1e-12, 1e-11, 1e-11), RIGHT),
        (Errors(1e-7, 1e-7, 2e-7, 2e-7), SAYS_SO),  # the bound says that 1e-9 is not proved
        (Errors(1e-12, 1e-12, 1e-13, 1e-13), WRONG),  # a false bound
        (Errors(1e-12, 1e-7, 1e-11, 1e-8), WRONG),  # a light vertex is off by more than is proved
        (Errors(1e-4, 1e-4, 1e-3, 1e-3), WRONG),  # a gap of 1e-9 promises 4.5e-5
    ],
)
def test_a_solved_zone_is_judged_by_what_it_promises(rng, errors, verdict):
    assert judge_answer(solve_zone(chain_zone(rng, 4)), errors, 1e-9)[0] == verdict


def test_an_unsolved_zone_says_so(rng):
    solution = solve_zone(chain_zone(rng, 4))
    unsolved = solution._replace(feasible=False)
    assert judge_answer(unsolved, Errors(0.5, 0.5, math.inf, math.inf), 1e-9)[0] == SAYS_SO


@pytest.mark.parametrize(("width", "verdict"), [(-1e-12, RIGHT), (-1e-6, WRONG)])
def test_only_what_is_infeasible_within_the_tolerance_may_count_as_solved(rng, width, verdict):
    problem = slab_zone(rng, width)
    wide = solve_zone(slab_zone(rng, 1.0))
    found = judge_zone.judge_infeasible(problem, wide._replace(multipliers=np.zeros(2)))
    assert found[0] == verdict


def test_another_solver_that_claims_a_wrong_answer_is_wrong(rng):
    zone = chain_zone(rng, 4)

    def stays(problem):
        return Answer(np.zeros_like(problem.proposed), None, True, "done", 0.0)

    _, other = judge_zone.judge_zone(zone, others={"stays": stays})
    assert (other.by, other.verdict) == ("stays", WRONG)


@pytest.mark.parametrize(("by", "verdict"), [(0.0, RIGHT), (1e-7, SAYS_SO), (1.0, WRONG)])
def test_a_large_zone_is_judged_by_proofs(rng, monkeypatch, by, verdict):
    zone = copy.copy(chain_zone(rng, 80, 1.0))
    answer_off(monkeypatch, judge_zone, by)
    assert judge_large.judge_large(zone).verdict == verdict
