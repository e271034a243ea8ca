"""The report: what it names, what it hides, its verdict, and its files."""

import json
import re
import sys

import pytest

from izo_ref.app.cli import main
from izo_ref.porting.cases import case_line
from izo_ref.porting.conform.divergence import EVERY, first_divergence, report_record
from izo_ref.porting.conform.incidents import Incident
from izo_ref.porting.conform.protocol import Hello, Request
from izo_ref.porting.conform.report import Report, verdict_line
from izo_ref.porting.conform.run import Row, Run, failed, judged
from izo_ref.porting.conform.suspects import shown_suspects, suspects
from izo_ref.porting.conform.terminal import report_text
from izo_ref.porting.judge.outcome import (
    MALFORMED,
    NOT_RUN,
    NOT_SUPPORTED,
    PASSED,
    WRONG,
    Difference,
    Outcome,
)
from izo_ref.porting.stages import STAGE, STAGES
from tests.helpers import porting_cases as made
from validation import house

CASES = [made.clamp(f"S9-clamp-{i:02d}", (float(i), 0.5), (1.0, 0.25)) for i in range(1, 31)]
RIGHT = {case.id: case.expected["multipliers"]["values"] for case in CASES}


def row(case, change=None, dtype="f8", **reply):
    """Return the row of a reply that is right, or that a function changes."""
    values = RIGHT[case.id]
    output = {"multipliers": values if change is None else change(values)}
    return judged(Request(case, dtype), {"status": "ok", "output": output} | reply)


def run_of(*rows, stages=("S9",)):
    """Return a run of a port."""
    return Run(Hello("toy", "1", tuple(stages), ("f8",)), tuple(rows))


def scaled(values):
    """Return a wrong answer."""
    return [2.0 * value for value in values]


def first_of(rows):
    """Return the first divergence of rows."""
    first = first_divergence(Report(run_of(*rows)))
    assert first is not None
    return first


def crashed(case):
    """Return a row that crashed."""
    return Row(Request(case, "f8"), failed(Incident("crash", "the port crashed")))


MALFORMED_REPLIES = {
    "null": {"output": {"multipliers": None}},
    "missing": {"output": {}},
    "unknown": {"output": {"multipliers": [3.0, 1.0], "more": 1}},
    "too short": {"output": {"multipliers": [3.0]}},
    "nested": {"output": {"multipliers": [[3.0], [1.0]]}},
    "texts": {"output": {"multipliers": ["3.0", "1.0"]}},
    "NaN": {"output": {"multipliers": ["nan", 1.0]}},
    "a list of outputs": {"output": [1]},
    "no status": {"status": "fine"},
}


@pytest.mark.parametrize("form", MALFORMED_REPLIES)
def test_no_mistake_is_named_for_a_reply_of_the_wrong_form(form):
    bad = row(CASES[0], **MALFORMED_REPLIES[form])
    assert {difference.cause for difference in bad.outcome.differences} == {MALFORMED}
    rows = [bad, row(CASES[1])]
    assert suspects(rows, "S9") == []
    first = first_of(rows)
    assert (first["suspects"], first["hints"], first["cause"]) == ([], [], "malformed")


def test_no_mistake_is_named_for_a_crash_and_crashes_do_not_count():
    rows = [crashed(CASES[0]), row(CASES[1], scaled), row(CASES[2])]
    assert first_of(rows)["suspects"] == []
    ((flag, n_failed, n_judged, _),) = suspects(rows, "S9")
    assert (flag, n_failed, n_judged) == ("multipliers-not-clamped", 1, 2)


def test_mistakes_that_are_far_behind_the_first_one_are_not_named():
    other = [case._replace(flags=("kink",)) for case in CASES[10:16]]
    rows = [row(case, scaled) for case in CASES[:10]]
    rows += [row(other[0], scaled), *map(row, other[1:])]
    assert [item.flag for item in suspects(rows, "S9")] == ["multipliers-not-clamped", "kink"]
    assert [item.flag for item in shown_suspects(rows, "S9")] == ["multipliers-not-clamped"]


def test_the_report_says_first_that_every_case_fails():
    text = report_text(Report(run_of(*(row(case, scaled) for case in CASES[:3]))))
    assert text.index(EVERY[:40]) < text.index("where    multipliers (0)")
    assert "hint     The answer is 2 times the expected one in all 3 requests that fail." in text
    text = report_text(Report(run_of(row(CASES[0]), row(CASES[1], scaled))))
    assert EVERY[:40] not in text
    assert EVERY[:40] not in report_text(Report(run_of(row(CASES[0], scaled))))
    assert EVERY[:40] not in report_text(Report(run_of(crashed(CASES[0]), crashed(CASES[1]))))


def test_failing_requests_are_listed_and_many_are_counted():
    text = report_text(Report(run_of(*(row(case, scaled) for case in CASES[:2]))))
    assert "failing  S9-clamp-01 f8, S9-clamp-02 f8\n" in text
    rows = [row(case, scaled, dtype) for case in CASES for dtype in ("f8", "f4")]
    words = " ".join(report_text(Report(run_of(*rows))).split())
    assert "S9-clamp-10 f8+f4, and 40 more next" in words


def test_the_next_commands_can_be_copied():
    report = Report(run_of(row(CASES[0], scaled)), command=("--exec", "./my port"))
    text = report_text(report)
    assert "  next     izo vectors show S9-clamp-01\n" in text
    assert "           izo conform --exec './my port' --case S9-clamp-01 --dtype f8\n" in text


