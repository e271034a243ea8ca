"""What the study of speed measures, and what its page says about it."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Options
from izo_ref.base.options import RULES
from tests.helpers.shapes import two_sheets
from validation.report import speed as speed_page
from validation.rows import Rows
from validation.study import speed
from validation.study.speed import BOTH, LBVH, OWN

SPREAD = {"least_s": 0.1, "most_s": 0.9, "repeats": 5}


def page(folder):
    return speed_page.page(folder / "rows", folder).read_text()


def line(text, *cells):
    """Return the lines of the tables that have all these cells."""
    rows = [[c.strip() for c in row.split("|")] for row in text.splitlines() if row[:1] == "|"]
    return [row for row in rows if set(cells) <= set(row)]


def test_a_page_without_rows_says_what_is_missing(tmp_path):
    assert page(tmp_path).count("Not measured yet.") == 7


def test_ratios_are_compared_with_their_targets(tmp_path):
    rows = Rows(tmp_path / "rows", "detection", ("step", "what", "threads"))
    for what, count, seconds in ((LBVH, 2, 0.5), (BOTH, 2, 4.0), (OWN, 2, 0.625), (OWN, 1, 1.25)):
        rows.add(step="a", what=what, threads=count, median_s=seconds, found=7, **SPREAD)
    text = page(tmp_path)
    assert len(line(text, "a", "1.25 MISSED", "0.156 MISSED")) == 1
    assert len(line(text, "a", "detection", "2")) == 1  # the speedup of two threads


def test_whole_steps_stand_beside_the_recorded_ones(tmp_path):
    rows = Rows(tmp_path / "rows", "resolve", ("step", "threads"))
    stages = {f"{name}_s": 0.25 for name in speed.STAGES}
    for step, cpu, moved in (("a", 1.0, False), ("b", 4.0, True)):
        rows.add(
            step=step,
            threads=1,
            triangles=10,
            status="FREE",
            median_s=cpu,
            **SPREAD,
            cpu_s=cpu,
            **stages,
            detect_s=0.1,
            solve_s=0.2,
            iterations=3,
            objective=0.9,
            arcsim_cpu_s=16.0,
            arcsim_objective=1.0,
            obstacle_moved=moved,
        )
    text = page(tmp_path)
    assert len(line(text, "a", "0.0625 met", "0.9")) == 1
    assert len(line(text, "b", "0.25 MISSED", "")) == 1
    assert "CPU 0.125, objective 0.9 met" in text  # the objective of b does not count


def test_calls_are_made_in_turn():
    made = []
    seconds = speed._in_turn({"a": lambda: made.append("a"), "b": lambda: made.append("b")}, 3)
    assert made == ["a", "b"] * 3
    assert [len(own) for own in seconds.values()] == [3, 3]


def test_a_resolve_is_repeated_after_one_that_compiles(rng):
    runs = speed._resolves(two_sheets(rng), Options())
    assert len(runs) == speed.REPEATS
    assert all(cpu > 0.0 and wall > 0.0 for cpu, wall, _ in runs)


def test_both_sides_of_detection_see_the_same_step(rng):
    ipctk = pytest.importorskip("ipctk")
    scene = two_sheets(rng)
    calls = speed._detection_calls(scene)
    found = {}
    for key, (call, count) in calls.items():
        call()
        found[key] = count()
    own = {n for (what, _), n in found.items() if what == OWN}
    assert own == {len(izo_ref.find_impacts(scene).toi)}
    candidates = next(n for (what, _), n in found.items() if what == LBVH)
    assert candidates >= own.pop() > 0
    assert {what for what, _ in found} == {OWN, LBVH, BOTH}
    ipctk.set_num_threads(-1)


def test_each_rule_has_its_column(tmp_path):
    rows = Rows(tmp_path / "rows", "ablation", ("step", "left_out"))
    for name in ("nothing", "everything", *RULES):
        own = {"ratio": 1.5, "arrays_mib": 2.0, "pairs": 30}
        rows.add(step="a", left_out=name, median_s=0.5, **SPREAD, **own)
    text = page(tmp_path)
    for name in RULES:
        assert len(line(text, "step", name)) == 3


def test_the_exponent_is_fitted_to_the_times(tmp_path):
    rows = Rows(tmp_path / "rows", "scale", ("size", "threads"))
    for size in (1000, 10_000, 100_000):
        rows.add(
            size=size,
            threads=1,
            triangles=size,
            total_s=1e-6 * size**1.25,
            door_s=0.0,
            peak_mib=100.0 + size * 1e-3,
            import_mib=100.0,
            outcome="converged",
        )
    text = page(tmp_path)
    assert "1.25 MISSED on 1 threads" in text
    memory = np.array([float(row[6]) for row in line(text, "converged")])
    np.testing.assert_allclose(memory, 1.0486, rtol=1e-3)
