"""The ladders of stiff zones: their quick rungs, and their generators."""

import numpy as np
import pytest

from validation.ladders.judge_zone import condition_number, judge_zone
from validation.ladders.ladder import OWN, RIGHT, SAYS_SO, WRONG, Outcome, worst
from validation.ladders.penalties import METHOD_PARAMETERS, method_penalty, preset_penalty
from validation.ladders.stiff import LADDERS
from validation.oracles import nnls
from validation.oracles.rational import ExactZone, to_float
from validation.scenes import stiff_zones as made
from validation.scenes.piles import chain_zone

QUICK = [(ladder, rung) for ladder in LADDERS for rung in ladder.quick]


@pytest.mark.parametrize(
    ("ladder", "rung"), QUICK, ids=[f"{ladder.name}-{rung}" for ladder, rung in QUICK]
)
def test_quick_rungs_are_right(ladder, rung):
    own = next(iter(ladder.run(rung)))
    assert own.by == OWN
    assert own.verdict == RIGHT, own


def test_ladders_go_one_way_and_have_their_own_names():
    names = [ladder.name for ladder in LADDERS]
    assert len(set(names)) == len(names)
    for ladder in LADDERS:
        steps = np.diff(ladder.rungs)
        assert (steps > 0.0).all() or (steps < 0.0).all(), ladder.name
        assert set(ladder.quick) <= set(ladder.rungs), ladder.name
        assert ladder.wanted is None or ladder.wanted in ladder.rungs, ladder.name


@pytest.mark.parametrize("angle", [1e-1, 1e-2, 1e-4])
def test_the_condition_number_of_a_wedge_is_known(rng, angle):
    """C C^T is [[1, cos], [cos, 1]] times a number, so the ratio is 1 / tan(angle / 2)^2."""
    zone = made.wedge_zone(rng, angle)
    # singular values have an error of some 1e-16, the smaller one is angle / sqrt 2
    expected = 1.0 / np.tan(0.5 * angle) ** 2
    assert condition_number(zone) == pytest.approx(expected, rel=1e-14 / angle)


@pytest.mark.parametrize(
    ("make", "impacts"),
    [
        (lambda rng: made.wedge_zone(rng, 0.1), 2),
        (lambda rng: made.wedge_zone(rng, 1e-3, 1e6), 2),
        (lambda rng: made.cone_zone(rng, 0.2, 3), 3),
    ],
)
def test_all_constraints_of_a_wedge_push(rng, make, impacts):
    optimum = ExactZone(make(rng)).solve()
    assert optimum is not None
    assert sum(v > 0 for v in optimum.multipliers) == impacts


def test_a_cone_has_three_independent_constraints(rng):
    zone = ExactZone(made.cone_zone(rng, 0.2, 12))
    matrix = np.array([row for g in zone.gradients for row in [to_float(g.values()).ravel()]])
    assert np.linalg.matrix_rank(matrix, tol=1e-12) == 3


@pytest.mark.parametrize("width", [0.5, 1e-3, -1e-3, -0.5])
@pytest.mark.parametrize("walls", [np.inf, 1.0])
def test_a_slab_with_pinned_faces_has_a_solution_if_there_is_room(rng, width, walls):
    problem = made.slab_zone(rng, width, walls)
    optimum = ExactZone(problem).solve()
    assert (optimum is None) == (np.isinf(walls) and width < 0.0)
    other = nnls.solve(problem)  # an independent oracle agrees
    assert other.claims == (optimum is not None)
    if optimum is not None:
        right = to_float(optimum.moves)
        np.testing.assert_allclose(other.displacements, right, atol=1e-9 * np.abs(right).max())


def test_copies_do_not_change_the_optimum(rng):
    base = chain_zone(rng, 4)
    copied = ExactZone(made.copied_zone(rng, base, 3)).solve()
    alone = ExactZone(base).solve()
    assert copied is not None
    assert alone is not None
    assert copied.moves == alone.moves


@pytest.mark.parametrize("weight", [0.5, 1e-3, 1e-9])
def test_a_lever_moves_the_free_corner_by_the_depth_over_the_weight(rng, weight):
    problem = made.lever_zone(rng, weight, pinned=True)
    depth = -float(problem.gaps(problem.proposed)[0])
    optimum = ExactZone(problem).solve()
    assert optimum is not None
    moves = to_float(optimum.moves)
    assert np.linalg.norm(moves[1]) == pytest.approx(depth / weight, rel=1e-9)
    assert not moves[[0, 2, 3]].any()


def test_a_lever_without_weight_has_no_solution(rng):
    assert ExactZone(made.lever_zone(rng, 0.0, pinned=True)).solve() is None


def test_edges_that_cross_at_an_end_share_the_move(rng):
    """With equal masses each vertex moves by its weight times the same length."""
    problem = made.edge_zone(rng, 0.125)
    optimum = ExactZone(problem).solve()
    assert optimum is not None
    lengths = to_float(optimum.moves) @ problem.normals[0]
    np.testing.assert_allclose(lengths / lengths[0], problem.weights[0] / 0.875, rtol=1e-12)


def test_a_penalty_is_given_back_after_a_rung():
    kept = METHOD_PARAMETERS["cg"]
    with method_penalty("cg", 7.0), preset_penalty("icloth", 5.0):
        assert METHOD_PARAMETERS["cg"].mu_inner_solve == 7.0
    assert METHOD_PARAMETERS["cg"] == kept


def test_another_penalty_changes_the_steps(rng):
    """Otherwise the ladders of penalties would judge the same run many times."""
    steps = []
    for mu in (1.0, 30.0):
        zone = chain_zone(np.random.default_rng(1), 8, 1.0)
        with method_penalty("cg", mu):
            steps.append(judge_zone(zone, method="cg", tolerance=1e-4)[0].iterations)
    assert steps[0] != steps[1]


def test_the_worst_draw_of_each_program_stands():
    draws = [
        [Outcome(RIGHT, "solved", error=1e-9, seconds=2.0), Outcome(WRONG, "success", "SLSQP")],
        [Outcome(SAYS_SO, "not solved", error=1e-3, seconds=1.0), Outcome(RIGHT, "", "SLSQP")],
        [Outcome(SAYS_SO, "not solved", error=1e-2), Outcome(RIGHT, "", "SLSQP")],
    ]
    own, other = worst(draws)
    assert (own.verdict, own.error, own.seconds) == (SAYS_SO, 1e-2, 2.0)
    assert (other.by, other.verdict) == ("SLSQP", WRONG)
