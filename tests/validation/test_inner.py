"""Families of zones, the solvers that are compared, and the studies of zones."""

import math

import numpy as np
import pytest

from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.residuals import residuals
from validation.oracles.answer import scaled_zone
from validation.rows import Rows, read
from validation.scenes.piles import chain_zone, pinch_zone, stack_zone
from validation.scenes.zones import random_zone
from validation.study import convergence, inner, own
from validation.study.cells import LIBRARY, Cell, plan
from validation.study.families import QUICK, Family, step_family, synthetic
from validation.study.timing import measure
from validation.study.truth import Truth

SMALL = [family for family in synthetic() if family.size <= 500]


@pytest.mark.parametrize("family", SMALL, ids=lambda family: family.name)
def test_families_are_feasible_seeded_and_violated(family):
    problem, again = family.make(0), family.make(0)
    for name, value in vars(problem).items():
        np.testing.assert_array_equal(value, getattr(again, name))
    other = family.make(1)
    assert not np.array_equal(problem.weights, other.weights)
    assert problem.gaps(problem.proposed).min() < 0.0
    solution = solve_zone(problem, tolerance=1e-12)
    assert solution.feasible
    assert solution.residuals.solved(1e-12, 1e-12)
    assert 0.9 * family.size <= len(problem.nodes) <= family.size


@pytest.mark.parametrize("step", ["crumple", pytest.param("crumple-10k", marks=pytest.mark.data)])
def test_zones_of_a_step_can_fill_a_call_with_many(step):
    """A step has few large zones, so a call with many zones repeats them."""
    family = step_family(step, "the largest zones")
    assert family.count == 3
    many = [family.make(number) for number in range(2 * family.count + 1)]
    assert many[0] is many[family.count] is many[-1]


def test_a_chain_shares_vertices_with_its_neighbours_only(rng):
    nodes = [set(row) for row in chain_zone(rng, 20).nodes.tolist()]
    for i, first in enumerate(nodes):
        for j, second in enumerate(nodes):
            assert bool(first & second) == (abs(i - j) <= 1)


def test_a_stack_touches_layer_by_layer_and_stands_on_pinned_vertices(rng):
    problem = stack_zone(rng, 4, 6)
    layers = problem.nodes // 36
    assert (np.abs(layers[:, 0] - layers[:, 1]) == 1).all()
    assert (layers[:, 1:] == layers[:, 1:2]).all()
    assert np.isinf(problem.masses[:36]).all()
    assert np.isfinite(problem.masses[36:]).all()
    np.testing.assert_allclose(problem.weights.sum(axis=1), 0.0, rtol=0.0, atol=1e-15)


def test_a_pinch_has_opposed_rows_on_each_vertex(rng):
    problem = pinch_zone(rng, 12)
    for tip in np.unique(problem.nodes[:, 0]):
        lower, upper = problem.normals[problem.nodes[:, 0] == tip]
        np.testing.assert_array_equal(lower, -upper)


def test_a_zone_of_fresh_constraints_has_no_duplicates(rng):
    problem = random_zone(rng, 50, fresh_only=True)
    assert len(np.unique(problem.nodes, axis=0)) == 50


@pytest.fixture(scope="module")
def tiny():
    """Return a zone of six impacts and its exact optimum; solved once, so its seed is fixed."""
    problem = random_zone(np.random.default_rng(7), 6, 1e3)
    return problem, Truth(problem)


@pytest.mark.parametrize("name", LIBRARY)
def test_libraries_solve_a_tiny_zone(tiny, name):
    problem, truth = tiny
    library = LIBRARY[name]
    zone = scaled_zone(problem)
    call, read_result = library.prepare(zone, library.tolerances[-1], 10.0)
    found = read_result(call())
    moves, multipliers = zone.displacements(found.z), zone.multipliers(found.multipliers)
    # An error of the gap is the square of an error of z.
    assert truth.error(moves) < 1e-5
    assert residuals(problem, problem.proposed + moves, multipliers).solved(1e-6, 1e-6)
    assert read_result(call()).z == pytest.approx(found.z), "a second call is the same"


@pytest.mark.parametrize("method", own.DUAL)
def test_our_methods_solve_tiny_zones_side_by_side(tiny, method):
    problem, truth = tiny
    problems = [random_zone(np.random.default_rng(8), 3), problem]
    call, read_result = own.prepare(problems, own.Setting(method).options(1e-9))
    first, second = read_result(call())
    assert truth.error(second.displacements) < 1e-4
    assert Truth(problems[0]).error(first.displacements) < 1e-4
    judged = residuals(problem, problem.proposed + second.displacements, second.multipliers)
    assert judged.solved(1e-9, 1e-9)


def test_the_truth_measures_errors(tiny):
    problem, truth = tiny
    assert truth.says == "exact"
    best = solve_zone(problem, tolerance=1e-12).displacements
    assert truth.error(best) < 1e-14
    assert truth.error(best * (1.0 + 1e-7)) == pytest.approx(1e-7, rel=1e-6)
    assert truth.error(np.full_like(best, np.nan)) == math.inf
    larger = random_zone(np.random.default_rng(9), 80, fresh_only=True)
    bound = Truth(larger)
    assert bound.says == "bound"
    assert 0.0 < bound.error(bound.high) < 1e-9


