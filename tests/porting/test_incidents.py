"""Incidents: output that nobody asked for, repeated ones, and what the error output says."""

import sys

import pytest

from izo_ref.porting.conform import incidents, session
from izo_ref.porting.conform.divergence import first_divergence
from izo_ref.porting.conform.report import Report, verdict_line
from izo_ref.porting.conform.run import Choice, requests_of, run_program
from izo_ref.porting.conform.terminal import report_text
from izo_ref.porting.conform.text import last_lines
from izo_ref.porting.judge.outcome import FAILED, NOT_RUN, NOT_SUPPORTED, PASSED
from tests.helpers import porting_cases as made

# A right port of S9. What stands for {before}, {reply} and {after} runs for each request.
PORT = """
import json, os, sys, time
n = 0
def say(text, flush=True):
    print(text, flush=flush)
for line in sys.stdin:
    request = json.loads(line)
    if "hello" in request:
        say(json.dumps(dict(name="toy", version="1", stages=["S9"], dtypes=["f8"])))
        {hello}
        continue
    n += 1
    i, number = request["input"], float.fromhex
    new = [max(number(l) + number(i["penalty"]) * number(c), 0.0)
           for l, c in zip(i["multipliers"], i["constraints"])]
    reply = json.dumps(dict(id=request["id"], status="ok", output=dict(multipliers=new)))
    {before}
    say(reply)
    {after}
"""
CASES = [made.clamp(f"S9-clamp-{i:02d}", (float(i),), (1.0,)) for i in range(1, 8)]
REQUESTS = requests_of(CASES, Choice(dtypes=["f8"]))


@pytest.fixture
def ask(tmp_path, monkeypatch):
    """Return a function that runs a port with some lines in it."""

    def run(before="", after="", hello="", requests=REQUESTS, **options):
        if after or hello:  # a busy machine may let the port wait before it writes more
            monkeypatch.setattr(session, "FIRST_SURPLUS_S", 0.3)
        path = tmp_path / "port.py"
        path.write_text(PORT.format(before=before, after=after, hello=hello))
        return run_program([sys.executable, str(path)], requests, **options)

    return run


def results(run):
    """Return the result of each row."""
    return [row.outcome.result for row in run.rows]


def kinds(run):
    """Return the first difference of each row that failed."""
    return [row.outcome.differences[0].output for row in run.rows if row.outcome.result == FAILED]


@pytest.mark.parametrize(
    ("lines", "kind"),
    [
        ({"after": "say('debug')"}, incidents.SEVERAL),
        ({"after": "say(f'debug {n}')"}, incidents.SEVERAL),
        ({"after": "time.sleep(0.005); say('debug')"}, incidents.SEVERAL),
        ({"before": "say('debug')"}, incidents.GARBAGE),
        ({"before": "say('debug', flush=False)"}, incidents.GARBAGE),
        ({"before": "os._exit(3)"}, incidents.CRASH),
        ({"before": "reply = reply.replace('S9-', 'S8-')"}, incidents.WRONG_ID),
    ],
)
def test_the_run_stops_after_three_incidents_of_the_same_kind(ask, lines, kind):
    run = ask(**lines)
    assert results(run) == [FAILED] * 3 + [NOT_RUN] * 4
    assert kinds(run) == [kind] * 3
    assert run.notes == (f"stopped after 3 incidents of the same kind in a row: {kind}",)
    said = verdict_line(Report(run))
    assert said == "The port does not conform: 3 requests are wrong, 4 requests were not run."


def test_hangs_in_a_row_stop_the_run(ask):
    run = ask(before="time.sleep(60)", seconds=1.5)
    assert results(run) == [FAILED] * 3 + [NOT_RUN] * 4


def test_incidents_with_right_replies_between_them_do_not_stop_the_run(ask):
    run = ask(before="if request['id'] in ('S9-clamp-02', 'S9-clamp-04', 'S9-clamp-06'): exit(3)")
    assert results(run) == [PASSED, FAILED, PASSED, FAILED, PASSED, FAILED, PASSED]
    assert run.notes == ()


def test_what_a_port_does_not_have_is_not_counted_as_not_run(ask):
    requests = [*REQUESTS[:4], *requests_of([made.optimum()], Choice(dtypes=["f8"]))]
    run = ask(before="os._exit(3)", requests=requests)
    assert results(run) == [FAILED] * 3 + [NOT_RUN, NOT_SUPPORTED]


@pytest.mark.parametrize("lines", [{"before": "say('debug')"}, {"after": "say('debug')"}])
def test_a_print_gets_the_advice_to_use_standard_error(ask, lines):
    (difference, *_) = ask(**lines).rows[0].outcome.differences
    assert (
        "standard output is for replies alone: print everything else to st" in difference.sentence
    )


def test_a_line_before_the_reply_is_told_from_garbage_in_its_place(ask):
    run = ask(before="say('debug')")
    assert run.rows[0].outcome.differences[0].sentence.endswith("the next line is the reply")
    run = ask(before="reply = 'debug'")
    assert "next line" not in run.rows[0].outcome.differences[0].sentence


def test_a_line_behind_the_introduction_is_named(ask):
    run = ask(hello="say('ready')")
    assert (run.port, run.rows) == (None, ())
    assert "another line after its introduction: 'ready'" in run.notes[0]


def test_an_incident_shows_the_last_lines_of_the_error_output(ask):
    run = ask(before="print('step 1\\tof 2', file=sys.stderr); raise ValueError('no such zone')")
    shown = run.rows[0].outcome.differences[0].error_output.splitlines()
    assert shown[0] == "step 1  of 2"
    assert shown[1] == "Traceback (most recent call last):"
    assert shown[-1] == "ValueError: no such zone"
    text = report_text(Report(run))
    assert "\n  the last lines of its error output:\n    step 1  of 2\n    Traceback" in text
    first = first_divergence(Report(run))
    assert first is not None
    assert first["error_output"].endswith("no such zone")


def test_the_error_output_of_a_port_that_does_not_introduce_itself_is_in_the_note(ask):
    run = ask(hello="", requests=[])
    assert run.notes == ()
    run = run_program([sys.executable, "-c", "import no_such_module"], REQUESTS)
    assert run.notes[0].startswith("the first exchange, crash: the port ended with exit code 1")
    assert "\n  the last lines of its error output:\n  Traceback" in run.notes[0]
    assert "No module named 'no_such_module'" in run.notes[0]


def test_of_a_long_error_output_the_last_lines_are_kept():
    data = "".join(f"line {i}\n" for i in range(30)).encode()
    assert last_lines(data).splitlines() == ["...", *(f"line {i}" for i in range(10, 30))]
    assert last_lines(b"half\nwhole\n", cut=True) == "...\nwhole"
    assert last_lines(b"\x1b[31mred\xff\n\n") == r"\x1b[31mred\xff"
    assert last_lines(b"") == ""
