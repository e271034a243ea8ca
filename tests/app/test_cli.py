"""The command `izo`: its exit codes, what it prints, and the files that it writes."""

import json
import subprocess
import sys

import numpy as np
import pytest

from izo_ref.app.cli import main
from izo_ref.app.files import load_result, save_scene
from tests.helpers.seams import seams
from tests.helpers.shapes import pinched_sheet, two_sheets, vertex_over_face


@pytest.fixture
def step(tmp_path):
    """Write a step in which one vertex falls through a face, and return the file."""
    save_scene(tmp_path / "step.npz", vertex_over_face())
    return tmp_path / "step.npz"


def run(*arguments):
    """Run the command in this process and return its exit code."""
    return main([str(a) for a in arguments])


def test_resolve_writes_positions_and_report(step, tmp_path, capsys):
    out, report = tmp_path / "out.npz", tmp_path / "report.json"
    assert run("resolve", step, "-o", out, "--thickness", "0.1", "--json", report) == 0
    said = capsys.readouterr()
    assert said.out.startswith("FREE")
    assert said.err == ""  # no progress is printed where the output is not a terminal
    content = json.loads(report.read_text())
    assert content["status"] == "FREE"
    assert content["thickness_m"] == 0.1
    assert content["certificate"]["free"] is True
    assert content["options"]["selection"] == "independent"
    assert len(content["history"]) == content["iterations"]
    assert load_result(out).positions.shape == (6, 3)
    assert run("certify", step, "--positions", out) == 0
    assert run("certify", step) == 1


def test_a_time_limit_that_strikes_is_named_in_the_output_and_in_the_report(tmp_path, capsys):
    save_scene(tmp_path / "step.npz", two_sheets(np.random.default_rng(5), 12))
    out, report = tmp_path / "out.npz", tmp_path / "report.json"
    limit = "--max-seconds", "1e-9"
    assert run("resolve", tmp_path / "step.npz", "-o", out, *limit, "--json", report) == 0
    said, content = capsys.readouterr().out.splitlines(), json.loads(report.read_text())
    assert said[0].startswith("FREE_BY_FALLBACK")
    assert said[1].startswith("The time limit of 1e-09 s ended the first detection")
    assert content["reason"] == said[1]
    assert content["options"]["max_seconds"] == 1e-9
    assert content["certificate"]["finished"] is True
    assert run("certify", tmp_path / "step.npz", "--positions", out) == 0


def test_detect_lists_pairs_and_exits_with_one(step, tmp_path, capsys):
    assert run("detect", step, "--json", tmp_path / "found.json") == 1
    assert "vertex_face [3, 0, 1, 2] at t = 0.5" in capsys.readouterr().out
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["vertex_face"] + found["edge_edge"] == len(found["first"])


def test_plan_lists_what_is_left_out_and_why(step, tmp_path, capsys):
    assert run("plan", step, "--json", tmp_path / "plan.json") == 0
    said = capsys.readouterr().out
    rows = json.loads((tmp_path / "plan.json").read_text())["plan"]
    assert all(row["stage"] in said and row["reason"] in said for row in rows)
    assert "pairs at rest        none    still" in said


def test_a_blocked_step_exits_with_one_and_says_when_pairs_meet(tmp_path, capsys):
    save_scene(tmp_path / "step.npz", pinched_sheet(-0.05))
    out, report = tmp_path / "out.npz", tmp_path / "report.json"
    assert run("resolve", tmp_path / "step.npz", "-o", out, "--json", report) == 1
    assert "BLOCKED" in capsys.readouterr().out
    content = json.loads(report.read_text())
    assert 0.0 < content["time_free"] < 1.0
    assert content["certificate"]["meeting"]["first"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["resolve", "STEP", "-o", "OUT", "--thickness", "-1"],
        ["resolve", "STEP", "-o", "OUT", "--device", "cuda"],
        ["resolve", "missing.npz", "-o", "OUT"],
        ["resolve", "STEP", "-o", "nowhere/out.npz"],
        ["certify", "STEP", "--positions", "missing.npz"],
        ["resolve", "STEP", "-o", "STEP"],
        ["resolve", "STEP", "-o", "OUT", "--json", "OUT"],
        ["detect", "STEP", "--json", "STEP"],
        ["plan", "STEP", "--json", "STEP"],
        ["certify", "STEP", "--json", "STEP"],
        ["resolve", "STEP", "-o", "OUT", "--relinearize", "-1"],
        ["resolve", "STEP", "-o", "OUT", "--max-seconds", "0"],
    ],
)
def test_bad_input_exits_with_two_and_writes_nothing(step, tmp_path, capsys, arguments):
    names, before = {"STEP": step, "OUT": tmp_path / "out.npz"}, step.read_bytes()
    assert run(*[names.get(a, a) for a in arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("izo: ")
    assert not (tmp_path / "out.npz").exists()
    assert step.read_bytes() == before


def test_messages_name_the_flags_of_the_command(step, tmp_path, capsys):
    assert run("resolve", step, "-o", tmp_path / "out.npz", "--thickness", "-1") == 2
    assert "--thickness: expected" in capsys.readouterr().err
    assert run("resolve", step, "-o", tmp_path / "out.npz", "--max-seconds", "-2") == 2
    assert "--max-seconds: expected None or a finite number > 0" in capsys.readouterr().err
    crossing = tmp_path / "crossing.npz"
    start = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, -1], [0.2, 0.2, 1], [0.3, 0.2, 1]]
    np.savez(crossing, positions_t0=start, positions_t1=start, faces=[[0, 1, 2], [3, 4, 5]])
    assert run("detect", crossing) == 2
    assert "--initial-intersections ratchet" in capsys.readouterr().err
    assert run("detect", crossing, "--initial-intersections", "exclude") == 0


