"""The study of stability: its records, its judges, its rows, its map and its tables."""

import time
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from izo_ref.base.errors import ShapeError
from tests.helpers.shapes import two_sheets
from validation.ladders import judge_step as step_judge
from validation.ladders.judge_step import Case, Known, judge_step
from validation.ladders.judge_zone import EXACT, INFEASIBLE, condition_number, judge_zone
from validation.ladders.ladder import (
    NO_ANSWER,
    OWN,
    RIGHT,
    SAYS_SO,
    WRONG,
    Border,
    Ladder,
    Outcome,
    border,
)
from validation.oracles.answer import Answer
from validation.report import limits_table
from validation.report import stability as page
from validation.report.stability_map import map_svg, short
from validation.report.stability_rows import measured
from validation.rows import begin_run, read
from validation.scenes.zones import random_zone
from validation.study import stability
from validation.study.zones import one_impact

FALLING = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, 0.5]])
LANDED = FALLING - [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 1.0]]
FACE = np.array([[0, 1, 2]])


def outcome(rung):
    """Return a verdict by the size of a rung; another solver is wrong from 10 on."""
    verdict = RIGHT if rung < 100 else SAYS_SO if rung < 1000 else WRONG
    yield Outcome(verdict, "FREE" if verdict == RIGHT else "FREE_BY_FALLBACK", error=1e-12 * rung)
    yield Outcome(RIGHT if rung < 10 else WRONG, "success", "SLSQP", error=float(rung))


def named(kind):
    if kind == "hangs":
        time.sleep(60.0)
    if kind == "breaks":
        raise RuntimeError("a fault")
    return [Outcome(RIGHT, "FREE")]


NUMBERS = Ladder("stiff", "size", "It grows.", "metres", (1.0, 10.0, 1e2, 1e3), outcome, wanted=1e2)
KINDS = Ladder(
    "stiff", "kinds", "They vary.", "kind", ("plain", "hangs", "breaks"), named, seconds=0.5
)


@pytest.fixture
def rows(tmp_path, monkeypatch):
    """Return a folder with the rows of two ladders."""
    for module in ("study.stability", "report.stability_rows"):
        monkeypatch.setattr(f"validation.{module}.ladders", lambda family: [NUMBERS, KINDS])
    monkeypatch.setattr(stability, "warm_up", lambda: None)
    begin_run(tmp_path / "rows", "a test", False)
    said = []
    stability.ladder_rows("stiff", tmp_path / "rows", said.append)
    assert said == [
        "stiff: size: 2 right, 1 says so, 1 wrong",
        "stiff: kinds: 1 right, 1 no answer, 1 wrong",
    ]
    return tmp_path / "rows"


def test_a_border_is_before_the_first_rung_that_is_not_right():
    said = [(1.0, Outcome(RIGHT, "FREE")), (2.0, Outcome(SAYS_SO, "BLOCKED"))]
    assert border(said) == Border(1.0, 2.0, ("BLOCKED",))
    assert border(said[:1]) == Border(1.0, None, ())
    assert border(said[1:]) == Border(None, 2.0, ("BLOCKED",))


def test_a_study_goes_on_where_it_ended(rows):
    lines = (rows / "stiff.csv").read_text().splitlines()
    (rows / "stiff.csv").write_text("\n".join(lines[:5]) + "\n")
    stability.ladder_rows("stiff", rows, lambda line: None)
    keys = [(row["ladder"], row["rung"], row["by"]) for row in read(rows, "stiff")]
    assert len(keys) == len(set(keys)) == 2 * len(NUMBERS.rungs) + len(KINDS.rungs)


def test_what_hangs_or_breaks_is_a_row(rows):
    found = {m.ladder.name: dict(m.own) for m in measured(rows, "stiff")}
    assert found["kinds"]["hangs"].verdict == NO_ANSWER
    assert found["kinds"]["breaks"].verdict == WRONG
    assert "RuntimeError" in found["kinds"]["breaks"].status


def test_the_page_shows_borders_cells_and_other_solvers(rows, tmp_path):
    text = page.page(rows, tmp_path).read_text()
    assert "| size | metres | 10 | 100 | FREE_BY_FALLBACK | 100 MISSED |" in text
    assert "| kinds | kind | 1 of 3 kinds | hangs, breaks |" in text
    assert "| SLSQP | size | 1 | 0 | 0 | 0 | 3 | 1000 |" in text
    assert (tmp_path / "stiff.md").read_text().count("| izo_ref |") == 7
    assert page.headlines(rows)[0].figure == "2 of 7"
    assert "| size [metres] | to 10 | `FREE_BY_FALLBACK` |" in limits_table.borders(rows)


def test_a_map_has_a_cell_for_each_rung_and_a_sign_for_each_verdict(rows):
    root = ET.fromstring(map_svg("A map", measured(rows, "stiff")))
    words = [text.text or "" for text in root.iter("{http://www.w3.org/2000/svg}text")]
    assert {"1", "10", "100 !", "1000 ×", "plain", "hangs …", "breaks ×"} <= set(words)


