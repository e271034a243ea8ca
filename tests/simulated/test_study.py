"""The study of the GPU writes its rows and its page, on a tiny scene."""

import subprocess

import pytest

from izo_ref.solvers import gpu_augmented_lagrangian as lagrangian
from tests.helpers.shapes import random_problem, vertex_over_face
from validation.__main__ import _parser
from validation.report.cuda import page
from validation.rows import read
from validation.study import cuda, zone_blocks
from validation.study.parts import run_parts


@pytest.fixture
def one_step(monkeypatch):
    """Make the study measure one tiny step and two tiny zones, once each."""
    monkeypatch.setattr(cuda.steps, "step_names", lambda: ["falls"])
    monkeypatch.setattr(cuda.steps, "load_step", lambda name: vertex_over_face())
    monkeypatch.setattr(cuda, "REPEATS", 1)
    monkeypatch.setattr(cuda, "SHEETS", ())
    monkeypatch.setattr(cuda, "ZONES", (3,))
    monkeypatch.setattr(cuda, "stack_zone", lambda rng, *_: random_problem(rng, 5))
    monkeypatch.setattr(lagrangian, "LARGE", 4)
    monkeypatch.setattr(cuda, "COPIED", 1 << 10)
    monkeypatch.setattr(lagrangian, "MANY", 2)


def test_detection_is_compared_with_the_cpu(tmp_path, one_step):
    run_parts(cuda.PARTS, tmp_path / "rows", "detection", print)
    (row,) = read(tmp_path / "rows", "detection")
    assert (row["step"], row["triangles"], row["impacts"]) == ("falls", 2, 1)
    assert (row["only_gpu"], row["only_cpu"]) == (0, 0)
    assert (row["toi_difference"], row["normal_difference"]) == (0.0, 0.0)
    assert row["gpu"] == "simulator"
    text = page(tmp_path / "rows", tmp_path).read_text()
    assert "| falls |" in text
    assert text.count("Not measured yet.") == 6


def test_whole_steps_and_zones_are_compared_with_the_cpu(tmp_path, one_step):
    for part in ("steps", "zones"):
        run_parts(cuda.PARTS, tmp_path / "rows", part, print)
    (row,) = read(tmp_path / "rows", "steps")
    assert (row["step"], row["status"], row["cpu_status"]) == ("falls", "FREE", "FREE")
    assert (row["objective"], row["apart_m"], row["same_again"]) == (1.0, 0.0, True)
    rows = read(tmp_path / "rows", "zones")
    assert [row["impacts"] for row in rows] == [3, 5]
    assert max(row["gap"] for row in rows) <= 1e-9
    assert max(row["violation"] for row in rows) <= 1e-9
    text = page(tmp_path / "rows", tmp_path).read_text()
    assert "| falls |" in text
    assert "| 3 | simulator |" in text


def test_zones_of_blocks_are_measured(tmp_path, monkeypatch):
    for name, value in {
        "RANDOM": (3,),
        "STACKS": ((2, 3),),
        "THREADS": (2,),
        "SHARED_KIB": (4, 8),
        "COPIES": 2,
        "REPEATS": 1,
    }.items():
        monkeypatch.setattr(zone_blocks, name, value)
    run_parts(cuda.PARTS, tmp_path / "rows", "blocks", print)
    rows = read(tmp_path / "rows", "blocks")
    assert [(row["zone"], row["shared_kib"]) for row in rows] == [
        ("random", 4),
        ("random", 8),
        ("stack", 4),
        ("stack", 8),
    ]
    for row in rows:
        assert row["solved"]
        assert row["all_same"]
        assert max(row["gap"], row["violation"]) <= 1e-9
    assert "| random | 3 |" in page(tmp_path / "rows", tmp_path).read_text()


def test_launches_are_counted(tmp_path, monkeypatch):
    monkeypatch.setattr(cuda, "COUNTED", (8,))
    monkeypatch.setattr("validation.simulator.prepare", lambda: None)  # conftest.py has called it
    run_parts(cuda.PARTS, tmp_path / "rows", "launches", print)
    (row,) = read(tmp_path / "rows", "launches")
    assert row["gpu"] == "simulator"
    assert row["launches"] > 50 * row["iterations"] > 0
    assert row["arrays"] > row["launches"]


def test_each_part_can_be_chosen():
    for part in cuda.PARTS:
        assert _parser().parse_args(["study", "cuda", "--only", part]).only == part


@pytest.mark.parametrize("verdict", [0, 9, None])
def test_the_verdict_of_the_memory_checks_is_recorded(tmp_path, monkeypatch, verdict):
    run = subprocess.run

    def said(command, **kwargs):
        if command[0] != "/sanitizer":
            return run(command, **kwargs)
        if verdict is None:
            raise subprocess.TimeoutExpired(command, kwargs["timeout"])
        return subprocess.CompletedProcess(command, verdict, "", "===== ERROR SUMMARY: so many\n")

    monkeypatch.setattr(cuda.shutil, "which", lambda name: "/sanitizer")
    monkeypatch.setattr(cuda.subprocess, "run", said)
    run_parts(cuda.PARTS, tmp_path / "rows", "memory", print)
    rows = read(tmp_path / "rows", "memory")
    assert [row["tool"] for row in rows] == ["memcheck", "racecheck"]
    assert {row["passed"] for row in rows} == {verdict == 0}
    assert rows[0]["said"] == (
        "not done after 120 s" if verdict is None else "ERROR SUMMARY: so many"
    )


def test_pairs_found_by_one_side_alone_are_counted():
    import izo_ref

    found = izo_ref.find_impacts(vertex_over_face())
    other = found._replace(nodes=found.nodes[:, [1, 0, 2, 3]])
    said = cuda._differences(other, found)
    assert (said["only_gpu"], said["only_cpu"]) == (1, 1)
