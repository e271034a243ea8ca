"""A trace has every intermediate of a run, and changes no bit of its result."""

import json

import numpy as np
import pytest

import izo_ref
from izo_ref import Impacts, Scene, Status
from izo_ref.app.cli import main
from izo_ref.app.files import save_scene
from izo_ref.base.errors import FileFormatError
from izo_ref.loop.cpu_step import CpuStep
from izo_ref.porting import trace
from izo_ref.porting.trace import trace_resolve
from izo_ref.porting.trace_files import KINDS, load_arrays, load_index
from izo_ref.zones.selection import select_impacts
from tests.helpers.own_scenes import pair_key
from tests.helpers.shapes import vertex_over_face
from tests.helpers.traced import NAMES, scenes


def found_of(arrays, place):
    """Return the impacts at a place of a trace."""
    names = ("nodes", "edge_edge_impacts", "toi", "weights", "normals")
    return Impacts(*(arrays[f"{place}/{name}"] for name in names))


def keys(impacts):
    """Return the names of the pairs of impacts."""
    return [pair_key(*row) for row in zip(impacts.nodes, impacts.is_edge_edge, strict=True)]


@pytest.mark.parametrize("name", NAMES)
def test_a_trace_changes_no_bit_of_the_result(rng, tmp_path, name):
    scene, thickness, options = scenes(rng)[name]
    expected = izo_ref.resolve(scene, thickness, options=options)
    seen = []
    result = trace_resolve(
        scene, tmp_path / "trace", thickness, options=options, on_iteration=seen.append
    )
    assert result.positions.tobytes() == expected.positions.tobytes()
    assert result.multipliers.tobytes() == expected.multipliers.tobytes()
    assert result.status is expected.status
    assert [row[:9] for row in seen] == [row[:9] for row in expected.history]

    arrays, index = load_arrays(tmp_path / "trace"), load_index(tmp_path / "trace")
    assert set(index["arrays"]) == set(arrays)
    for key, array in arrays.items():
        assert index["arrays"][key]["shape"] == list(array.shape)
    assert np.array_equal(arrays["result/positions"], result.positions)
    assert np.array_equal(arrays["result/multipliers"], result.multipliers)
    assert arrays["result/free"] == result.certificate.free
    assert arrays["scene/thickness"] == thickness
    assert index["result"]["status"] == result.status.name
    positions = [row for row in index["iterations"] if f"{row['folder']}/positions" in arrays]
    last = arrays[f"{positions[-1]['folder']}/positions"]
    assert np.array_equal(last, result.positions)


def expected_kinds(result):
    """Return how many iterations of each kind a history stands for, as far as it says so."""
    rounds = [row.round for row in result.history]
    return len([r for r in rounds if r >= 0]), max(rounds, default=0)


@pytest.mark.parametrize("name", NAMES)
def test_iterations_are_those_of_the_history(rng, tmp_path, name):
    scene, thickness, options = scenes(rng)[name]
    result = trace_resolve(scene, tmp_path / "trace", thickness, options=options)
    rows = load_index(tmp_path / "trace")["iterations"]
    assert {row["kind"] for row in rows} <= set(KINDS)
    detections = [row for row in rows if row["kind"] == "detect" and "zones" in row]
    solved = [row for row in result.history if row.round >= 0 and row.added]
    assert [row["selected"] for row in detections] == [row.added for row in solved]
    assert [row["found"] for row in detections] == [row.found for row in solved]
    assert [row["solved"] for row in detections] == [row.solved for row in solved]
    rounds = [row["round"] for row in rows if row["kind"] == "relinearize"]
    assert rounds == list(range(1, len(rounds) + 1))
    assert len(rounds) >= max((row.round for row in result.history), default=0)
    fail_safe = [row for row in rows if row["kind"] == "scale-back"]
    assert (len(fail_safe) > 0) == (name in ("scaled back", "blocked"))
    if name == "deep":
        first = f"{detections[0]['folder']}/found/deep"
        assert load_arrays(tmp_path / "trace")[first].all()