@pytest.mark.parametrize(
    ("rung", "text"),
    [
        ("1e+06", "1e6"),
        ("1.00000000001", "1 + 1e-11"),
        ("0.499999999999", "0.5 - 1e-12"),
        ("0.333333333333", "0.33333"),
        ("4.94065645841e-324", "4.9407e-324"),
        ("1.0001", "1.0001"),
        ("a name", "a name"),
    ],
)
def test_a_cell_tells_its_rung_from_those_beside_it(rung, text):
    assert short(rung) == text


def test_without_rows_the_page_says_so(tmp_path):
    assert page.page(tmp_path, tmp_path).read_text().count("Not measured yet.") == 15
    assert page.headlines(tmp_path) == []
    assert limits_table.borders(tmp_path) == "Not measured yet.\n"


def test_the_table_of_limits_is_that_of_the_rows():
    text = limits_table.PAGE.read_text()
    assert text == limits_table.with_borders(text), "run: python -m validation readme"


def test_a_zone_is_judged_by_its_exact_optimum():
    problem = random_zone(np.random.default_rng(1), 8, 1e6)
    own, lazy, liar = judge_zone(
        problem,
        others={
            "lazy": lambda p: Answer(np.zeros_like(p.proposed), None, False, "no", 0.0),
            "liar": lambda p: Answer(np.zeros_like(p.proposed), None, True, "yes", 0.0),
        },
    )
    assert (own.verdict, own.status, own.by) == (RIGHT, "solved", OWN)
    assert own.note.startswith(EXACT)
    assert own.error is not None
    assert own.error < 1e-12
    assert (lazy.verdict, liar.verdict) == (SAYS_SO, WRONG)
    assert lazy.error == liar.error == 1.0


def test_a_zone_without_a_solution_is_right_if_it_is_called_so():
    both = one_impact(0.1)
    problem = type(both)(
        np.repeat(both.nodes, 2, axis=0),
        np.repeat(both.weights, 2, axis=0),
        [[0, 0, 1.0], [0, 0, -1.0]],
        both.proposed,
        both.masses,
        both.thickness,
    )
    (own,) = judge_zone(problem)
    assert (own.verdict, own.status, own.note) == (RIGHT, "not solved", INFEASIBLE)


def test_the_condition_number_is_that_of_the_gram_matrix():
    """Two rows at a right angle, with masses 1 and 4: the eigenvalues are 2 and 1/2, by hand."""
    nodes, weights = [[0, 1, 2, 3], [4, 5, 6, 7]], [[1.0, -1.0, 0, 0], [1.0, -1.0, 0, 0]]
    masses = [1.0, 1.0, 1.0, 1.0, 4.0, 4.0, 1.0, 1.0]
    problem = type(one_impact(0.1))(
        nodes, weights, [[0, 0, 1.0], [0, 0, 1.0]], np.zeros((8, 3)), masses, 1e-3
    )
    assert condition_number(problem) == pytest.approx(4.0, rel=1e-12)


def test_a_step_is_judged_by_what_is_known():
    landed = LANDED.copy()
    landed[:3, 2] = (-0.75 - 1e-3) * np.array([0.5, 0.25, 0.25]) / (1 + 0.375)
    case = Case(FALLING, LANDED, FACE, 1e-3)
    assert judge_step(case, Known())[0].verdict == RIGHT
    assert judge_step(case, Known(objective=1e-9))[0].verdict == WRONG
    assert judge_step(case, Known(statuses=("BLOCKED",)))[0].verdict == WRONG
    refused = judge_step(case._replace(end=LANDED[:3]), Known())[0]
    assert (refused.verdict, refused.status) == (SAYS_SO, ShapeError.__name__)
    assert judge_step(case._replace(end=LANDED[:3]), Known((ShapeError.__name__,)))[0].verdict == (
        RIGHT
    )


def test_a_path_that_is_not_free_is_refuted(monkeypatch):
    class Liar:
        """A result that claims that the proposed positions are free."""

        def __init__(self, result, scene):
            self._result, self.positions = result, scene.positions_t1

        def __getattr__(self, name):
            return getattr(self._result, name)

    real = step_judge.resolve
    monkeypatch.setattr(step_judge, "resolve", lambda scene, *a, **k: Liar(real(scene), scene))
    scene = two_sheets(np.random.default_rng(1))
    case = Case(scene.positions_t0, scene.positions_t1, scene.faces, 1e-3)
    found = judge_step(case, Known())[0]
    assert found.verdict == WRONG
    assert found.note.startswith("The path is not free")


@pytest.mark.parametrize("family", stability.FAMILIES)
def test_each_rung_of_a_ladder_has_a_row_of_its_own(family):
    for ladder in stability.ladders(family):
        texts = [stability.rung_text(rung) for rung in ladder.rungs]
        assert len(set(texts)) == len(texts), ladder.name
