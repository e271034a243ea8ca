"""Borders that were moved: the rungs on another core, and the table of both cores."""

import io
import json
import shutil

import pytest

from validation.ladders import rungs
from validation.ladders.ladder import NO_ANSWER, OWN, RIGHT, SAYS_SO, WRONG, Ladder, Outcome
from validation.provenance import ROOT
from validation.report import stability_before as page
from validation.report.stability_rows import Measured
from validation.rows import Rows, begin_run, read
from validation.study import stability_before as study
from validation.study.stability import KEYS

SIZES, NAMES = (1.0, 10.0, 1e2), ("plain", "odd")


def _run(rung):
    return [Outcome(RIGHT, "FREE", note=str(rung)), Outcome(WRONG, "success", "SLSQP")]


def _ladder(name, over=SIZES):
    return Ladder("stiff", name, "It grows.", "metres", over, _run)


LADDERS = [
    _ladder("grows"),
    _ladder("shrinks"),
    _ladder("stays"),
    _ladder("beyond both"),
    _ladder("kinds", NAMES),
    _ladder("half measured"),
]
# The rungs that are right, before and now.
BOTH = {
    "grows": ((1.0,), SIZES),
    "shrinks": ((1.0, 10.0), ()),
    "stays": ((1.0,), (1.0,)),
    "beyond both": ((1.0,), (1.0, 1e2)),
    "kinds": (("odd",), NAMES),
    "half measured": ((), SIZES),
}


@pytest.fixture
def rows(tmp_path, monkeypatch):
    """Return a folder with rows of both cores, of which one ladder has too few today."""
    monkeypatch.setattr("validation.report.stability_rows.ladders", lambda family: LADDERS)
    begin_run(tmp_path, "a test", False)
    before, now = Rows(tmp_path, "before", KEYS), Rows(tmp_path, "stiff", KEYS)
    for ladder in LADDERS:
        for rung in ladder.rungs:
            key = {"family": "stiff", "ladder": ladder.name, "rung": rungs.rung_text(rung)}
            right = [rung in found for found in BOTH[ladder.name]]
            outcomes = [
                Outcome(RIGHT, "FREE", error=1e-12) if is_right else Outcome(SAYS_SO, "BLOCKED")
                for is_right in right
            ]
            before.add(**key, **outcomes[0]._replace(by=f"{OWN} abc1234")._asdict())
            if ladder.name != "half measured" or rung == 1.0:
                now.add(**key, **outcomes[1]._asdict())
    return tmp_path


def test_the_table_has_the_borders_that_differ(rows, monkeypatch):
    monkeypatch.setattr(page, "MOVED_BY", {"gr": "A change of the core (1234567)."})
    text = page.section(rows)
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    assert lines[1:] == [
        "| grows | metres | 1 | 100 | 10 | BLOCKED | FREE, error 1.0e-12 | 2 "
        "| A change of the core (1234567). |",
        f"| shrinks | metres | 10 | no rung | 1 | FREE, error 1.0e-12 | BLOCKED | -2 "
        f"| {page.UNKNOWN} |",
        f"| kinds | metres | 1 of 2 kinds | 2 of 2 kinds | plain | BLOCKED | FREE, error 1.0e-12 "
        f"| 1 | {page.UNKNOWN} |",
    ]
    assert "at commit abc1234" in text
    assert "5 ladders were measured on both cores, and the border of 2 is where it was." in text
    assert "Ladders without all rungs of both cores: 1." in text


def test_a_rung_without_an_answer_moves_no_border():
    right, none = Outcome(RIGHT, "FREE"), Outcome(NO_ANSWER, "no answer")
    ladder = Measured(LADDERS[0], [("1", right), ("10", none), ("100", none)], {}, set(), 0)
    before = [("1", right), ("10", right), ("100", none)]
    assert page.Pair(ladder, before).differing is None


def test_each_cause_is_that_of_a_ladder():
    names = [ladder.name for family in study.CHOSEN for ladder in rungs.ladders(family)]
    for cause in page.MOVED_BY:
        assert any(name.startswith(cause) for name in names), cause


def test_without_rows_of_the_other_core_the_section_says_so(rows):
    (rows / "before.csv").unlink()
    assert page.section(rows) == f"{page.HEADING}\n\nNot measured yet."


def test_each_question_is_answered_by_our_own_outcome(monkeypatch):
    monkeypatch.setattr(rungs, "ladders", lambda family: LADDERS)
    monkeypatch.setattr(rungs, "warm_up", lambda: None)
    questions = io.StringIO('["grows", "100"]\n["kinds", "odd"]\n')
    answers = io.StringIO()
    rungs.answer("stiff", questions, answers)
    file, *found = answers.getvalue().splitlines()
    assert file == str(ROOT / "izo_ref" / "__init__.py")
    assert [Outcome(*json.loads(line)) for line in found] == [
        Outcome(RIGHT, "FREE", note="100.0"),
        Outcome(RIGHT, "FREE", note="odd"),
    ]


def test_a_process_imports_the_core_of_its_folder(tmp_path):
    shutil.copytree(ROOT / "izo_ref", tmp_path / "izo_ref")
    with study._process("stiff", tmp_path) as process:
        assert process.stdout is not None
        assert process.stdout.readline().strip() == str(tmp_path / "izo_ref" / "__init__.py")
        process.kill()


def test_rungs_with_a_row_are_not_run_again(rows, monkeypatch):
    asked = []
    monkeypatch.setattr(study, "BY", f"{OWN} abc1234")
    monkeypatch.setattr(study, "CHOSEN", ("stiff",))
    longer = _ladder("takes long")._replace(seconds=study.LONGEST_S + 1.0)
    monkeypatch.setattr(study, "ladders", lambda family: [*LADDERS, longer])
    monkeypatch.setattr(study, "_add", lambda rows, family, keys, core: asked.append(keys))
    monkeypatch.setattr(study, "_unpack", lambda core: True)
    study.before_rows(rows, lambda line: None)
    assert asked == []
    lines = (rows / "before.csv").read_text().splitlines(keepends=True)
    (rows / "before.csv").write_text("".join(line for line in lines if "plain" not in line))
    study.before_rows(rows, lambda line: None)
    assert asked == [[("kinds", "plain")]]


def test_without_the_commit_nothing_is_measured(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "COMMIT", "0" * 40)
    said = []
    study.before_rows(tmp_path, said.append)
    assert "the history here has no commit" in said[0]
    assert read(tmp_path, "before") == []
