"""The study of CUDA keeps its time, and computes bounds from sizes and counts."""

import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is not installed: izo-ref[cuda]")

from validation.__main__ import _parser, main
from validation.report import cuda as report
from validation.report import cuda_bounds
from validation.rows import Rows, read
from validation.scenes.sheets import meeting_sheets
from validation.scenes.zones import random_zone
from validation.study import cuda, gpu_bounds, gpu_launches, operations
from validation.study.gpu_bounds import Sizes
from validation.study.gpu_counts import Counts, typical
from validation.study.gpu_limits import LIMITS
from validation.study.gpu_machines import MACHINES, Machine
from validation.study.group_zones import GroupZone, count_waits, solve_by_one

SIZES = Sizes(100_000, 50_000, 150_000, 20_000, 3000, 800, 50, 50_000, 16)
ONE = Machine(1e9, 1e9, 1e9, 3e-6, 1e-6, 20e-6, 3e-6, 100)


def test_all_parts_that_need_a_gpu_take_at_most_9_minutes():
    budgets = [part.budget_s for part in cuda.PARTS.values() if part.budget_s is not None]
    assert len(budgets) == 7
    assert sum(budgets) + cuda.GRACE_S * len(budgets) <= cuda.LIMIT_S <= 540.0


@pytest.mark.parametrize("with_gpu", [True, False])
def test_parts_run_where_they_can(tmp_path, monkeypatch, with_gpu):
    monkeypatch.setattr(cuda, "has_gpu", lambda: with_gpu)
    started, here, said = [], [], []
    monkeypatch.setattr(cuda, "run_part", lambda name, *_: here.append(name))

    def start(name, folder, limit_s, say):
        started.append((name, limit_s))
        return 0

    assert cuda.run(tmp_path, None, said.append, start) is None
    others = [name for name, part in cuda.PARTS.items() if part.budget_s is None]
    needy = [name for name in cuda.PARTS if name not in others]
    assert [name for name, _ in started] == (needy if with_gpu else [])
    assert here == ([] if with_gpu else others)
    assert len(said) == len(others if with_gpu else needy)
    assert all(limit == cuda.PARTS[name].budget_s + cuda.GRACE_S for name, limit in started)


@pytest.mark.parametrize(("failing", "runs"), [("check", 2), ("zones", 7)])
def test_a_difference_ends_the_study_and_another_failure_is_told(
    tmp_path, monkeypatch, failing, runs
):
    monkeypatch.setattr(cuda, "has_gpu", lambda: True)
    started = []

    def start(name, *_):
        started.append(name)
        return int(name == failing)

    assert cuda.run(tmp_path, None, lambda _: None, start) == f"failed: {failing}"
    assert len(started) == runs


def test_a_part_that_does_not_end_is_stopped_and_says_so(tmp_path, monkeypatch):
    run = subprocess.run

    def stopped(command, timeout=None, **more):
        if command[0] != sys.executable:
            return run(command, timeout=timeout, **more)
        assert command[1:] == ["-m", "validation", "study", "cuda", "--only", "steps", "-o", out]
        raise subprocess.TimeoutExpired(command, timeout)

    out, rows = str(tmp_path), tmp_path / "cuda" / "rows"
    monkeypatch.setattr(cuda.subprocess, "run", stopped)
    assert cuda.started("steps", rows, 77.0, lambda _: None) == 0
    (row,) = read(rows, "cut")
    assert (row["part"], row["spent_s"]) == ("steps", 77.0)


@pytest.mark.parametrize("said", [None, "step falls: status FREE"])
def test_the_command_fails_with_what_differs(tmp_path, monkeypatch, capsys, said):
    monkeypatch.setattr(cuda, "run", lambda *_: said)
    code = main(["study", "cuda", "-o", str(tmp_path)])
    assert code == (0 if said is None else 1)
    assert (said or "") in capsys.readouterr().err


