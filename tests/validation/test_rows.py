"""Rows of measurements: they keep their types, resume after a cut, and name their run."""

import math
import subprocess
import sys

import numpy as np
import pytest

from validation.provenance import ROOT
from validation.rows import Rows, begin_run, read, runs

ROW = {"zone": "a", "size": 4}


def test_rows_come_back_with_their_types(tmp_path):
    rows = Rows(tmp_path, "study", ("zone", "size"))
    values = {"flag": True, "count": -3, "time": 1.5e-9, "text": "to 1e-9, or so", "none": None}
    rows.add(zone="a", size=4, **values, outcome="converged", message="")
    (row,) = Rows(tmp_path, "study", ("zone", "size")).all()
    back = {name: row[name] for name in values}
    assert back == values
    assert [type(back[name]) for name in back] == [type(values[name]) for name in values]
    assert list(row)[:3] == ["zone", "size", "run"]
    assert row["message"] is None


@pytest.mark.parametrize("value", [0.1, 1e-300, -1e300, math.inf, -math.inf, 2.0])
def test_floats_come_back_to_the_last_bit(tmp_path, value):
    rows = Rows(tmp_path, "study", ())
    rows.add(value=np.float64(value))
    assert rows.all()[0]["value"] == value
    assert type(rows.all()[0]["value"]) is float


@pytest.mark.parametrize("text", ["12", "1e5", "True", "inf", "-0.5", '"quoted"', 'a "b", c'])
def test_texts_stay_texts(tmp_path, text):
    Rows(tmp_path, "study", ()).add(value=text)
    assert read(tmp_path, "study")[0]["value"] == text


def test_a_message_of_two_lines_is_one_row(tmp_path):
    rows = Rows(tmp_path, "study", ("zone",))
    rows.add(zone="a", outcome="failed", message="ValueError:\n  no such thing")
    rows.add(zone="b", outcome="converged", message=None)
    assert len((tmp_path / "study.csv").read_text().splitlines()) == 3
    assert rows.all()[0]["message"] == "ValueError: no such thing"


def test_a_run_resumes_where_it_was(tmp_path):
    begin_run(tmp_path, "report", False)
    rows = Rows(tmp_path, "study", ("zone", "size"))
    assert not rows.has(**ROW)
    rows.add(**ROW, seconds=1.0)
    assert rows.has(**ROW)
    assert begin_run(tmp_path, "report", False) == 1
    again = Rows(tmp_path, "study", ("zone", "size"))
    assert again.has(**ROW)
    assert not again.has(zone="a", size=5)
    # Rows of a quick run do not replace those of a full run, nor the other way round.
    begin_run(tmp_path, "report", True)
    assert not Rows(tmp_path, "study", ("zone", "size")).has(**ROW)


def test_a_line_cut_off_is_measured_again(tmp_path):
    rows = Rows(tmp_path, "study", ("zone", "size"))
    rows.add(**ROW, seconds=1.0)
    rows.add(zone="b", size=8, seconds=2.0)
    path = tmp_path / "study.csv"
    path.write_bytes(path.read_bytes()[:-3])
    assert [row["zone"] for row in read(tmp_path, "study")] == ["a"]  # before the file is repaired
    again = Rows(tmp_path, "study", ("zone", "size"))
    assert again.has(**ROW)
    assert not again.has(zone="b", size=8)
    again.add(zone="b", size=8, seconds=3.0)
    assert [row["seconds"] for row in again.all()] == [1.0, 3.0]


def test_a_new_column_is_empty_in_the_rows_before(tmp_path):
    rows = Rows(tmp_path, "study", ("zone", "size"))
    rows.add(**ROW, seconds=1.0)
    rows.add(zone="b", size=8, seconds=2.0, steps=7)
    rows.add(zone="c", size=8, steps=9)
    found = [(row["zone"], row["seconds"], row["steps"]) for row in rows.all()]
    assert found == [("a", 1.0, None), ("b", 2.0, 7), ("c", None, 9)]


def test_rows_name_their_run(tmp_path):
    first = begin_run(tmp_path, "python -m validation report", False)
    Rows(tmp_path, "study", ("zone",)).add(zone="a")
    second = begin_run(tmp_path, "python -m validation report --only outer", False)
    Rows(tmp_path, "study", ("zone",)).add(zone="b")
    assert [row["run"] for row in read(tmp_path, "study")] == [first, second]
    run = runs(tmp_path)[0]
    assert run["command"] == "python -m validation report"
    assert "numba" in run["versions"]
    assert all(run[name] for name in ("commit", "machine", "started"))