def test_columns_without_counts_and_stages_that_are_not_supported_are_hidden():
    pairs = Row(Request(made.pairs(), "f8"), Outcome(NOT_SUPPORTED))
    text = report_text(Report(run_of(row(CASES[0]), pairs)))
    assert "stage                 requests  passed  failed\n" in text
    assert "\nnot supported: S1\n" in text
    assert "S1 candidate pairs" not in text


def test_only_a_port_with_all_stages_conforms():
    passed = [Row(Request(case, "f8"), Outcome(PASSED)) for case in one_of_each_stage()]
    both = [*passed, *(Row(Request(row.request.case, "f4"), Outcome(PASSED)) for row in passed)]
    assert verdict_line(Report(run_of(*both, stages=STAGE))) == "The port conforms."
    only = verdict_line(Report(run_of(*passed, stages=STAGE)))
    assert only == "The port conforms. Only f8 was judged."
    absent = Row(Request(passed[0].request.case, "f8"), Outcome(NOT_SUPPORTED))
    said = verdict_line(Report(run_of(absent, *passed[1:])))
    assert said.startswith("Everything that was judged is right: S2, S3, ")
    assert said.endswith(" S13 (12 of 13 requests); 1 stage is not supported.")


def one_of_each_stage():
    """Return a case of each stage."""
    return [made.clamp()._replace(stage=stage.name) for stage in STAGES]


def test_the_verdict_counts_wrong_and_not_run_requests_apart():
    left = Outcome(NOT_RUN, (Difference("no-reply", "not asked"),))
    rows = [row(CASES[0], scaled), *(Row(Request(case, "f8"), left) for case in CASES[1:4])]
    said = verdict_line(Report(run_of(*rows)))
    assert said == "The port does not conform: 1 request is wrong, 3 requests were not run."


def test_numbers_that_the_sentence_says_are_not_repeated():
    text = report_text(Report(run_of(row(CASES[0], scaled))))
    assert "expected 3.0, got 6.0" in text
    assert "\n  expected" not in text
    difference = Difference("status", "the port refuses", (), "ok", "refused")
    wrong = Row(Request(CASES[0], "f8"), Outcome("failed", (difference, difference)))
    text = report_text(Report(run_of(wrong)))
    assert "  expected ok\n  got      refused\n  more     1 more difference in this case\n" in text


def test_numbers_of_properties_have_their_names():
    reply = {"status": "ok", "output": {"weights": [1, -0.5, -0.25, -0.25], "normal": [0, 0, -1]}}
    first = judged(Request(made.frame(), "f8"), reply).outcome.differences[0]
    assert first.quantity == "the gap at the start, at least"
    assert re.search(r"the gap at the start, .*: expected at least .*, got -", first.sentence)
    assert first.cause == WRONG


def test_huge_numbers_of_ulps_are_not_said():
    first = row(CASES[0], scaled).outcome.differences[0]
    assert "ulps" not in first.sentence
    near = row(CASES[0], lambda values: [values[0] + 1e-13, values[1]]).outcome.differences[0]
    assert "ulps" in near.sentence


def test_the_documentation_names_every_field_of_the_report():
    text = (house.ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")
    record = report_record(Report(run_of(row(CASES[0], scaled))))
    names = [*record, *record["first_divergence"], *record["cases"][0]]
    names += [*record["stages"]["S9"], *record["cases"][0]["differences"][0]]
    assert [name for name in names if f"`{name}`" not in text] == []
    assert not any(" " in name for name in names)


@pytest.fixture
def port(tmp_path):
    """Write vectors of S9 and a port that is right, and return the words that check it."""
    folder = tmp_path / "v1"
    folder.mkdir()
    for stage in STAGE:
        cases = CASES[:5] if stage == "S9" else []
        lines = ",\n".join(case_line(case) for case in cases)
        (folder / f"{stage}.json").write_text(f'{{"version":1,"cases":[{lines}]}}')
    program = tmp_path / "port.py"
    program.write_text(
        "import json, sys\n"
        f"RIGHT = {RIGHT!r}\n"
        "for line in sys.stdin:\n"
        "    request = json.loads(line)\n"
        "    print('log: one', file=sys.stderr, flush=True)\n"
        "    if 'hello' in request:\n"
        "        reply = dict(name='toy', version='1', stages=['S9'], dtypes=['f8'])\n"
        "    else:\n"
        "        output = dict(multipliers=RIGHT[request['id']])\n"
        "        reply = dict(id=request['id'], status='ok', output=output)\n"
        "    print(json.dumps(reply), flush=True)\n"
    )
    return ["conform", "--vectors", str(folder), "--exec", f"{sys.executable} {program}"]


def test_a_report_can_go_to_the_standard_output(port, capsys):
    assert main([*port, "--json", "-"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["right"] is True
    assert said.err.startswith("vectors: ")
    assert main([*port, "--html", "-"]) == 0
    assert capsys.readouterr().out.startswith("<!doctype html>")
    assert main([*port, "--html", "-", "--json", "-"]) == 2
    assert "--json and --html: only one report can go" in capsys.readouterr().err


def test_the_error_output_is_shown_if_asked_for(port, capsys):
    assert main([*port]) == 0
    assert "log: one" not in capsys.readouterr().err
    assert main([*port, "--show-errors"]) == 0
    assert "log: one\nlog: one\n" in capsys.readouterr().err


@pytest.mark.parametrize("word", ["S9", "s9", "9"])
def test_a_stage_may_be_named_in_short(port, capsys, word):
    assert main([*port, "--stage", word]) == 0
    assert "S9 (5 of 10 requests)" in capsys.readouterr().out