def test_each_part_can_be_chosen():
    for part in cuda.PARTS:
        assert _parser().parse_args(["study", "cuda", "--only", part]).only == part


def test_a_stage_takes_the_longer_of_moving_and_computing():
    stage = gpu_bounds.Stage("some", 2e6, 3e6)
    assert gpu_bounds.stage_ms(stage, ONE) == pytest.approx(3.0)
    assert gpu_bounds.stage_ms(stage._replace(operations=1e6), ONE) == pytest.approx(2.0)


def test_the_host_works_beside_the_gpu_and_waits_for_reads():
    counts = Counts(launches=100, programs=2, copies=8, nodes=50, arrays=10, reads=5)
    assert gpu_bounds.calls_ms(counts, ONE) == pytest.approx(1e3 * (110 * 3e-6 + 10 * 3e-6))
    # the GPU takes 0.2 ms and 50 nodes of 1 us, the host 0.36 ms; 5 reads take 0.1 ms
    assert gpu_bounds.iteration_ms(0.2, counts, ONE) == pytest.approx(0.36 + 0.1)
    assert gpu_bounds.iteration_ms(1.0, counts, ONE) == pytest.approx(1.05 + 0.1)


def test_a_step_is_its_iterations_a_certificate_and_the_way_to_the_gpu():
    counts = Counts(launches=10, reads=1)
    stages = gpu_bounds.stages_of(SIZES, 300.0)
    work = [gpu_bounds.stage_ms(stage, ONE) for stage in stages]
    whole = 16 * gpu_bounds.iteration_ms(sum(work), counts, ONE) + sum(work[:3])
    whole += 1e3 * 2 * SIZES.vertices * 24 / 1e9
    assert gpu_bounds.step_ms(SIZES, 300.0, counts, ONE) == pytest.approx(whole)
    twice = SIZES._replace(pairs=2 * SIZES.pairs, found=2 * SIZES.found)
    assert gpu_bounds.step_ms(twice, 300.0, counts, ONE) > whole


def test_a_zone_is_factorised_once_a_solve():
    own = GroupZone(1000, 300, 10, 19, 100, 3e6, True)
    whole = gpu_bounds.zone_ms(own, ONE, 100)
    assert whole == pytest.approx(1e3 * 10 * 3e6 / 1e9)
    assert gpu_bounds.zone_ms(own, ONE, 1) == pytest.approx(100.0 * whole)
    assert gpu_bounds.waits_ms(own) == pytest.approx(1e3 * count_waits(own) * 1.3e-6)


def test_a_dense_factor_takes_a_third_of_the_cube(rng):
    own = solve_by_one(random_zone(rng, 200, fresh_only=True))
    assert own.solved
    assert own.tiles == own.tile_rows * (own.tile_rows + 1) // 2
    # whole tiles on the diagonal, and whole rows of the last tile
    assert 1.0 <= own.operations / (own.active**3 / 3.0) < 1.7


def test_the_counts_of_the_goal_are_those_of_the_limits():
    own = gpu_bounds.goal_counts()
    assert (own.nodes, own.reads, own.arrays) == (LIMITS["kernels"].goal, 1, 0)


def test_sizes_are_those_of_a_step(rng):
    scene = meeting_sheets(rng, 400)
    own = gpu_bounds.sizes_of(scene)
    assert (own.triangles, own.vertices) == (len(scene.faces), len(scene.pinned))
    assert own.pairs >= own.found >= own.zones > 0
    assert own.impacts <= own.rows_cubed
    assert own.iterations > 1


def test_numbers_count_what_is_done_with_them():
    number = operations.Number
    before = number.count
    a, b = number(3.0), number(4.0)
    square = (a * a + b * b) / 1.0
    root = operations.MATH.sqrt(square)
    assert (1.0 - root, 2.0 / a, -b, abs(-b), 1.0 + a, 2.0 * a) == (-4.0, 2.0 / 3.0, -4, 4, 4, 6)
    assert isinstance(root, number)
    assert a < b
    assert number.count - before == 5 + 4


