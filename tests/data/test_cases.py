"""What people bring: each file of `data/cases`, with the flags to type and the right answer."""

import json
import time
from pathlib import Path

import numpy as np
import pytest

import izo_ref
from izo_ref.app.cli import main
from izo_ref.base.records import Exclusion, PairState

FOLDER = Path(__file__).resolve().parents[2] / "data" / "cases"
CASES = json.loads((FOLDER / "index.json").read_text())
RUNS = [(name, run) for name, case in CASES.items() for run in case["runs"]]
THICKNESS = 1e-4


def arrays_of(name):
    """Return the arrays of a case."""
    with np.load(FOLDER / f"{name}.npz") as archive:
        return dict(archive)


def resolved(name, **modes):
    """Return the scene of a case and its result."""
    scene = izo_ref.Scene(**arrays_of(name), **modes)
    return scene, izo_ref.resolve(scene, CASES[name].get("thickness", THICKNESS))


@pytest.mark.parametrize(
    ("name", "run"), RUNS, ids=[" ".join([name, *run["flags"]]) for name, run in RUNS]
)
def test_the_command_gives_the_right_answer(name, run, tmp_path, capsys):
    out, report = tmp_path / "out.npz", tmp_path / "report.json"
    thickness = str(CASES[name].get("thickness", THICKNESS))
    command = ["resolve", str(FOLDER / f"{name}.npz"), "-o", str(out), "--json", str(report)]
    begin = time.process_time()
    code = main([*command, "--thickness", thickness, *run["flags"]])
    seconds = time.process_time() - begin
    said = capsys.readouterr()
    assert code == run["exit"]
    assert run.get("says", "") in said.out + said.err
    assert seconds < run.get("seconds", np.inf)
    if "status" not in run:
        assert said.err.startswith("izo: ")
        assert not out.exists()
        assert not report.exists()
        return
    content = json.loads(report.read_text())
    assert content["status"] == run["status"]
    assert content["objective_m2"] == run.get("objective", content["objective_m2"])
    assert content["objective_m2"] < run.get("objective_below", np.inf)
    assert code == 1 or (content["certificate"]["excluded"]["count"] > 0) is (code == 3)
    assert set(content["zones"]["statuses"]) <= ({"FREE"} if code != 1 else {"FREE", "BLOCKED"})
    with np.load(out) as result:
        assert len(result["positions"]) == len(arrays_of(name)["positions_t0"])


@pytest.mark.parametrize("name", ["uv-seam", "soup-320", "doubled-layer"])
def test_all_copies_of_a_welded_vertex_end_at_one_place(name):
    scene, result = resolved(name, weld=0)
    assert len(np.unique(scene.copies)) < len(scene.copies)
    assert result.positions.tobytes() == result.positions[scene.copies].tobytes()


@pytest.mark.parametrize("name", ["doubled-layer", "sheet-exactly-on-table"])
def test_layers_that_lie_on_each_other_are_protected_once_they_are_apart(name):
    scene, result = resolved(name, initial_intersections="ratchet")
    assert set(scene.excluded.reasons.tolist()) == {Exclusion.TOUCHING}
    states = set(result.certificate.excluded_ends.tolist())
    moves = name == "sheet-exactly-on-table"
    assert states == {PairState.APART if moves else PairState.TOUCHING}
    following = scene.after(result, scene.positions_t0)
    assert (following.excluded is None) is moves
    if moves:  # the sheet is below the table now, and stays there
        back = izo_ref.resolve(following, THICKNESS)
        assert back.status is izo_ref.Status.FREE
        own = ~scene.pinned
        assert (back.positions[own, 2] < 0.0).all()


def test_masses_of_pinned_vertices_do_not_matter():
    arrays = arrays_of("zero-mass-pinned")
    expected = None
    for mass in (0.0, 1.0, np.inf, np.nan):
        masses = np.where(arrays["pinned"], mass, arrays["masses"])
        scene = izo_ref.Scene(**(arrays | {"masses": masses}))
        positions = izo_ref.resolve(scene, THICKNESS).positions
        expected = positions if expected is None else expected
        np.testing.assert_array_equal(positions, expected)


def test_a_step_at_1e150_is_the_same_step_near_1():
    arrays = arrays_of("coordinates-1e150")
    near = dict(arrays)
    for name in ("positions_t0", "positions_t1"):
        near[name] = np.ldexp(arrays[name], -498)
    expected = izo_ref.resolve(izo_ref.Scene(**near), np.ldexp(1e146, -498))
    _, result = resolved("coordinates-1e150")
    np.testing.assert_array_equal(result.positions, np.ldexp(expected.positions, 498))


def test_a_light_vertex_goes_back_to_its_side_by_the_closed_form():
    """The smallest mass that is accepted, in place of 1e-310."""
    arrays = arrays_of("mass-denormal")
    arrays["masses"][arrays["masses"] < 1.0] = 2.0**-100
    scene = izo_ref.Scene(**arrays)
    result = izo_ref.resolve(scene, THICKNESS)
    light = int(np.argmin(arrays["masses"]))
    moved = result.positions - arrays["positions_t1"]
    assert result.status is izo_ref.Status.FREE
    assert np.linalg.norm(moved[light]) == pytest.approx(0.1 + THICKNESS, rel=1e-9)
    assert np.abs(np.delete(moved, light, axis=0)).max() < 1e-20


def test_the_sheets_far_from_crossing_obstacles_are_resolved():
    scene, result = resolved("obstacles-cross")
    excluded = result.certificate.excluded
    assert scene.pinned[excluded.nodes].all()
    assert set(result.zone_statuses) == {izo_ref.Status.FREE}
    assert result.converged
    assert 0.0 < result.objective < 1e-3


def test_a_waistband_in_the_body_does_not_stop_the_rest():
    scene, result = resolved("pinned-cuff")
    certificate = result.certificate
    assert set(certificate.excluded.reasons.tolist()) == {Exclusion.PRESCRIBED}
    assert scene.pinned[certificate.excluded.nodes].all()
    assert PairState.CROSSING in certificate.excluded_ends
    assert set(result.zone_statuses) == {izo_ref.Status.FREE}


def test_the_page_about_defects_names_files_that_exist():
    page = (FOLDER.parents[1] / "docs" / "defects.md").read_text()
    rows = [line for line in page.splitlines() if line.startswith("| ") and "`" in line]
    named = [name for line in rows for name in CASES if f"`{name}`" in line.rsplit("|", 2)[1]]
    assert len(named) >= 10
    files = {path.stem for path in FOLDER.glob("*.npz")}
    assert files == set(CASES)