def test_measure_repeats_and_stops():
    calls = []
    timing = measure(lambda: calls.append(1), 3, 1.0)
    assert len(calls) >= 4
    assert timing.seconds <= timing.first_s or timing.seconds < 1e-3
    calls.clear()
    assert measure(lambda: calls.append(1), 3, 0.0).result is None
    assert len(calls) == 1, "a first call beyond the budget is not repeated"


@pytest.mark.parametrize("quick", [True, False])
def test_the_plan_has_every_direction_and_line_search_in_every_family(quick):
    chosen = [family for family in synthetic() if not quick or family.name in QUICK]
    cells = plan(chosen, quick)
    assert len(set(cells)) == len(cells)
    there = {(cell.family, cell.solver, cell.line_search) for cell in cells}
    for family in chosen:
        for direction in own.DIRECTIONS:
            for search in own.LINE_SEARCHES:
                assert (family.name, direction, search) in there
    assert {cell.solver for cell in cells} >= {*LIBRARY, *own.DUAL}


def _tiny_family():
    """Return a family of tiny zones; the number of a zone is its seed."""
    return Family("tiny", "tiny", 3, "", lambda n: random_zone(np.random.default_rng(n), 3), 2)


def test_the_study_leaves_no_cell_out_and_resumes(tmp_path, monkeypatch):
    monkeypatch.setattr(inner, "families", lambda quick: [_tiny_family()])
    said = []
    inner.run(tmp_path, True, said.append)
    rows = read(tmp_path, "inner")
    cells = plan([_tiny_family()], True)
    assert len(rows) == len(cells)
    for cell, row in zip(cells, rows, strict=True):
        assert Cell(*(row[name] for name in Cell._fields)) == cell
        assert row["outcome"] in ("converged", "not converged", "failed")
        assert row["outcome"] != "failed", row
        if row["seconds"] is None:
            assert row["message"].startswith("left out: "), row
    auto = [row for row in rows if row["solver"] == "auto"]
    assert all(row["reached"] == 1e-12 and row["error"] < 1e-12 for row in auto)
    assert len([row for row in rows if row["compile_s"] is not None]) > 1
    inner.run(tmp_path, True, said.append)
    assert len(read(tmp_path, "inner")) == len(rows)
    assert len(said) == 1


def test_a_solver_that_raises_is_a_row(monkeypatch):
    def broken(zone, tolerance, limit_s):
        raise RuntimeError("out of order")

    monkeypatch.setitem(LIBRARY, "PIQP", LIBRARY["PIQP"]._replace(prepare=broken))
    row = _row(Cell("tiny", "PIQP"), _tiny_family())
    assert row["outcome"] == "failed"
    assert row["message"] == "RuntimeError: out of order"


def test_a_wrong_answer_does_not_count_as_converged(monkeypatch):
    right = LIBRARY["PIQP"].prepare

    def wrong(zone, tolerance, limit_s):
        call, read_result = right(zone, tolerance, limit_s)
        return call, lambda result: read_result(result)._replace(z=1.1 * read_result(result).z)

    monkeypatch.setitem(LIBRARY, "PIQP", LIBRARY["PIQP"]._replace(prepare=wrong))
    row = _row(Cell("tiny", "PIQP"), _tiny_family())
    assert (row["outcome"], row["reached"], row["message"]) == ("not converged", None, None)
    assert row["error"] == pytest.approx(0.1, rel=1e-6)


def _past(*rows):
    """Return a past of the quick study with these rows."""
    return inner.Past(inner.QUICK, rows)


def _row(cell, family, *past):
    """Measure one cell, and return its row."""
    return inner.cell_row(cell, inner.Bench(family), inner.QUICK, _past(*past), set())


def test_a_solver_that_took_too_long_is_left_out_at_larger_sizes():
    cell = Cell("b", "PIQP", tolerance=1e-6)
    slow = Cell("a", "PIQP", tolerance=1e-6)._asdict() | {
        "series": "tiny", "size": 2, "call_s": 60.0, "outcome": "not converged"
    }  # fmt: skip
    family = _tiny_family()._replace(name="b")
    assert _past(slow).reason(cell, family) == "took 60.0 s at 2 impacts"
    assert _past(slow | {"call_s": 0.1}).reason(cell, family) is None
    assert _past(slow | {"series": "other"}).reason(cell, family) is None
    assert _past(slow).reason(cell._replace(solver="OSQP"), family) is None
    assert _past(slow).reason(cell, family._replace(size=1)) is None
    row = _row(cell, family, slow)
    assert row["outcome"] == "not converged"
    assert row["message"] == "left out: took 60.0 s at 2 impacts"


def test_convergence_rows_end_at_the_optimum_and_resume(tmp_path):
    rows = Rows(tmp_path, "convergence", convergence.KEYS)
    convergence.zone_curves(rows, "random-4", 4e4, lambda text: None)
    found = rows.all()
    curves = {tuple(row[name] for name in convergence.KEYS[2:5]) for row in found}
    assert curves == set(convergence.curves())
    assert not [row for row in found if row["outcome"] == "failed"]
    newton = [r for r in found if r["method"] == "newton" and r["line_search"] == "exact"]
    newton = sorted((r for r in newton if r["update"] == "every-step"), key=lambda row: row["step"])
    assert newton[0]["excess"] == -1.0
    assert newton[0]["violation"] > 0.0
    assert abs(newton[-1]["excess"]) < 1e-6
    convergence.zone_curves(rows, "random-4", 4e4, lambda text: None)
    assert len(rows.all()) == len(found)
