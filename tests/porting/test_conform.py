"""The harness: ports that answer, and ports that misbehave in every way."""

import json
import os
import re
import sys
import time

import pytest

from izo_ref.app.cli import main
from izo_ref.porting.cases import case_line
from izo_ref.porting.conform import incidents, program
from izo_ref.porting.conform.protocol import object_of, request_line
from izo_ref.porting.conform.run import Choice, requests_of, run_program
from izo_ref.porting.flags import FLAG
from izo_ref.porting.judge.outcome import FAILED, NOT_RUN, NOT_SUPPORTED, PASSED
from izo_ref.porting.stages import STAGE
from tests.helpers import porting_cases as made

# A right port of S9; `{bad}` runs before it answers a request, with `line` and `n`, its number.
PORT = """
import json, os, signal, sys, time
HELLO = dict(name="toy", version="1", stages=["S9"], dtypes=["f8"])
def say(record):
    print(json.dumps(record), flush=True)
def answer(request):
    i = request["input"]
    number = float.fromhex
    new = [max(number(l) + number(i["penalty"]) * number(c), 0.0)
           for l, c in zip(i["multipliers"], i["constraints"])]
    return dict(id=request["id"], status="ok", output=dict(multipliers=new))
{hello}
for n, line in enumerate(sys.stdin):
    request = json.loads(line)
    if n == 0:
        say(HELLO)
        continue
    good = answer(request)
{bad}
    say(good)
"""
FIRST, BAD, LAST = (made.clamp(f"S9-clamp-{i:02d}", (float(i),), (1.0,)) for i in (1, 2, 3))
CASES = [FIRST, BAD, LAST]
REQUESTS = requests_of(CASES, Choice(dtypes=["f8"]))


@pytest.fixture
def port(tmp_path):
    """Return a function that writes a port and returns its words."""

    def write(bad="pass", hello=""):
        path = tmp_path / "port.py"
        lines = "".join(f"    {line}\n" for line in bad.splitlines())
        path.write_text(PORT.format(bad=lines, hello=hello))
        return [sys.executable, str(path)]

    return write


def results(run):
    """Return the result of each row."""
    return [row.outcome.result for row in run.rows]


def only_incident(run):
    """Return the only difference of a run in which everything else passes."""
    (difference,) = [item for row in run.rows for item in row.outcome.differences]
    return difference


def test_a_right_port_passes(port):
    run = run_program(port(), REQUESTS)
    assert results(run) == [PASSED] * 3
    assert (run.port.name, run.port.stages, run.notes, run.restarts) == ("toy", ("S9",), (), 0)


def test_what_a_port_does_not_name_is_not_supported_and_not_asked(port):
    requests = requests_of([*CASES, made.pairs()], Choice())
    run = run_program(port(), requests)
    by_result = {row.request.key: row.outcome.result for row in run.rows}
    assert len(by_result) == 8
    assert by_result["S1-pairs-01", "f8"] == NOT_SUPPORTED
    assert by_result["S9-clamp-01", "f4"] == NOT_SUPPORTED
    assert by_result["S9-clamp-01", "f8"] == PASSED


def test_a_request_is_one_line_as_the_protocol_says():
    line = request_line(REQUESTS[0])
    assert line == (
        b'{"id":"S9-clamp-01","stage":"S9","dtype":"f8","input":{"multipliers":["0x1p+0"],'
        b'"constraints":["0x1p+0"],"penalty":"0x1p+1"}}\n'
    )


