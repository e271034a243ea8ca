"""Run each example and check what it prints and writes, not only that it ends."""

import ast
import re
import runpy
from pathlib import Path

import numba
import numpy as np
import pytest

import izo_ref
from validation.oracles.path import meets

FOLDER = Path(__file__).resolve().parents[2] / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))
STEP_ARRAYS = ("positions_t0", "positions_t1", "faces", "masses", "pinned")


@pytest.fixture(autouse=True)
def one_thread():
    """Run on one thread: the scenes are small, and a busy machine wakes threads slowly.

    With nine other processes on two cores, ten steps of the loop took 0.5 s on one thread and 9 s
    on two.
    """
    before = numba.get_num_threads()
    numba.set_num_threads(1)
    yield
    numba.set_num_threads(before)


def load(name):
    """Names of an example, which is not run yet."""
    return runpy.run_path(str(FOLDER / f"{name}.py"))


def number(text, pattern):
    """Number that follows a pattern in a text."""
    return float(re.search(pattern + r"([-+.\de]+)", text).group(1))


def test_a_step_is_resolved_and_written_and_the_judge_accepts_the_file(tmp_path, capsys):
    example = load("resolve_a_step")
    scene = example["cloth_above_a_hill"]()
    step, output = tmp_path / "step.npz", tmp_path / "new" / "resolved.npz"
    np.savez(step, **{name: getattr(scene, name) for name in STEP_ARRAYS})

    assert example["main"]([str(step), "-o", str(output), "--thickness", "1e-3"]) == 0
    text = capsys.readouterr().out
    assert "FREE: The path is certified free" in text
    assert "certificate: the path is free until t = 1.000000" in text
    assert number(text, r"triangles\n") > 100  # pairs that meet on the proposed path
    assert " candidate pairs, 0 of them meet" in text
    with np.load(output) as written:
        corrections = ((written["positions"] - scene.positions_t1)[~scene.pinned] ** 2).sum(axis=1)
        assert written["thickness"] == 1e-3
    masses = scene.masses[~scene.pinned]
    objective = masses @ corrections / masses.sum()
    assert number(text, "objective: ") == pytest.approx(objective, rel=1e-4)

    assert load("judge_a_result")["main"]([str(step), str(output)]) == 0
    text = capsys.readouterr().out
    assert " candidate pairs, 0 of them meet" in text
    assert "free until t = 1.000000" in text
    rows = table(text, "impacts  ")
    assert len(rows) == 5
    for _, violation, gap, correction, distance in rows:
        assert violation < 1e-9
        assert gap < 1e-9
        assert distance < 1e-6 * correction


def test_the_step_without_arguments_writes_beside_other_built_files(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert load("resolve_a_step")["main"]([]) == 0
    assert (tmp_path / "build" / "resolved.npz").is_file()
    assert "result: build/resolved.npz" in capsys.readouterr().out


def test_the_judge_names_pairs_that_meet_and_zones_that_are_not_optimal(capsys):
    example = load("judge_a_result")
    assert example["main"]([]) == 0
    text = capsys.readouterr().out
    scene = example["two_cloths"]()
    positions = example["other_program"](scene)["positions"]

    named = re.findall(r"(edge-edge|vertex-face) pair \[(.*)\] meets", text)
    assert len(named) == 5
    for kind, nodes in named:
        nodes = [int(node) for node in nodes.split(",")]
        assert kind == "edge-edge"  # the other program knows the pairs of the other kind
        assert meets(True, scene.positions_t0[nodes], positions[nodes])
    assert 0.9 < number(text, "free until t = ") < 1.0

    ((_, violation, gap, correction, distance),) = table(text, "impacts  ")
    assert violation < 1e-9  # it satisfies what it knows
    assert gap > 0.1  # and is not optimal
    assert 0.1 * correction < distance < correction


def test_the_judge_refuses_half_of_what_it_needs(capsys):
    with pytest.raises(SystemExit):
        load("judge_a_result")["main"](["step.npz"])
    assert "expected a step and a result" in capsys.readouterr().err


def test_solvers_are_compared_and_solved_is_not_correct(capsys):
    assert load("compare_solvers")["main"]() == 0
    text = capsys.readouterr().out
    rows = [line.split() for line in text.split("correct\n")[1].splitlines()]
    assert len(rows) == 5 + 6 * 3 + 3
    by_name = {" ".join(row[:-7]): row for row in rows}
    assert len(by_name) == len(rows)
    for row in rows:
        distance, solved, correct = row[-3:]
        assert float(distance) > 0.0
        assert correct == ("yes" if float(distance) <= 1e-6 else "no")
        assert solved in ("yes", "no")
    for name in ("auto -", "active-set -", "interior-point -"):
        assert by_name[name][-2:] == ["yes", "yes"]
    assert any(row[-2:] == ["yes", "no"] for row in rows)
    # presets end where their systems do, at 100 steps, far from the optimum
    for name in ("arcsim", "icloth", "xrtailor"):
        assert by_name[f"preset {name} -"][-1] == "no"


def test_a_cloth_falls_and_every_step_is_certified(capsys):
    example = load("inside_a_loop")
    assert example["main"]() == 0
    text = capsys.readouterr().out
    assert f"{example['N_STEPS']} steps, each of them certified free" in text
    rows = [line.split() for line in text.splitlines()[1:-1]]
    assert [int(row[0]) for row in rows] == [5, 10, 15, 20]
    for _, status, impacts, _, correction, stretch, _ in rows:
        assert status == "FREE"
        assert int(impacts) > 0
        assert 0.0 < float(correction) < 20.0
        assert 1.0 < float(stretch) < 2.0  # the springs are stable


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_use_public_names_alone_and_say_how_to_run_them(path):
    tree = ast.parse(path.read_text())
    assert f"    python examples/{path.name}" in ast.get_docstring(tree).splitlines()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            assert not node.module.startswith("izo_ref")
        if isinstance(node, ast.Import):
            assert not any(alias.name.startswith("izo_ref.") for alias in node.names)
        if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "izo_ref":
            assert node.attr in izo_ref.__all__


def test_the_list_of_examples_is_whole():
    assert len(EXAMPLES) >= 4
    listed = re.findall(r"\]\((\w+\.py)\)", (FOLDER / "README.md").read_text())
    assert sorted(listed) == [path.name for path in EXAMPLES]


def table(text, header):
    """Rows of numbers below a header, without the words among them."""
    lines = text[text.index(header) :].splitlines()[1:]
    return [[float(word) for word in line.split() if word not in ("at", "most")] for line in lines]
