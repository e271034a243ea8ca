"""The study of the GPU writes its rows and its page, on a tiny scene."""

import subprocess
from dataclasses import replace

import pytest

from izo_ref.detection.gpu_start import StartCheck
from izo_ref.solvers import gpu_augmented_lagrangian as lagrangian
from tests.helpers.shapes import random_problem, two_sheets, vertex_over_face
from validation.__main__ import _parser
from validation.report.cuda import page
from validation.rows import read
from validation.study import cuda, gpu_check, gpu_parts, gpu_zones, zone_blocks

# In compiled code, x / 0 is inf without a warning; in the simulator numpy warns.
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


@pytest.fixture
def one_step(monkeypatch):
    """Make the study measure one tiny step and two tiny zones, once each."""
    monkeypatch.setattr(gpu_parts.steps, "step_names", lambda: ["falls"])
    monkeypatch.setattr(gpu_parts.steps, "load_step", lambda name: vertex_over_face())
    monkeypatch.setattr(gpu_parts, "SHEETS", ())
    monkeypatch.setattr(gpu_zones, "ZONES", (3,))
    monkeypatch.setattr(gpu_zones, "stack_zone", lambda rng, *_: random_problem(rng, 5))
    monkeypatch.setattr(lagrangian, "LARGE", 4)
    monkeypatch.setattr(cuda, "COPIED", 1 << 10)
    monkeypatch.setattr(lagrangian, "MANY", 2)
    for module in (cuda, gpu_zones):
        monkeypatch.setattr(module, "REPEATS", 1)


def test_detection_is_compared_with_the_cpu(tmp_path, one_step):
    assert cuda.run_part("detection", tmp_path / "rows", print) is None
    (row,) = read(tmp_path / "rows", "detection")
    assert (row["step"], row["triangles"], row["impacts"]) == ("falls", 2, 1)
    assert (row["only_gpu"], row["only_cpu"]) == (0, 0)
    assert (row["toi_difference"], row["normal_difference"]) == (0.0, 0.0)
    assert row["gpu"] == "simulator"
    text = page(tmp_path / "rows", tmp_path).read_text()
    assert "| falls |" in text
    assert text.count("Not measured yet.") == 10


def test_whole_steps_and_zones_are_compared_with_the_cpu(tmp_path, one_step):
    for part in ("steps", "zones"):
        assert cuda.run_part(part, tmp_path / "rows", print) is None
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


@pytest.fixture
def few_cases(rng, monkeypatch):
    """Make the check compare a few tiny cases, one of each kind."""
    monkeypatch.setattr(gpu_check, "LENGTHS", (5, 33))
    monkeypatch.setattr(gpu_check, "ZONES", (2,))
    monkeypatch.setattr(gpu_check.stored, "names", lambda kind: ["falls"])
    monkeypatch.setattr(gpu_check.stored, "load_step", lambda name: vertex_over_face())
    monkeypatch.setattr(gpu_check, "stack_zone", lambda rng, *_: random_problem(rng, 3))
    sheets = two_sheets(rng, 2)
    monkeypatch.setattr(gpu_check, "meeting_sheets", lambda rng, n: sheets)
    few = ({"selection": "all"}, {"method": "cg", "max_steps": 400})
    monkeypatch.setattr(gpu_check, "all_options", lambda: iter(few))
    monkeypatch.setattr(lagrangian, "FEW", 2)
    monkeypatch.setattr(lagrangian, "MANY", 2)


def test_all_cases_run_in_shares(monkeypatch, few_cases):
    done, make = [], gpu_check.cases

    def noted():
        for case in make():
            yield case._replace(differences=lambda name=case.name: done.append(name) or [])

    monkeypatch.setattr(gpu_check, "cases", noted)
    for share in range(2):
        gpu_check.run_share(share, 2)
    assert sorted(done) == sorted(case.name for case in make())


