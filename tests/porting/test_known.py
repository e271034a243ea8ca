"""Known failures: the file, and what does not agree with it any more."""

import pytest

from izo_ref.base.errors import FileFormatError
from izo_ref.porting.conform.known import compare, known_text, read_known
from izo_ref.porting.conform.protocol import Request
from izo_ref.porting.conform.report import Report, stage_counts, verdict_line
from izo_ref.porting.conform.run import Row, Run
from izo_ref.porting.conform.terminal import report_text
from izo_ref.porting.judge.outcome import FAILED, NOT_SUPPORTED, PASSED, Difference, Outcome
from tests.helpers import porting_cases as made

CASE = made.optimum()
KEY = (CASE.id, "f8")


def row(*outputs, result=None, case=CASE):
    """Return a row that fails in some outputs, or passes if there are none."""
    differences = tuple(Difference(name, f"{name} is wrong # very") for name in outputs)
    return Row(Request(case, "f8"), Outcome(result or (FAILED if outputs else PASSED), differences))


def written(tmp_path, text):
    """Return what is read from a file with a text."""
    path = tmp_path / "known.txt"
    path.write_text(text)
    return read_known(path, {CASE.id, "S9-clamp-01"})


def test_a_file_that_was_written_makes_its_run_known(tmp_path):
    rows = [row("positions", "multipliers"), row("crash", case=made.clamp())]
    known = written(tmp_path, known_text(rows))
    assert known == {KEY: {"positions", "multipliers"}, ("S9-clamp-01", "f8"): {"crash"}}
    compared = compare(rows, known)
    assert compared.problems == ()
    assert compared.known == known.keys()


def test_comments_and_blank_lines_are_no_entries(tmp_path):
    text = f"# all\n\n   \n{CASE.id} f8 positions # too deep\n{CASE.id}\tf8  multipliers\n"
    assert written(tmp_path, text) == {KEY: {"positions", "multipliers"}}


@pytest.mark.parametrize(
    ("now", "said", "is_known"),
    [
        (row("positions"), None, True),
        (row(), "passes now", False),
        (row("multipliers"), "fails in multipliers", False),
        (row("positions", "multipliers"), "fails in multipliers", False),
        (row("crash"), "fails in crash", False),
        (row(result=NOT_SUPPORTED), None, False),
    ],
)
def test_what_is_not_true_any_more_is_reported(now, said, is_known):
    compared = compare([now], {KEY: {"positions"}})
    assert (KEY in compared.known) == is_known
    if said is None:
        assert compared.problems == ()
    else:
        (problem,) = compared.problems
        assert said in problem


def test_an_output_of_two_that_does_not_fail_any_more_is_reported():
    compared = compare([row("positions")], {KEY: {"positions", "multipliers"}})
    assert "multipliers does not fail any more" in compared.problems[0]


def test_a_port_with_known_failures_alone_conforms():
    run = Run(None, (row("positions"), row(case=made.clamp())))
    report = Report(run, compare(run.rows, {KEY: {"positions"}}))
    assert report.is_right
    assert stage_counts(report)["S11"]["known"] == 1
    assert stage_counts(report)["S11"]["failed"] == 0
    assert "is right, but for 1 known failure: S9, S11 (2 of 2 requests)." in report_text(report)
    assert not Report(run).is_right


def test_a_known_failure_that_passes_now_makes_the_port_not_conform():
    run = Run(None, (row(),))
    report = Report(run, compare(run.rows, {KEY: {"positions"}}))
    assert not report.is_right
    assert verdict_line(report) == "The list of known failures is out of date."


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"{CASE.id} f8\n", "line 1"),
        (f"\n{CASE.id} f16 positions\n", "line 2"),
        (f"{CASE.id} f8 positions too deep\n", "expected 'case-id"),
        ("S11-none-01 f8 positions\n", "there is no case S11-none-01"),
    ],
)
def test_a_line_of_another_format_is_refused(tmp_path, text, said):
    with pytest.raises(FileFormatError, match=said):
        written(tmp_path, text)


def test_a_file_that_cannot_be_read_is_refused(tmp_path):
    with pytest.raises(FileFormatError, match="cannot be read"):
        read_known(tmp_path, set())
    (tmp_path / "known.txt").write_bytes(b"\xff\n")
    with pytest.raises(FileFormatError, match="UTF-8"):
        read_known(tmp_path / "known.txt", set())


def test_any_name_of_an_output_that_a_port_gives_can_be_written_and_read(tmp_path):
    rows = [row("# bad name\n\ud800"), row("", case=made.clamp())]
    known = written(tmp_path, known_text(rows))
    assert compare(rows, known).problems == ()
    assert len(compare(rows, known).known) == 2
