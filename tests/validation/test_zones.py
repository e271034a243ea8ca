"""Oracles of zones compared with each other, and our solver compared with the exact one."""

import math

import numpy as np
import pytest
from flint import fmpq

import izo_ref
from tests.helpers.shapes import random_problem
from tests.naive.qp import dense_rows, solve_qp
from validation import json_rows
from validation.oracles import nnls, qp, slsqp
from validation.oracles.answer import scaled_zone
from validation.oracles.rational import ExactZone, active_rows, to_float
from validation.provenance import made_by
from validation.report import zones as zones_page
from validation.scenes.zones import THICKNESS_M, random_zone
from validation.study.nonlinear import nonlinear_rows
from validation.study.zones import MASS_RATIOS, SIZES, random_zone_rows, scaling_rows


def test_the_exact_oracle_solves_one_impact_exactly():
    """K = 1/1 + 1/2 * 1/4 + 1/4 * 1/16 * 2 and r = 3/2 are rational."""
    problem = izo_ref.ZoneProblem(
        [[0, 1, 2, 3]],
        [[1.0, -0.5, -0.25, -0.25]],
        [[0.0, 0.0, 1.0]],
        [[0, 0, -1.0], [0, 0, 0], [1, 0, 0], [0, 1, 0]],
        [1.0, 2.0, 4.0, 4.0],
        0.5,
    )
    zone = ExactZone(problem)
    optimum = zone.solve()
    multiplier = fmpq(3, 2) / (1 + fmpq(1, 8) + fmpq(1, 32))
    assert optimum.multipliers == [multiplier]
    assert [move[2] for move in optimum.moves] == [
        multiplier * weight for weight in (1, fmpq(-1, 4), fmpq(-1, 16), fmpq(-1, 16))
    ]
    assert optimum.optimal
    assert not zone.point([]).optimal  # without a multiplier, the constraint is violated
    assert zone.distance(optimum.moves, zone.still) == pytest.approx(1.5 / math.sqrt(37 / 32))


def test_the_exact_oracle_accepts_the_optimum_alone(rng):
    """Every other set of active constraints is rejected."""
    for _ in range(20):
        zone = ExactZone(random_zone(rng, 5, 1e6))
        optimum = zone.solve()
        held = {j for j, value in enumerate(optimum.multipliers) if value != 0}
        yes = 0
        for bits in range(32):
            chosen = [j for j in range(5) if bits >> j & 1]
            if zone.independent(chosen) != chosen:
                continue
            point = zone.point(chosen)
            same = point.moves == optimum.moves
            assert point.optimal is (same and min(point.multipliers) >= 0)
            yes += point.optimal
        assert yes >= 1
        assert zone.point(sorted(held)).optimal


def test_the_exact_oracle_does_not_depend_on_where_it_begins(rng):
    for n in (3, 8, 20):
        problem = random_zone(rng, n, 1e9)
        zone = ExactZone(problem)
        expected = zone.solve().moves
        for guess in ([], range(n), active_rows(izo_ref.solve_zone(problem).multipliers)):
            assert zone.solve(guess).moves == expected


def test_the_exact_oracle_agrees_with_a_search_of_all_active_sets(rng):
    for _ in range(15):
        problem = random_problem(rng, 5, 10.0)
        rows = dense_rows(problem.nodes, problem.weights, problem.normals, len(problem.proposed))
        b = np.full(5, problem.thickness)
        expected = solve_qp(rows, b, problem.masses, problem.proposed)
        found = ExactZone(problem).solve()
        assert (found is None) == (expected is None)
        if found is not None:
            moves = to_float(found.moves)
            np.testing.assert_allclose(problem.proposed + moves, expected, rtol=0.0, atol=1e-12)


def test_infeasible_zones_are_reported_infeasible(rng):
    problem = random_zone(rng, 2)
    both = [np.repeat(part[:1], 2, axis=0) for part in (problem.nodes, problem.weights)]
    normals = np.array([problem.normals[0], -problem.normals[0]])
    opposed = izo_ref.ZoneProblem(*both, normals, problem.proposed, problem.masses, 1e-3)
    assert ExactZone(opposed).solve() is None
    assert not nnls.solve(opposed).claims
    assert not qp.solve(opposed, "clarabel").claims


def test_random_zones_are_feasible_and_contain_every_promised_kind(rng):
    kinds = {"duplicate": 0, "nearly parallel": 0, "opposed": 0}
    for _ in range(20):
        problem = random_zone(rng, 32, 1e12)
        assert (problem.gaps(problem.proposed) < 0.0).any()
        assert problem.masses.max() == pytest.approx(1e12 * problem.masses.min())
        assert problem.thickness == THICKNESS_M
        assert ExactZone(problem).solve(active_rows(izo_ref.solve_zone(problem).multipliers))
        same = (problem.nodes[:, None] == problem.nodes[None]).all(axis=2)
        cosine = problem.normals @ problem.normals.T
        apart = np.linalg.norm(problem.normals[:, None] - problem.normals[None], axis=2)
        pairs = np.triu(np.ones_like(same), 1)
        kinds["duplicate"] += (same & (apart == 0.0) & pairs).sum()
        kinds["nearly parallel"] += (same & (apart > 0.0) & (apart < 1e-3) & pairs).sum()
        vertex = problem.nodes[:, None, 0] == problem.nodes[None, :, 0]
        kinds["opposed"] += (vertex & ~same & (cosine < -1.0 + 1e-12) & pairs).sum()
    assert min(kinds.values()) > 10, kinds