BEGINS = """
import sys
from pathlib import Path
from validation import provenance, rows

made = provenance.made_by("")
provenance.made_by = lambda command: made._replace(command=command)  # else git sets the pace
folder, name = Path(sys.argv[1]), sys.argv[2]
print("ready", flush=True)
sys.stdin.readline()
for number in range(10):
    begun = rows.begin_run(folder, f"{name} {number}", False)
    rows.Rows(folder, name, ("number",)).add(number=number, begun=begun)
"""
HOLDS = """
import sys
from validation import rows

def hold(path, cells):
    print("ready", flush=True)
    sys.stdin.readline()

rows._append = hold
rows.begin_run(sys.argv[1], "held", False)
"""


@pytest.fixture
def started():
    """Return a function that starts a program in Python and waits until it is ready."""
    processes = []

    def start(program, *words):
        command = [sys.executable, "-c", program, *map(str, words)]
        pipe = subprocess.PIPE
        process = subprocess.Popen(command, cwd=ROOT, stdin=pipe, stdout=pipe, text=True)
        processes.append(process)
        assert process.stdout.readline() == "ready\n"
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()


def go_on(process):
    """Let a program that is ready go on."""
    process.stdin.write("\n")
    process.stdin.flush()


def test_processes_that_begin_runs_at_once_have_runs_of_their_own(tmp_path, started):
    names = ["a", "b", "c", "d"]
    processes = [started(BEGINS, tmp_path, name) for name in names]
    for process in processes:
        go_on(process)
    assert [process.wait() for process in processes] == [0] * 4
    commands = {run["run"]: run["command"] for run in runs(tmp_path)}
    assert sorted(commands) == list(range(1, 41))
    for name in names:
        rows = read(tmp_path, name)
        assert [commands[row["run"]] for row in rows] == [f"{name} {k}" for k in range(10)]
        assert all(row["run"] == row["begun"] for row in rows)


def test_rows_name_the_run_of_their_process_and_not_one_that_was_begun_since(tmp_path):
    begin_run(tmp_path, "ours", False)
    Rows(tmp_path, "study", ("zone",)).add(zone="a")
    path = tmp_path / "runs.csv"
    last = path.read_text().splitlines()[-1]
    with path.open("a") as file:  # a quick run of another process
        file.write(last.replace("1,ours", "2,theirs").replace(",False,", ",True,") + "\n")
    ours = Rows(tmp_path, "study", ("zone",))
    assert ours.has(zone="a")
    ours.add(zone="b")
    assert [row["run"] for row in ours.all()] == [1, 1]
    assert begin_run(tmp_path, "ours", False) == 3


def test_a_process_that_is_killed_while_it_begins_a_run_blocks_nobody(tmp_path, started):
    first, second = started(HOLDS, tmp_path), started(BEGINS, tmp_path, "b")
    go_on(second)
    with pytest.raises(subprocess.TimeoutExpired):
        second.wait(timeout=0.2)  # it waits for the first one
    assert runs(tmp_path) == []
    first.kill()
    assert second.wait() == 0
    assert [run["command"] for run in runs(tmp_path)] == [f"b {k}" for k in range(10)]
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["b.csv", "runs.csv"]


def test_a_new_run_has_an_id_that_no_run_has(tmp_path):
    """Lines of runs may have been left out or moved, as where rows of two machines are joined."""
    for name in "abc":
        begin_run(tmp_path, name, False)
    path = tmp_path / "runs.csv"
    head, _, two, three = path.read_text().splitlines()
    path.write_text("\n".join((head, three, two)) + "\n")
    assert begin_run(tmp_path, "d", False) == 4


def test_wrong_rows_are_refused(tmp_path):
    rows = Rows(tmp_path, "study", ("zone",))
    with pytest.raises(ValueError, match="missing"):
        rows.add(size=4)
    with pytest.raises(ValueError, match="outcome"):
        rows.add(zone="a", outcome="solved")
    with pytest.raises(ValueError, match="expected bool"):
        rows.add(zone="a", value=[1.0])
    assert rows.all() == []


def test_a_study_that_was_not_run_has_no_rows(tmp_path):
    assert read(tmp_path / "nowhere", "study") == []
    assert runs(tmp_path / "nowhere") == []