@pytest.mark.parametrize("ends", [True, False])
def test_several_processes_compile_until_the_time_is_up(tmp_path, monkeypatch, ends):
    script = "pass" if ends else "import time; time.sleep(100)"
    start, began = subprocess.Popen, []

    def started(command):
        began.append(start([command[0], "-c", script]))
        return began[-1]

    monkeypatch.setattr(gpu_check.subprocess, "Popen", started)
    monkeypatch.setattr(gpu_check, "PROCESSES", 2)
    monkeypatch.setitem(cuda.PARTS, "warm", cuda.PARTS["warm"]._replace(budget_s=20.0 * ends))
    assert cuda.run_part("warm", tmp_path / "rows", print) is None
    assert [process.returncode == 0 for process in began] == len(began) * [ends]
    assert began


def test_the_check_names_each_case_that_agrees(tmp_path, few_cases):
    assert cuda.run_part("check", tmp_path / "rows", print) is None
    names = [row["case"] for row in read(tmp_path / "rows", "check")]
    assert names == [case.name for case in gpu_check.cases()]
    assert len(names) == 11
    said: list[str] = []
    assert cuda.run_part("check", tmp_path / "rows", said.append) is None
    assert said == [f"check: {name}: the same" for name in names], "it compares them again"
    assert len(read(tmp_path / "rows", "check")) == 11
    assert "| step falls | simulator |" in page(tmp_path / "rows", tmp_path).read_text()


def test_a_wrong_verdict_about_a_start_ends_the_check(tmp_path, monkeypatch, few_cases):
    monkeypatch.setattr(StartCheck, "is_free", lambda own: True)
    said = cuda.run_part("check", tmp_path / "rows", print)
    assert said == "starts of falls: the verdict about a start at 0.5, with 3 intersections"


@pytest.mark.parametrize(
    ("name", "wrong", "says"),
    [
        ("find_impacts", lambda own: own.take(own.toi > 2.0), "detection of falls"),
        ("resolve", lambda own: replace(own, positions=own.positions + 1.0), "step falls"),
        ("solve_zone", lambda own: own._replace(positions=own.positions + 1.0), "zone of 2"),
    ],
)
def test_the_first_difference_ends_the_check(tmp_path, monkeypatch, few_cases, name, wrong, says):
    compute = getattr(gpu_check, name)

    def broken(scene, *more, **named):
        found = compute(scene, *more, **named)
        return wrong(found) if "cuda" in (*more, named.get("device")) else found

    monkeypatch.setattr(gpu_check, name, broken)
    said = cuda.run_part("check", tmp_path / "rows", print)
    assert said is not None
    assert said.startswith(says)
    assert not any(row["case"].startswith(says) for row in read(tmp_path / "rows", "check"))


@pytest.mark.parametrize("part", ["check", "detection", "steps", "blocks", "zones"])
def test_a_part_without_time_says_what_it_left_out(tmp_path, one_step, monkeypatch, part):
    monkeypatch.setitem(cuda.PARTS, part, cuda.PARTS[part]._replace(budget_s=1e-9))
    assert cuda.run_part(part, tmp_path / "rows", print) is None
    (row,) = read(tmp_path / "rows", "cut")
    assert row["part"] == part
    assert row["first_left_out"]
    assert read(tmp_path / "rows", part) == []
    assert f"| {part} | {row['first_left_out']} |" in page(tmp_path / "rows", tmp_path).read_text()


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
    cuda.run_part("blocks", tmp_path / "rows", print)
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

    monkeypatch.setattr(gpu_zones.shutil, "which", lambda name: "/sanitizer")
    monkeypatch.setattr(gpu_zones.subprocess, "run", said)
    cuda.run_part("memory", tmp_path / "rows", print)
    rows = read(tmp_path / "rows", "memory")
    assert [row["tool"] for row in rows] == ["memcheck", "racecheck"]
    assert {row["passed"] for row in rows} == {verdict == 0}
    assert rows[0]["said"] == (
        "not done after 22 s" if verdict is None else "ERROR SUMMARY: so many"
    )


def test_pairs_found_by_one_side_alone_are_counted():
    import izo_ref

    found = izo_ref.find_impacts(vertex_over_face())
    other = found._replace(nodes=found.nodes[:, [1, 0, 2, 3]])
    said = gpu_check.impact_differences(other, found)
    assert (said["only_gpu"], said["only_cpu"]) == (1, 1)