AT_BAD = f'if request["id"] == "{BAD.id}":\n    '
MISBEHAVIOUR = {
    "crash": ("os.kill(os.getpid(), signal.SIGTERM)", incidents.CRASH, "crashed before it answ"),
    "exception": ("raise ValueError('no such zone')", incidents.CRASH, "ValueError: no such zone"),
    "exit": ("os._exit(0)", incidents.CRASH, "ended with exit code 0"),
    "half a line": ("os.write(1, b'{'); os._exit(3)", incidents.CRASH, "in the middle of the line"),
    "killed": ("os.kill(os.getpid(), signal.SIGKILL)", incidents.MEMORY, "memory is short"),
    "garbage": ("print('debug', flush=True)", incidents.GARBAGE, "got 'debug'"),
    "escape": (r"print('\x1b[2J', flush=True)", incidents.GARBAGE, r"x1b[2J"),
    "rubbish": (r"os.write(1, b'\xff\xfe\n')", incidents.GARBAGE, "not UTF-8"),
    "surrogate": (r"""os.write(1, b'"\\ud800"\n')""", incidents.GARBAGE, "JSON object"),
    "deep": ("os.write(1, b'[' * 10**5 + b'\\n')", incidents.GARBAGE, "one line of JSON"),
    "two lines": ("say(good)", incidents.SEVERAL, "another line"),
    "wrong id": ("good['id'] = 'S9-x'", incidents.WRONG_ID, 'got "S9-x"'),
    "id is a list": ("good['id'] = [1]", incidents.WRONG_ID, "got [1]"),
    "wrong order": (f"good['id'] = '{LAST.id}'", incidents.ORDER, "must be in order"),
    "closed": ("os.close(1); time.sleep(60)", incidents.CLOSED, "closed its output"),
    "flood": ("while True: os.write(1, b'x' * 65536)", incidents.FLOOD, "without the end"),
    "flood of lines": ("while True: os.write(1, b'x\\n' * 999)", incidents.GARBAGE, "got 'x'"),
    "flood of errors": ("while True: os.write(2, b'y' * 65536)", incidents.FLOOD, "error output"),
}


@pytest.mark.parametrize("way", MISBEHAVIOUR)
def test_misbehaviour_is_reported_with_its_case_and_the_others_are_judged(port, way):
    code, kind, said = MISBEHAVIOUR[way]
    run = run_program(port(AT_BAD + code), REQUESTS, seconds=60.0)
    assert results(run) == [PASSED, FAILED, PASSED]
    assert only_incident(run).output == kind
    assert said in only_incident(run).sentence + only_incident(run).error_output
    assert only_incident(run).sentence.isprintable()
    assert (run.restarts, run.notes) == (1, ())


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("time.sleep(60)", "must flush"),
        ("os.write(1, b'{'); time.sleep(60)", "no end of the line"),
        ("os.close(0); time.sleep(60)", "no complete line"),
    ],
)
def test_a_port_that_hangs_is_ended_and_reported(port, code, said):
    run = run_program(port(AT_BAD + code), REQUESTS, seconds=2.0)
    assert only_incident(run).output == incidents.HANG
    assert said in only_incident(run).sentence
    assert results(run) == [PASSED, FAILED, PASSED]


def test_a_port_that_does_not_read_its_input_does_not_stop_the_harness(port):
    big = made.clamp("S9-clamp-09", (1.0,) * 50000, (1.0,) * 50000)
    hello = "sys.stdin.readline(); say(HELLO); time.sleep(60)"
    run = run_program(port(hello=hello), requests_of([big], Choice(dtypes=["f8"])), seconds=1.5)
    assert "has not read its input" in only_incident(run).sentence


def test_a_second_line_that_comes_late_counts_for_the_case_that_it_answers(port):
    code = AT_BAD + "import threading; threading.Timer(0.4, say, [good]).start()\n"
    code += f'if request["id"] == "{LAST.id}":\n    time.sleep(1)'
    run = run_program(port(code), REQUESTS, seconds=60.0)
    assert results(run) == [PASSED, FAILED, PASSED]
    assert only_incident(run).output == incidents.SEVERAL


def test_a_second_line_for_the_last_case_is_seen_too(port):
    code = f'if request["id"] == "{LAST.id}":\n    say(good)'
    run = run_program(port(code), REQUESTS, seconds=60.0)
    assert results(run) == [PASSED, PASSED, FAILED]
    assert only_incident(run).output == incidents.SEVERAL


def test_children_of_a_port_are_ended_with_it(port, tmp_path):
    path = tmp_path / "pid"
    code = (
        "import subprocess\n"
        "child = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'])\n"
        f"open({str(path)!r}, 'w').write(str(child.pid))\n"
        "time.sleep(60)"
    )
    run_program(port(code), REQUESTS[:1], seconds=2.0)
    pid = int(path.read_text())
    for _ in range(100):
        if not is_running(pid):
            return
        time.sleep(0.05)
    raise AssertionError("the child still runs")


