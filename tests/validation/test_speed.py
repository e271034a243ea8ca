"""What the study of speed measures, and what its page says about it."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Options
from izo_ref.base.options import RULES
from tests.helpers.shapes import two_sheets
from validation.report import speed as speed_page
from validation.rows import Rows
from validation.study import speed_detection, speed_steps, steps
from validation.study.speed_detection import BOTH, LBVH, LBVH_THEN_S, OWN
from validation.study.timing import REPEATS, in_turn

SPREAD = {"least_s": 0.1, "most_s": 0.9, "repeats": 5}


def page(folder):
    return speed_page.page(folder / "rows", folder).read_text()


def line(text, *cells):
    """Return the lines of the tables that have all these cells."""
    rows = [[c.strip() for c in row.split("|")] for row in text.splitlines() if row[:1] == "|"]
    return [row for row in rows if set(cells) <= set(row)]


def test_a_page_without_rows_says_what_is_missing(tmp_path):
    assert page(tmp_path).count("Not measured yet.") == 10
    assert speed_page.headlines(tmp_path / "rows") == []


def test_ratios_are_compared_with_their_targets(tmp_path):
    rows = Rows(tmp_path / "rows", "detection", ("step", "what", "threads"))
    timed = ((LBVH, 2, 0.5), (BOTH, 2, 4.0), (OWN, 2, 0.625), (OWN, 1, 1.25), (LBVH, 1, 1.125))
    for what, count, seconds in timed:
        rows.add(step="a", what=what, threads=count, median_s=seconds, found=7, **SPREAD)
    text = page(tmp_path)
    assert len(line(text, "a", "1.25", "0.156 MISSED")) == 1
    assert len(line(text, "a", "1.11 MISSED")) == 1  # on one thread
    assert len(line(text, "a", "detection", "2")) == 1  # the speedup of two threads


def add_step(rows, cpu, **key):
    """Add a row of a whole step whose second round was taken back."""
    rows.add(
        **key,
        threads=1,
        triangles=10,
        status="FREE",
        median_s=cpu,
        **SPREAD,
        cpu_s=cpu,
        **{f"{name}_s": 0.25 for name in speed_steps.STAGES},
        detect_s=0.1,
        solve_s=0.2,
        iterations=3,
        objective=0.9,
        **{"objective_0": 1.2, "objective_1": 0.9, "objective_2": 0.9, "objective_3": None},
        **{"rounds_0_s": 2.0, "rounds_1_s": 2.5, "rounds_2_s": 3.5, "rounds_3_s": None},
    )


def add_peer_rows(folder, scale):
    rows = Rows(folder / "rows", "resolve", ("step", "threads"))
    arcsim = {"arcsim_cpu_s": 16.0, "arcsim_scale": scale, "arcsim_objective": 1.0}
    ratios = {f"lbvh_{step}": scale for step in LBVH_THEN_S} | {"lbvh_cores": 1.75}
    for step, cpu, moved in (("a", 1.0, False), ("b", 4.0, True)):
        more = arcsim | ratios | {"obstacle_moved": moved}
        add_step(rows, cpu, step=step, **more)


def test_whole_steps_stand_beside_the_recorded_ones(tmp_path):
    """This machine is twice as fast as the one of the records, so the ratios are doubled."""
    add_peer_rows(tmp_path, 0.5)
    text = page(tmp_path)
    assert "It had 1.8 cores while it was timed" in text
    assert len(line(text, "a", "0.0625", "0.125 met", "0.9")) == 1
    assert len(line(text, "b", "0.25", "0.5 MISSED", "")) == 1
    assert "raw CPU 0.125, scaled CPU 0.25 MISSED (wanted 0.1), objective 0.9 met" in text
    (headline,) = speed_page.headlines(tmp_path / "rows")
    assert headline.figure == "0.25"
    assert "multiplied by 0.5" in headline.sentence


def test_without_a_scale_there_is_no_ratio_to_another_machine(tmp_path):
    add_peer_rows(tmp_path, None)
    text = page(tmp_path)
    assert "so there is no ratio" in text
    assert "CPU 0." not in text
    assert speed_page.headlines(tmp_path / "rows") == []


def test_gain_and_cost_of_rounds_are_shown(tmp_path):
    rows = Rows(tmp_path / "rows", "deep", ("family", "size", "threads"))
    add_step(rows, 1.0, family="balls", size=5_000)
    text = page(tmp_path)
    assert len(line(text, "balls", "0.2 met")) == 1  # the share of re-linearising
    (row,) = line(text, "balls 5,000")
    assert row[3:-1] == ["0.75", "0.75", "", "1.25", "1.75", ""]


def test_rounds_are_read_from_the_history(rng):
    result = speed_steps.resolves(two_sheets(rng), Options(), first=0)[0][2]
    columns = speed_steps.rounds(result)
    last = max(record.round for record in result.history)
    assert last > 0
    assert columns[f"objective_{last}"] == result.objective
    spent = [columns[f"rounds_{k}_s"] for k in range(last + 1)]
    assert spent == sorted(spent)
    assert columns["objective_0"] >= result.objective
    assert spent[-1] == pytest.approx(sum(r.detect_s + r.solve_s for r in result.history))
    assert all(columns[f"objective_{k}"] is None for k in range(last + 1, 4))


def test_deep_contact_is_timed(tmp_path, monkeypatch):
    monkeypatch.setattr(speed_steps, "DEEP_SIZES", (960,))
    monkeypatch.setattr(speed_steps, "WARM_UP_SIZE", 640)
    monkeypatch.setattr(speed_steps, "thread_counts", lambda: [1])
    balls = {"balls": speed_steps.DEEP_FAMILIES["balls"]}
    monkeypatch.setattr(speed_steps, "DEEP_FAMILIES", balls)
    for _ in range(2):  # the second time nothing is missing
        speed_steps.deep(tmp_path / "rows", lambda line: None)
    (row,) = Rows(tmp_path / "rows", "deep", ()).all()
    assert (row["triangles"], row["status"], row["repeats"]) == (960, "FREE", REPEATS)
    assert len(line(page(tmp_path), "balls", "FREE")) == 1


def test_the_next_step_is_timed_both_ways(tmp_path, monkeypatch, rng):
    scene = two_sheets(rng)
    monkeypatch.setattr(steps, "load_step", lambda name: scene)
    monkeypatch.setattr(speed_steps, "thread_counts", lambda: [1])
    calls = speed_steps.next_step_calls(scene, 1.0)
    new, after = (calls[what]() for what in (speed_steps.NEW_RESOLVED, speed_steps.AFTER_RESOLVED))
    np.testing.assert_array_equal(new.positions, after.positions)
    speed_steps.following(tmp_path / "rows", lambda line: None)
    assert len(line(page(tmp_path), speed_steps.NEXT_STEP)) == len(speed_steps.NEXT_MOTIONS)


def test_the_scale_is_what_lbvh_takes_now_over_then(monkeypatch, rng):
    pytest.importorskip("ipctk", reason="LBVH of ipctk is what is timed").set_num_threads(-1)
    scene = two_sheets(rng)
    monkeypatch.setattr(steps, "load_step", lambda name: scene)
    monkeypatch.setattr(speed_detection, "thread_counts", lambda: [1, 2])
    monkeypatch.setattr(speed_detection, "in_turn", lambda calls, n: {key: [0.1] for key in calls})
    ratios, cores = speed_detection.lbvh_ratios() or ({}, 0.0)
    assert cores > 0.0
    assert ratios == {step: 0.1 / then for step, then in LBVH_THEN_S.items()}
    monkeypatch.setattr(speed_detection, "thread_counts", lambda: [1])
    assert speed_detection.lbvh_ratios() is None


def test_calls_are_made_in_turn():
    made = []
    seconds = in_turn({"a": lambda: made.append("a"), "b": lambda: made.append("b")}, 3)
    assert made == ["a", "b"] * 3
    assert [len(own) for own in seconds.values()] == [3, 3]


def test_a_resolve_is_repeated_after_one_that_compiles(rng):
    runs = speed_steps.resolves(two_sheets(rng), Options())
    assert len(runs) == REPEATS
    assert all(cpu > 0.0 and wall > 0.0 for cpu, wall, _ in runs)


def test_both_sides_of_detection_see_the_same_step(rng):
    ipctk = pytest.importorskip("ipctk", reason="LBVH of ipctk is what is timed")
    scene = two_sheets(rng)
    calls = speed_detection.detection_calls(scene)
    found = {}
    for key, (call, count) in calls.items():
        call()
        found[key] = count()
    own = {n for (what, _), n in found.items() if what == OWN}
    assert own == {len(izo_ref.find_impacts(scene).toi)}
    (candidates,) = {n for (what, _), n in found.items() if what == LBVH}
    assert candidates >= own.pop() > 0
    counts = {what: [n for name, n in found if name == what] for what in (OWN, LBVH)}
    assert counts[OWN] == counts[LBVH]
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