def test_operations_of_proofs_are_counted_in_another_process():
    own = operations.measured_operations(100)
    assert own.pairs > 50
    assert 50.0 < own.each < own.most < 10_000


@pytest.fixture
def measured(tmp_path):
    """Return a folder with the rows of the parts that need no GPU."""
    rows = Rows(tmp_path, "counts", ("triangles", "iteration"))
    for n in (60, 200):
        for i in range(4):
            own = Counts(launches=100 + i, arrays=n, reads=7 - i)
            rows.add(triangles=n, iteration=i, **own._asdict(), host_ms=1.0)
    Rows(tmp_path, "sizes", ("triangles",)).add(**SIZES._asdict(), operations_of_a_pair=300.0)
    Rows(tmp_path, "zone_sizes", ("zone", "impacts")).add(
        zone="random",
        impacts=1000,
        active=600,
        solves=15,
        tile_rows=38,
        tiles=741,
        operations=7e7,
        solved=True,
    )
    key = {"kernel": "stage.file.kernel", "types": "f8", "capability": "8.9"}
    Rows(tmp_path, "kernels", tuple(key)).add(
        **key, registers=64, shared_bytes=0, stack_bytes=0, spilled_bytes=0
    )
    return tmp_path


def test_the_largest_counts_of_an_iteration_are_shown(measured):
    own = gpu_launches.counted_typical(measured)
    assert own == Counts(launches=103, arrays=200, reads=5)
    assert typical([Counts(), Counts(9), Counts(1, reads=2), Counts(3)]) == Counts(3, reads=2)


def test_the_page_says_what_is_computed(measured):
    text = report.page(measured, measured).read_text()
    computed = [line for line in text.splitlines() if line.endswith("| computed, not measured |")]
    assert len(computed) == 7 + 2 + 2, "stages, steps and zones"
    assert "300 operations a pair" in text
    assert f"| kernels |  | 103 | {LIMITS['kernels'].most} | 15 |" in text
    assert "Python alone takes 1 ms" in text
    # 64 registers: 2 warps of each of 8 blocks of 128 threads fit, which is 1024 of 1536 threads
    assert "| 8.9 | 64 | 0 | 0 | 0 | 1,024 | 0.6667 | 1,024 | 0.6667 |" in text
    (found,) = [line for line in computed if "counts of the goal" in line]
    assert "| 5 | yes |" in found, "the goal allows the bound"
    assert (
        f"{gpu_bounds.step_ms(SIZES, 300.0, gpu_bounds.goal_counts(), MACHINES['H200']):.4g}"
        in (found)
    )


def test_bounds_of_what_was_not_measured_are_not_shown(tmp_path):
    sections = cuda_bounds.bounds_section([], [], None)
    assert sections[1:] == ["Not measured yet."]
    assert cuda_bounds.counts_section(None, None)[-1] == "Not measured yet."


def test_sizes_are_measured_once(tmp_path, monkeypatch):
    monkeypatch.setattr(gpu_bounds, "TRIANGLES", (100,))
    monkeypatch.setattr(gpu_bounds, "STACK", (2, 3))
    monkeypatch.setattr(gpu_bounds, "IMPACTS", 6)
    each = operations.Operations(10, 3000, 900)
    monkeypatch.setattr(gpu_bounds, "measured_operations", lambda: each)
    for _ in range(2):
        assert cuda.run_part("bounds", tmp_path, lambda _: None) is None
    (row,) = read(tmp_path, "sizes")
    assert row["operations_of_a_pair"] == 300.0
    names = [row["zone"] for row in read(tmp_path, "zone_sizes")]
    assert names == ["random", "stack"]
    assert all(np.isfinite(row["solves"]) for row in read(tmp_path, "zone_sizes"))