@pytest.mark.parametrize("name", ["sheets", "pinned", "all", "welded", "tiny", "deep"])
def test_stages_follow_from_the_arrays_before_them(rng, tmp_path, name):
    scene, thickness, options = scenes(rng)[name]
    trace_resolve(scene, tmp_path / "trace", thickness, options=options)
    arrays = load_arrays(tmp_path / "trace")
    own = {n: arrays[f"scene/{n}"] for n in ("faces", "masses", "pinned")}
    checked, path = 0, scene.positions_t1
    for row in load_index(tmp_path / "trace")["iterations"]:
        folder = row["folder"]
        if row["kind"] == "detect":
            assert np.array_equal(arrays[f"{folder}/positions_t1"], path)
            again = Scene(arrays["scene/positions_t0"], path, **own, weld=scene.weld)
            found = found_of(arrays, f"{folder}/found")
            expected = izo_ref.find_impacts(again)
            assert set(keys(found)) == set(keys(expected))
            times = dict(zip(keys(expected), expected.toi, strict=True))
            assert [times[key] for key in keys(found)] == pytest.approx(list(found.toi), abs=1e-12)
        if f"{folder}/found/selected" in arrays:
            hopeful = arrays[f"{folder}/found/hopeful"]
            deep = arrays.get(f"{folder}/found/deep")
            deep = None if deep is None else deep[hopeful]
            chosen = select_impacts(found.take(hopeful), again.pinned, row["selection"], deep)
            assert np.array_equal(arrays[f"{folder}/found/selected"][hopeful], chosen)
            assert not arrays[f"{folder}/found/selected"][~hopeful].any()
        if f"{folder}/zones/zone_of_impact" in arrays:
            impacts = found_of(arrays, f"{folder}/zones")
            zones = izo_ref.build_zones(scene, impacts)
            numbers = arrays[f"{folder}/zones/zone_of_impact"]
            groups = {tuple(np.flatnonzero(numbers == zone)) for zone in range(numbers.max() + 1)}
            assert groups == {tuple(zones.impacts_of(zone)) for zone in range(len(zones))}
            force = np.zeros((len(scene.pinned), 3))
            pushes = arrays[f"{folder}/multipliers"][:, None] * impacts.normals
            for k in range(4):
                np.add.at(force, impacts.nodes[:, k], impacts.weights[:, k, None] * pushes)
            moved = arrays[f"{folder}/positions"] - scene.positions_t1
            free = ~scene.pinned & (scene.masses > 0.0)
            scale = np.abs(force).max()
            momentum = (scene.masses[:, None] * moved)[free]
            assert momentum == pytest.approx(force[free], abs=1e-6 * scale)
            checked += 1
        path = arrays.get(f"{folder}/positions", path)
    assert checked


def test_impacts_of_the_result_are_the_zones_of_the_last_solve(rng, tmp_path):
    scene, thickness, options = scenes(rng)["welded"]
    result = trace_resolve(scene, tmp_path / "trace", thickness, options=options)
    arrays = load_arrays(tmp_path / "trace")
    assert keys(found_of(arrays, "result")) == keys(result.impacts)
    assert set(np.unique(arrays["result/nodes"])) <= set(np.unique(scene.copies))
    again = Scene(
        *(arrays[f"scene/{n}"] for n in ("positions_t0", "positions_t1", "faces", "masses")),
        arrays["scene/pinned"],
        weld=0,
    )
    assert np.array_equal(again.faces, arrays["scene/welded_faces"])
    assert np.array_equal(again.copies, arrays["scene/copies"])
    assert izo_ref.resolve(again, thickness).positions.tobytes() == result.positions.tobytes()


def test_a_folder_with_files_is_refused_before_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr(trace, "resolve", lambda *rest, **more: pytest.fail("it ran"))
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "file").write_text("text")
    for name, message in (
        ("old", "expected an empty folder"),
        ("old/file", "found a file"),
        ("no/such", "there is no folder"),
    ):
        with pytest.raises(FileFormatError, match=message):
            trace_resolve(vertex_over_face(), tmp_path / name, 0.1)


def test_a_run_that_fails_leaves_no_index(tmp_path, monkeypatch):
    def fail(self, first_new):
        raise MemoryError("none left")

    monkeypatch.setattr(CpuStep, "solve", fail)
    with pytest.raises(MemoryError):
        trace_resolve(vertex_over_face(), tmp_path / "trace", 0.1)
    names = {path.name for path in (tmp_path / "trace").iterdir()}
    assert names == {"iteration-0001"}


def test_the_command_writes_a_trace(tmp_path, capsys):
    save_scene(tmp_path / "step.npz", vertex_over_face())
    words = ["resolve", str(tmp_path / "step.npz"), "--thickness", "0.1"]
    plain = [*words, "-o", str(tmp_path / "plain.npz")]
    assert main(plain) == 0
    traced = [*words, "-o", str(tmp_path / "out.npz"), "--trace", str(tmp_path / "trace")]
    assert main(traced) == 0
    index = json.loads((tmp_path / "trace" / "index.json").read_text())
    assert index["result"]["status"] == Status.FREE.name
    with np.load(tmp_path / "plain.npz") as a, np.load(tmp_path / "out.npz") as b:
        assert a["positions"].tobytes() == b["positions"].tobytes()
    capsys.readouterr()
    assert main(traced) == 2
    assert "expected an empty folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("file", "content", "message"),
    [
        ("scene/faces.npy", b"no array", "expected an array of numpy"),
        ("dump.npz", b"no archive", "the archive is damaged"),
    ],
)
def test_damaged_files_are_named(tmp_path, file, content, message):
    (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / file).write_bytes(content)
    with pytest.raises(FileFormatError, match=message):
        load_arrays(tmp_path)
    with pytest.raises(FileFormatError, match="no such folder"):
        load_arrays(tmp_path / "none")


def test_an_archive_and_a_folder_hold_the_same_arrays(tmp_path):
    arrays = {"scene/faces": np.arange(3), "result/positions": np.zeros((1, 3))}
    np.savez(tmp_path / "dump.npz", **arrays)
    for where in (tmp_path, tmp_path / "dump.npz"):
        assert set(load_arrays(where)) == set(arrays)
    (tmp_path / "scene").mkdir()
    np.save(tmp_path / "scene" / "faces.npy", np.arange(3))
    with pytest.raises(FileFormatError, match="in two files"):
        load_arrays(tmp_path)
