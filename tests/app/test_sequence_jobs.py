"""Several animations on one command line: each ends as it would alone, whatever the others do."""

import argparse
import json
import os
import re
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from izo_ref.app import sequence_jobs
from izo_ref.app.cli import main
from izo_ref.app.frame_progress import Display, Progress
from izo_ref.app.sequence_jobs import Ended
from tests.helpers.shapes import two_sheets

PARTS = (0.0, 0.5, 0.8, 1.0)


def run(*words):
    """Run the command in this process and return its exit code."""
    return main([str(word) for word in words])


def save(path, scene):
    """Write a step as an animation of four frames."""
    travel = scene.positions_t1 - scene.positions_t0
    frames = np.array([scene.positions_t0 + part * travel for part in PARTS])
    np.savez(path, positions=frames, faces=scene.faces)


@pytest.fixture
def animations(rng, tmp_path):
    """Write two animations and a file that is none; return their paths."""
    paths = [tmp_path / name for name in ("shirt.npz", "coat.npz", "broken.npz")]
    for path in paths[:2]:
        save(path, two_sheets(rng, 4))
    paths[2].write_bytes(b"PK but no archive")
    return paths


def test_one_that_is_refused_does_not_stop_the_others(animations, tmp_path, capsys):
    folder, report = tmp_path / "new" / "resolved", tmp_path / "report.json"
    words = ["sequence", animations[2], *animations[:2], "-o", folder, "--jobs", "2"]
    assert run(*words, "--json", report, "--progress") == 2
    said = capsys.readouterr()
    for path in animations[:2]:
        assert f"{path}: {len(PARTS)} frames: {len(PARTS)} FREE\n" in said.out
        lines = re.findall(rf"^{path}: frame \d of 3, \d+ impacts.*$", said.err, re.M)
        assert len(lines) == len(PARTS)
        alone = tmp_path / f"alone-{path.name}"
        assert run("sequence", path, "-o", alone) == 0
        assert (folder / path.name).read_bytes() == alone.read_bytes()
    assert f"izo: {animations[2]}: FileFormatError: " in said.err
    assert sorted(path.name for path in folder.iterdir()) == ["coat.npz", "shirt.npz"]
    found = json.loads(report.read_text())["sequences"]
    assert [Path(one["input"]) for one in found] == [animations[2], *animations[:2]]
    assert [one["exit_code"] for one in found] == [2, 0, 0]
    assert [len(one["frames"]) for one in found] == [0, len(PARTS), len(PARTS)]
    assert "FileFormatError" in found[0]["error"]


def die(task, sender, n_threads):
    """End the process of one animation by a signal; say of the others that they are free."""
    if task.animation == "b":
        os.kill(os.getpid(), signal.SIGKILL)
    sender.send(Progress(0, 1, 1, 2, 5))
    sender.send(Ended(0, [f"{n_threads} threads"], None, []))


def test_one_whose_process_crashes_does_not_stop_the_others(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sequence_jobs, "_work", die)
    words = {"output": tmp_path / "out", "jobs": 3, "json": None, "progress": True}
    args = argparse.Namespace(animation=["a", "b", "c"], **words)
    assert sequence_jobs.sequences(args) == 2
    said = capsys.readouterr()
    assert sorted(line[:3] for line in said.out.splitlines()) == ["a: ", "c: "]
    assert "izo: b: its process ended with the signal SIGKILL; the others go on" in said.err
    assert "a: frame 0 of 1, 5 impacts\n" in said.err


def test_the_worst_exit_code_is_returned(tmp_path, monkeypatch):
    codes = {"a": 3, "b": 0, "c": 1}

    def run_none(tasks, jobs, display):
        for name in tasks:
            yield name, Ended(codes[name], [], None, [])

    monkeypatch.setattr(sequence_jobs, "_run", run_none)
    words = {"output": tmp_path, "jobs": 1, "json": None, "progress": False}
    for names, expected in (("abc", 1), ("ab", 3), ("bb", None), ("b", 0)):
        args = argparse.Namespace(animation=list(names), **words)
        if expected is None:
            with pytest.raises(sequence_jobs.FileFormatError, match="the same name"):
                sequence_jobs.sequences(args)
        else:
            assert sequence_jobs.sequences(args) == expected


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("x/shirt.npz",), "would be written to the same name as"),
        (("coat.npz", "--json", "nowhere/report.json"), "there is no folder"),
        (("coat.npz", "--json", "coat.npz"), "would be lost"),
    ],
)
def test_wrong_words_are_refused_before_the_work_begins(
    animations, tmp_path, monkeypatch, capsys, words, message
):
    monkeypatch.chdir(tmp_path)
    assert run("sequence", "shirt.npz", *words, "-o", "out") == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("count", ["0", "-1", "1.5", "two"])
def test_the_number_of_jobs_is_a_positive_number(capsys, count):
    with pytest.raises(SystemExit) as caught:
        run("sequence", "a.npz", "b.npz", "-o", "out", f"--jobs={count}")
    assert caught.value.code == 2
    assert "expected a whole number from 1 on" in capsys.readouterr().err


class Terminal:
    """A standard error that says that it is a terminal."""

    encoding = "utf-8"

    def __init__(self):
        self.text = ""

    def write(self, text):
        self.text += text

    def flush(self):
        """Do nothing."""

    def isatty(self):
        """Say that it is a terminal."""
        return True


def test_there_is_a_bar_for_each_on_a_terminal(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with Display(lines=False, named=True) as display:
        for done in range(3):
            for name in ("shirt", "coat"):
                frame = done - 1 if done else None
                display.tell(name, Progress(frame, 9, done, 10, 1234 * done))
        display.end("shirt")
        display.say("shirt: 10 frames", sys.stderr)
        display.tell("hat", Progress(None, 1, 0, 2, 0))
        assert display._bars["hat"].pos == 0  # the place of the one that ended
    assert "shirt:  20%" in terminal.text
    assert "2,468 impacts" in terminal.text
    assert "coat:  20%" in terminal.text
    assert "shirt: 10 frames\n" in terminal.text


def test_lines_say_the_time_that_is_left(monkeypatch, capsys):
    clock = iter([0.0, 10.0, 4000.0, 4001.0])
    monkeypatch.setattr("time.perf_counter", lambda: next(clock))
    with Display(lines=True, named=False) as display:
        display.tell("shirt", Progress(3, 9, 4, 10, 7))  # four frames were kept by an earlier run
        display.tell("shirt", Progress(4, 9, 5, 10, 7))
        display.tell("shirt", Progress(8, 9, 9, 10, 1007))
        display.tell("shirt", Progress(9, 9, 10, 10, 1007))
    assert capsys.readouterr().err.splitlines() == [
        "frame 3 of 9, 7 impacts",
        "frame 4 of 9, 7 impacts, 50 s left",
        "frame 8 of 9, 1,007 impacts, 13 min 20 s left",
        "frame 9 of 9, 1,007 impacts",
    ]


def test_nothing_is_shown_in_a_pipe_without_being_asked_for(capsys):
    with Display(lines=False, named=False) as display:
        display.tell("shirt", Progress(0, 1, 1, 2, 3))
    assert capsys.readouterr().err == ""