def test_a_bad_scene_exits_with_two(tmp_path, capsys):
    start = np.zeros((4, 3))
    np.savez(tmp_path / "bad.npz", positions_t0=start, positions_t1=start, faces=[[0, 1, 9]])
    assert run("detect", tmp_path / "bad.npz") == 2
    assert "IndexRangeError" in capsys.readouterr().err


def test_unknown_options_exit_with_two():
    with pytest.raises(SystemExit) as caught:
        run("resolve", "--sideways")
    assert caught.value.code == 2


def test_the_command_runs_as_a_process(step, tmp_path):
    command = [sys.executable, "-m", "izo_ref.app.cli", "certify", str(step)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1
    assert "not free" in done.stdout
    assert done.stderr == ""


@pytest.fixture
def seamed(tmp_path):
    """Write a step with a seam, whose message says what to pass, and return file and mesh."""
    mesh = seams(np.random.default_rng(7))["crossing seams"]
    np.savez(tmp_path / "seamed.npz", **mesh)
    return tmp_path / "seamed.npz", mesh


def test_every_command_that_reads_a_step_can_weld(seamed, tmp_path, capsys):
    step, mesh = seamed
    out, report = tmp_path / "out.npz", tmp_path / "report.json"
    assert run("resolve", step, "-o", out) == 2
    assert "pass --weld:" in capsys.readouterr().err
    n = len(mesh["positions_t0"])
    n_copies = n - len(np.unique(mesh["positions_t0"], axis=0))
    assert run("resolve", step, "-o", out, "--json", report, "--weld", "--thickness", "1e-3") == 0
    said = capsys.readouterr().out
    assert said.startswith("FREE")
    assert f"{n_copies} of {n} vertices are copies" in said
    assert json.loads(report.read_text())["copies"] == n_copies
    assert load_result(out).positions.shape == (n, 3)
    assert run("certify", step, "--positions", out, "--weld", "1e-9") == 0
    assert run("detect", step, "--weld", "0") == 1
    assert run("plan", step, "--weld") == 0
    assert f"{n_copies} of {n} vertices are copies" in capsys.readouterr().out
    assert run("certify", step, "--positions", step, "--weld") == 2  # a step is no result


@pytest.mark.parametrize("metres", ["-1", "nan"])
def test_a_bad_tolerance_is_refused_by_the_name_of_its_flag(seamed, capsys, metres):
    assert run("detect", seamed[0], f"--weld={metres}") == 2
    assert "izo: OptionError: --weld: expected" in capsys.readouterr().err


def test_a_flag_before_the_file_says_where_to_put_it(seamed, capsys):
    with pytest.raises(SystemExit) as caught:
        run("detect", "--weld", seamed[0])
    assert caught.value.code == 2
    assert "put --weld behind the files" in capsys.readouterr().err


def test_a_reader_that_ends_first_gets_no_traceback():
    """`izo plan step.npz | head -0`"""
    command = "from izo_ref.app.cli import entry; import sys; sys.argv[1:] = ['--help']; entry()"
    process = subprocess.Popen(
        [sys.executable, "-u", "-c", f"import time; time.sleep(0.5); {command}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    said = process.stderr.read().decode()
    process.stderr.close()
    process.wait()
    assert "Traceback" not in said