def test_scaled_zones_state_the_same_problem(rng):
    problem = random_zone(rng, 9, 1e4)
    zone = scaled_zone(problem)
    np.testing.assert_allclose(np.linalg.norm(zone.matrix.toarray(), axis=1), 1.0)
    assert np.abs(zone.rhs).max() == 1.0
    z = rng.normal(size=zone.matrix.shape[1])
    moves = zone.displacements(z)
    gaps = problem.gaps(problem.proposed + moves)
    slack = (zone.matrix @ z - zone.rhs) * zone.unit * zone.lengths
    np.testing.assert_allclose(slack, gaps, rtol=0.0, atol=1e-9 * np.abs(gaps).max())
    held = problem.masses.copy()
    held[:] = np.inf
    parts = (problem.nodes, problem.weights, problem.normals, problem.proposed)
    with pytest.raises(ValueError, match="impact 0"):
        scaled_zone(izo_ref.ZoneProblem(*parts, held, 1e-3))


@pytest.fixture(scope="module")
def random_rows():
    """Three of each size and mass ratio; the study takes 200."""
    return random_zone_rows(count=3 * len(SIZES) * len(MASS_RATIOS))


def test_ours_is_the_exact_optimum_to_1e_12_at_every_mass_ratio(random_rows):
    assert {row["mass_ratio"] for row in random_rows} == set(MASS_RATIOS)
    for row in random_rows:
        assert row["error"]["ours"] <= 1e-12, row
        # No positions in floats could be much closer.
        assert row["error_of_positions"] <= 2.0 * row["least_of_positions"] + 1e-12


def test_dense_oracles_agree_with_the_exact_optimum(random_rows):
    """Their accuracy is limited: they work on C, whose rows are nearly parallel in these zones."""
    for row in random_rows:
        assert row["error"]["NNLS"] <= 1e-10, row
        assert row["error"]["SLSQP, scaled"] <= 1e-10, row


@pytest.mark.parametrize("solver", list(qp.SETTINGS))
def test_other_solvers_are_given_the_same_problem(rng, solver):
    """On well-conditioned zones, answers that claim success are optimal, multipliers included."""
    right = 0
    for _ in range(5):
        problem = random_problem(rng, 4, 10.0)
        if ExactZone(problem).solve() is None:
            continue
        answer = qp.solve(problem, solver)
        if not answer.claims:
            continue
        positions = problem.proposed + answer.displacements
        judged = izo_ref.residuals(problem, positions, answer.multipliers)
        right += judged.gap <= 1e-6 and judged.violation <= 1e-6
    assert right >= 2


def test_an_error_of_a_solver_becomes_its_answer(rng):
    answer = qp.solve(random_zone(rng, 4), "proxqp", no_such_setting=1)
    assert not answer.claims
    assert np.isnan(answer.displacements).all()
    assert "TypeError" in answer.message


def test_raw_slsqp_claims_success_and_is_wrong_where_scaled_is_right():
    rows = scaling_rows()
    assert all(row["claims"] for row in rows)
    raw = [row for row in rows if row["form"] != "scaled"]
    assert sum(row["largest_position_error"] > 0.2 for row in raw) >= 6
    assert max(row["error"] for row in raw) > 100.0  # relative, in the norm of the objective
    assert all(row["error"] <= 1e-12 for row in rows if row["form"] == "scaled")


def test_raw_slsqp_is_given_the_same_problem(rng):
    """With equal masses near 1, the unscaled problem is solved correctly too."""
    problem = random_zone(rng, 3)
    zone = ExactZone(problem)
    answer = slsqp.solve_raw(problem, ftol=1e-16, gradients=True)
    assert zone.relative_error(answer.displacements, zone.solve()) <= 1e-6


@pytest.fixture(scope="module")
def relinearized_rows():
    """Return rows of the study of relinearisation, computed once."""
    return nonlinear_rows(each=4)


def test_the_fixed_point_of_relinearisation_is_a_kkt_point(relinearized_rows):
    fixed = [row for row in relinearized_rows if row["fixed_point"]]
    assert len(fixed) >= 8
    for row in fixed:
        assert max(row["violation"], row["stationarity"], row["complementarity"]) <= 1e-8, row


def test_slsqp_started_at_the_fixed_point_does_not_leave_it(relinearized_rows):
    for row in relinearized_rows:
        if row["fixed_point"]:
            assert row["slsqp_moved"] <= 1e-8, row


def test_the_report_is_written_from_rows(tmp_path, random_rows, relinearized_rows):
    rows = {
        "random": random_rows,
        "scaling": scaling_rows(),
        "sizes": [],
        "steps": [],
        "nonlinear": relinearized_rows,
    }
    json_rows.save(tmp_path / zones_page.FILE, made_by("a command"), rows)
    text = zones_page.page(tmp_path, tmp_path).read_text()
    assert f"## {len(random_rows)} random zones" in text
    assert "Measured by `a command` at commit" in text
    assert "no step files" in text
