"""The study of slow steps: recipes, the search, and what is said about growth."""

import math

import numpy as np
import pytest

from validation.rows import Rows, read
from validation.study.stability_time import cells, slow_search
from validation.study.stability_time.measure import measured, score
from validation.study.stability_time.recipe import (
    GENES,
    KINDS,
    Recipe,
    described,
    mutated,
    recipe_of,
)
from validation.study.stability_time.shapes import step_of, thickness_of


def silent(text):
    """Take a line of text, and do nothing."""


def test_mutations_keep_the_bounds_and_depend_on_the_generator_alone():
    recipe = Recipe("sheets")
    for number in range(300):
        recipe = mutated(recipe, np.random.default_rng(number))
        for name, gene in GENES.items():
            value = getattr(recipe, name)
            assert gene.low <= value <= gene.high or (gene.zero and value == 0.0), name
    again = [mutated(recipe, np.random.default_rng(7)) for _ in range(2)]
    assert again[0] == again[1] != recipe


@pytest.mark.parametrize("kind", KINDS)
def test_recipes_make_free_starts_of_about_the_size_that_was_asked_for(kind):
    """A start that is not free raises an error in the scene."""
    recipe = Recipe(kind)
    for number in range(6):
        scene = step_of(recipe, 300, number)
        assert 0.5 * 300 <= len(scene.faces) <= 2.2 * 300
        assert thickness_of(recipe, scene) > 0.0
        recipe = mutated(recipe, np.random.default_rng(number))


def test_a_recipe_comes_back_from_its_row(tmp_path):
    recipe = mutated(Recipe("fan"), np.random.default_rng(3))
    Rows(tmp_path, "some", ("number",)).add(number=1, **recipe._asdict())
    assert recipe_of(read(tmp_path, "some")[0]) == recipe
    assert described(Recipe("fan")) == "fan"
    assert described(Recipe("fan", depth=2.0)) == "fan, depth 2"


def test_a_step_is_measured_in_its_own_process():
    row = measured(Recipe("soup"), 40, 30.0)
    assert row["outcome"] in ("converged", "not converged")
    assert row["free"]
    assert row["triangles"] == 40
    assert row["us_per_nlogn"] == pytest.approx(score(row["cpu_s"], 40))


def fake_measured(calls):
    """Return a `measured` whose time is the depth of the recipe."""

    def run(recipe, n_triangles, max_seconds):
        calls.append(recipe)
        return {"outcome": "converged", "us_per_nlogn": recipe.depth, "cut": False}

    return run


def test_a_search_goes_on_where_it_was_and_keeps_what_is_slow(tmp_path, monkeypatch):
    whole, parts = [], []
    monkeypatch.setattr(slow_search, "warm_up", lambda: None)
    monkeypatch.setattr(slow_search, "measured", fake_measured(whole))
    slow_search.search(tmp_path / "whole", silent, tries=90)
    monkeypatch.setattr(slow_search, "measured", fake_measured(parts))
    for tries in (3, 40, 90):
        slow_search.search(tmp_path / "parts", silent, tries=tries)
    assert whole == parts
    rows = read(tmp_path / "whole", slow_search.STUDY)
    assert [row["number"] for row in rows] == list(range(90))
    for kind in KINDS:
        best = slow_search.slowest(rows, slow_search.SEED, kind)
        assert best[0]["us_per_nlogn"] > Recipe(kind).depth
        assert best[0]["us_per_nlogn"] == max(r["depth"] for r in rows if r["kind"] == kind)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.5])
def test_powers_are_fitted_with_their_spread(exponent, rng):
    sizes = [100, 200, 400, 800]
    fit = cells.fit_power(sizes, [3.0 * n**exponent for n in sizes])
    assert fit.exponent == pytest.approx(exponent, abs=1e-12)
    assert fit.spread == pytest.approx(0.0, abs=1e-7)
    assert math.isnan(cells.fit_power([1, 2], [1.0, 2.0]).spread)
    fits = [
        cells.fit_power(sizes, np.asarray(sizes) ** exponent * np.exp(0.1 * rng.normal(size=4)))
        for _ in range(400)
    ]
    # the spread is the standard error: the exponents vary by it
    off = np.std([fit.exponent for fit in fits])
    assert off == pytest.approx(np.sqrt(np.mean([fit.spread**2 for fit in fits])), rel=0.25)
    assert 1.1 < cells.exponent_of_nlogn(sizes) < 1.2


def grown(power, stage, sizes=(1000, 2000, 4000, 8000), **changes):
    """Return rows of a recipe whose time is that of one stage, and grows with a power."""
    rows = []
    for n in sizes:
        seconds = 1e-6 * n**power
        row = dict.fromkeys(("detect_s", "certify_s", "solve_s", "judge_s"), 0.01 * seconds)
        row |= {stage: 0.9 * seconds, "cpu_s": seconds, "wall_s": seconds, "size": n}
        row |= {"candidates": n * n, "largest_zone": n, "impacts": n, "iterations": 3}
        row |= {"triangles": n, "us_per_nlogn": score(seconds, n), "outcome": "converged"}
        rows.append(row | {"cut": False, "free": True, "status": "FREE", "message": ""} | changes)
    return rows


def test_a_cell_says_whether_time_grows_faster_than_nlogn_and_why():
    row = cells.cell_of(grown(2.0, "detect_s"))
    assert row["faster_than_nlogn"] is True
    assert row["exponent"] == pytest.approx(2.0)
    assert row["cause"].startswith("detection takes 90 % of the time; candidate pairs of all")
    assert "as n^2.00" in row["cause"]
    row = cells.cell_of(grown(1.1, "solve_s"))
    assert row["faster_than_nlogn"] is False
    assert row["cause"].startswith("solving zones takes 90 %")
    assert row["all_free"]


def test_steps_that_were_cut_or_failed_do_not_count_as_growth():
    rows = grown(1.0, "solve_s", (1000, 2000)) + grown(0.0, "solve_s", (4000,), cut=True)
    rows += [{"size": 8000, "outcome": "failed", "message": "needs more than 1 s"}]
    row = cells.cell_of(rows)
    assert (row["sizes"], row["cut_at_size"], row["failed_at_size"]) == (2, 4000, 8000)
    assert row["exponent"] == pytest.approx(1.0)
    assert row["exponent_spread"] is None
    assert "too slow" in cells.cell_of(grown(1.0, "solve_s", (1000,)))["verdict"]
    failed = cells.cell_of(rows[-1:])
    assert failed["cause"] == "needs more than 1 s"


def test_cells_are_judged_from_the_rows_of_growth(tmp_path):
    rows = Rows(tmp_path, cells.GROWTH, ("cell", "size"))
    for row in grown(2.0, "solve_s"):
        rows.add(cell="hub, depth 1", **row)
    cells.judge_cells(tmp_path, silent)
    cells.judge_cells(tmp_path, silent)
    (row,) = read(tmp_path, cells.CELLS)
    assert row["cell"] == "hub, depth 1"
    assert row["faster_than_nlogn"] is True