def is_running(pid):
    """Return whether a process runs; one that has ended may still be listed as a zombie."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_port_may_end_after_each_case_up_to_the_limit_of_restarts(port):
    code = "say(good)\nos._exit(0)"
    requests = requests_of([made.clamp(f"S9-clamp-{i:02d}") for i in range(8)], Choice())
    requests = [request for request in requests if request.dtype == "f8"]
    run = run_program(port(code), requests, restarts=3)
    # the first case of each start is right, and the next one finds that the program has ended
    assert results(run) == [PASSED, FAILED] * 4
    run = run_program(port(code), requests, restarts=2)
    assert results(run) == [PASSED, FAILED] * 3 + [NOT_RUN] * 2
    assert "started again 2 times" in run.rows[-1].outcome.differences[0].sentence


@pytest.mark.parametrize(
    ("hello", "said"),
    [
        ("os._exit(0)", "crash: the port ended with exit code 0"),
        ("time.sleep(60)", "hang: no complete line"),
        ("HELLO.pop('version')", "hello: the first line must have a text 'version'"),
        ("HELLO['name'] = 5", "hello: the first line must have a text 'name'"),
        ("HELLO['stages'] = ['s9']", "hello: the first line must have a list 'stages'"),
        ("HELLO['stages'] = [['S9']]", "hello: the first line must have a list 'stages'"),
        ("HELLO['dtypes'] = 'f8'", "hello: the first line must have a list 'dtypes'"),
        ("HELLO['dtypes'] = []", "hello: the first line must have a list 'dtypes'"),
        ("print('hi')", "garbage: expected one line of JSON"),
        ("HELLO = [1]", "garbage: expected a JSON object"),
    ],
)
def test_a_port_that_does_not_introduce_itself_is_not_asked(port, hello, said):
    run = run_program(port(hello=hello), REQUESTS, seconds=2.0)
    assert (run.port, run.rows) == (None, ())
    assert said in run.notes[0]


def test_a_slow_start_within_the_limit_is_fine(port):
    assert results(run_program(port(hello="time.sleep(0.5)"), REQUESTS)) == [PASSED] * 3


def test_a_port_that_does_not_end_or_not_well_is_noted(port):
    again = "import atexit; atexit.register(lambda: {})".format
    run = run_program(port(hello=again("time.sleep(60)")), REQUESTS, seconds=2.0)
    assert results(run) == [PASSED] * 3
    assert run.notes[0].startswith("hang: the program does not end")
    run = run_program(port(hello=again("os._exit(5)")), REQUESTS)
    assert run.notes[0].startswith("crash: the port ended with exit code 5 after the end")


@pytest.mark.skipif(sys.platform != "linux", reason="macOS does not limit the address space")
def test_a_port_that_needs_more_memory_than_it_may_have_is_reported(port):
    run = run_program(port(AT_BAD + "x = bytearray(2**31)"), REQUESTS, gib=1.0)
    assert results(run) == [PASSED, FAILED, PASSED]
    assert only_incident(run).output == incidents.MEMORY
    assert "of 1 GiB (--gib)" in only_incident(run).sentence


def test_what_is_kept_of_a_flood_is_bounded(port, monkeypatch):
    monkeypatch.setattr(program, "LONGEST_LINE", 1 << 20)
    run = run_program(port(AT_BAD + "while True: os.write(1, b'x' * 65536)"), REQUESTS)
    assert only_incident(run).output == incidents.FLOOD
    assert len(only_incident(run).sentence) < 1000


def test_a_wrong_element_does_not_end_the_program(port):
    code = AT_BAD + "good['output']['multipliers'][0] += 1"
    run = run_program(port(code), REQUESTS)
    assert (results(run), run.restarts) == ([PASSED, FAILED, PASSED], 0)


@pytest.fixture
def vectors(tmp_path):
    """Write vectors of two stages, and return their folder."""
    folder = tmp_path / "v1"
    folder.mkdir()
    cases = [*CASES, made.pairs()]
    for stage in STAGE:
        lines = ",\n".join(case_line(case) for case in cases if case.stage == stage)
        (folder / f"{stage}.json").write_text(f'{{"version":1,"cases":[{lines}]}}')
    return folder


def conform(vectors, *words):
    """Run the command and return its exit code."""
    return main(["conform", "--vectors", str(vectors), *map(str, words)])


def shell(words):
    """Return words as one command."""
    return " ".join(words)


NO_MAX = "good['output']['multipliers'][0] -= 8.0"


def test_the_command_prints_a_table_and_the_first_divergence(port, vectors, capsys):
    assert conform(vectors, "--exec", shell(port())) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"vectors: {vectors}, 8 requests\n")
    assert re.search(r"^stage +requests  passed  failed  not supported$", said, re.M)
    assert re.search(r"^S9 multiplier update +6 +3 +0 +3$", said, re.M)
    assert "\nnot supported: S1\n" in said
    assert said.endswith("is right: S9 (3 of 8 requests); 1 stage is not supported.\n")
    assert conform(vectors, "--exec", shell(port(AT_BAD + NO_MAX))) == 1
    said = capsys.readouterr().out
    assert "First divergence: S9 multiplier update, case S9-clamp-02, f8" in said
    assert "multipliers (0)" in said
    assert "expected 4.0, got -4.0" in said
    assert "expected 4.0 (0x1p+2)" not in said  # the sentence says it
    flag = FLAG["multipliers-not-clamped"]
    words = " ".join(said.split())
    assert "multipliers-not-clamped (1 of the 3 requests that catch it fail): " in words
    assert f"{flag.mistake} harm {flag.harm}" in words
    assert f"izo vectors show {BAD.id} --folder {vectors}\n" in said
    assert f"--case {BAD.id} --dtype f8\n" in said
    assert "izo_ref/solvers/serial/lagrangian.py:" in said
    assert said.endswith("The port does not conform: 1 request is wrong.\n")


def test_reports_are_complete_and_what_the_port_wrote_is_escaped(port, vectors, tmp_path):
    hello = r"HELLO['name'] = '<script>alert(1)</script>\x1b[31m\ud800'"
    code = AT_BAD + r"print('</p><img src=x onerror=alert(2)>', flush=True)"
    words = ["--json", tmp_path / "r.json", "--html", tmp_path / "r.html"]
    assert conform(vectors, "--exec", shell(port(code, hello)), *words) == 1
    record = json.loads((tmp_path / "r.json").read_text())
    assert record["stages"]["S9"] | {"passed": 2, "failed": 1} == record["stages"]["S9"]
    assert record["first_divergence"]["case"] == BAD.id
    assert [row["result"] for row in record["cases"]].count("not supported") == 5
    page = (tmp_path / "r.html").read_text()
    assert "<script" not in page
    assert "<img" not in page
    assert "http" not in page
    assert "&lt;script&gt;" in page
    assert "\x1b" not in page


def test_filters_choose_the_cases(port, vectors, capsys):
    words = ["--exec", shell(port())]
    assert conform(vectors, *words, "--stage", "s9", "--dtype", "f8", "--case", BAD.id) == 0
    assert re.search(r"^S9 multiplier update +1 +1 ", capsys.readouterr().out, re.M)
    assert conform(vectors, *words, "--stage", "S1") == 1
    assert "Nothing was judged" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--exec", "no-such-program --fast"], "there is no program 'no-such-program'"),
        (["--exec", "'open"], "is no command"),
        (["--exec", " "], "expected a command"),
        (["--exec", "true", "--case", "S9-none-01"], "there is no case S9-none-01"),
        (["--exec", "true", "--stage", "S2"], "leave no case"),
        (["--exec", "true", "--json", "/no/such/folder/r.json"], "there is no folder"),
        (["--exec", "true", "--failures", "/no/file"], "cannot be read"),
        (["--self-test", "--json", "r.json"], "--self-test writes no report"),
    ],
)
def test_bad_usage_exits_with_two(vectors, capsys, words, said):
    assert conform(vectors, *words) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("words", [[], ["--exec", "x", "--self-test"], ["--exec", "x", "--gib=0"]])
def test_words_that_do_not_fit_exit_with_two(vectors, words):
    with pytest.raises(SystemExit) as error:
        conform(vectors, *words)
    assert error.value.code == 2


def test_a_folder_without_vectors_is_bad_usage(tmp_path, capsys):
    assert conform(tmp_path, "--exec", "true") == 2
    assert "VectorsError" in capsys.readouterr().err


def exchange(port, folder):
    """Let a port answer the requests of a folder, and return its lines."""
    requests, replies = folder / "requests.jsonl", folder / "replies.jsonl"
    os.system(f"{shell(port)} < {requests} > {replies} 2>/dev/null")
    return replies.read_bytes().splitlines(keepends=True)


def test_a_folder_is_written_then_judged(port, vectors, tmp_path, capsys):
    folder = tmp_path / "exchange"
    only = ["--stage", "S9", "--dtype", "f8"]
    assert conform(vectors, "--folder", folder, *only) == 0
    assert "3 requests behind the greeting" in capsys.readouterr().out
    lines = (folder / "requests.jsonl").read_bytes().splitlines()
    assert object_of(lines[0])["hello"] == "izo-conform"
    assert lines[1] + b"\n" == request_line(REQUESTS[0])
    exchange(port(), folder)
    assert conform(vectors, "--folder", folder) == 0
    exchange(port(AT_BAD + NO_MAX), folder)
    assert conform(vectors, "--folder", folder) == 1


DAMAGE = {
    "nothing": (lambda lines: [], 0, "no-reply"),
    "only a greeting": (lambda lines: lines[:1], 3, "no-reply"),
    "one left out": (lambda lines: lines[:2] + lines[3:], 1, "no-reply"),
    "swapped": (lambda lines: [lines[0], lines[2], lines[1], lines[3]], 2, "wrong-order"),
    "garbage": (lambda lines: [*lines[:2], b"\xff\n", lines[3]], 1, "garbage"),
    "wrong id": (
        lambda lines: [*lines[:2], lines[2].replace(b"S9-", b"S8-"), lines[3]],
        1,
        "wrong-id",
    ),
    "too many": (lambda lines: [*lines, lines[1]], 0, "several-lines"),
    "cut off": (lambda lines: [*lines[:3], lines[3][:9]], 1, "garbage"),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_replies_of_a_folder_are_named(port, vectors, tmp_path, damage, capsys):
    change, failed, said = DAMAGE[damage]
    folder = tmp_path / "exchange"
    conform(vectors, "--folder", folder, "--stage", "S9", "--dtype", "f8")
    lines = exchange(port(), folder)
    (folder / "replies.jsonl").write_bytes(b"".join(change(lines)))
    report = tmp_path / "report.json"
    assert conform(vectors, "--folder", folder, "--json", report) == 1
    record = json.loads(report.read_text())
    rows = [row for row in record["cases"] if row["result"] == "failed"]
    assert len(rows) == failed
    kinds = [row["differences"][0]["output"] for row in rows]
    assert said in [*kinds, *(note.split(", ")[-1].partition(":")[0] for note in record["notes"])]


def test_a_folder_of_replies_may_leave_out_what_the_port_does_not_have(port, vectors, tmp_path):
    folder = tmp_path / "exchange"
    conform(vectors, "--folder", folder)  # both types, and S1, which the port does not have
    code = 'if (request["stage"], request["dtype"]) != ("S9", "f8"):\n    continue'
    words = port()
    with open(words[1]) as file:
        text = file.read()
    with open(words[1], "w") as file:
        skip = "\n".join(f"    {line}" for line in code.splitlines())
        file.write(text.replace("    good = answer", f"{skip}\n    good = answer"))
    exchange(words, folder)
    assert conform(vectors, "--folder", folder) == 0


def test_requests_of_other_vectors_are_refused(port, vectors, tmp_path, capsys):
    folder = tmp_path / "exchange"
    conform(vectors, "--folder", folder)
    exchange(port(), folder)
    requests = folder / "requests.jsonl"
    requests.write_bytes(
        requests.read_bytes().replace(b'"penalty":"0x1p+1"', b'"penalty":"0x1p+2"')
    )
    assert conform(vectors, "--folder", folder) == 2
    assert "has another input in these vectors" in capsys.readouterr().err
