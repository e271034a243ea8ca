"""The command `izo sequence`: what it writes, and that it goes on where it was stopped."""

import json
import os

import numpy as np
import pytest

from izo_ref import Scene, certify_path
from izo_ref.app import sequence_command
from izo_ref.app.cli import main
from izo_ref.app.kept_frames import KeptFrames
from izo_ref.base.errors import FileFormatError
from izo_ref.base.whole_files import lock
from izo_ref.formats.animation import open_animation, triangles
from tests.helpers.shapes import two_sheets
from validation.scenes.tangles import crossed_corner

N_FRAMES = 6


def run(*words):
    """Run the command in this process and return its exit code."""
    return main([str(word) for word in words])


def stop_after(last, monkeypatch):
    """Interrupt the command after a frame is kept; return the list of the frames that are."""
    resolved, write = [], KeptFrames.write

    def write_and_stop(self, number, positions, report):
        resolved.append(number)
        write(self, number, positions, report)
        if number == last:
            raise KeyboardInterrupt

    monkeypatch.setattr(KeptFrames, "write", write_and_stop)
    return resolved


@pytest.fixture
def sheets(rng, tmp_path):
    """Write a sheet that falls through another one, and the two apart; return the folder."""
    scene = two_sheets(rng, 5)
    n = len(scene.positions_t0) // 2
    travel = scene.positions_t1 - scene.positions_t0
    frames = [scene.positions_t0 + part * travel for part in np.linspace(0.0, 1.0, N_FRAMES)]
    whole = np.array(frames, np.float32)
    np.savez(tmp_path / "both.npz", positions=whole, faces=scene.faces)
    lower = scene.faces[(scene.faces < n).all(axis=1)]
    upper = scene.faces[(scene.faces >= n).all(axis=1)] - n
    np.savez(tmp_path / "lower.npz", positions=whole[:, :n], faces=lower)
    np.savez(tmp_path / "upper.npz", positions=whole[:, n:], faces=upper)
    return tmp_path


def positions_of(path):
    """Return the positions of an archive."""
    with np.load(path) as archive:
        return archive["positions"]


def test_the_animation_is_resolved_and_written_as_it_was_read(sheets, capsys):
    out, report = sheets / "out.npz", sheets / "report.json"
    assert run("sequence", sheets / "both.npz", "-o", out, "--json", report) == 0
    assert capsys.readouterr().out.startswith(f"{N_FRAMES} frames: {N_FRAMES} FREE")
    before, after = positions_of(sheets / "both.npz"), positions_of(out)
    assert after.dtype == np.float32
    assert np.array_equal(before[0], after[0])
    frames = json.loads(report.read_text())["frames"]
    assert [frame["frame"] for frame in frames] == list(range(N_FRAMES))
    for frame, old, new in zip(frames, before, after, strict=True):
        assert (frame["impacts"] == 0) == np.array_equal(old, new)
    assert any(frame["impacts"] for frame in frames)
    assert not (sheets / "out.npz.frames").exists()


def test_a_run_that_is_stopped_goes_on_at_the_last_whole_frame(sheets, monkeypatch):
    assert run("sequence", sheets / "both.npz", "-o", sheets / "whole.npz") == 0
    resolved = stop_after(3, monkeypatch)
    words = "sequence", sheets / "both.npz", "-o", sheets / "out.npz"
    with pytest.raises(KeyboardInterrupt):
        run(*words)
    assert not (sheets / "out.npz").exists()
    assert run(*words) == 0
    assert resolved == [0, 1, 2, 3, 4, 5]
    assert (sheets / "out.npz").read_bytes() == (sheets / "whole.npz").read_bytes()


def test_frames_of_another_run_are_not_mixed_in(sheets, monkeypatch, capsys):
    monkeypatch.setattr(sequence_command._Input, "write", lambda *_: 1 / 0)
    words = "sequence", sheets / "both.npz", "-o", sheets / "out.npz"
    with pytest.raises(ZeroDivisionError):
        run(*words)
    monkeypatch.undo()
    assert run(*words, "--thickness", "0.01") == 2
    assert "holds frames of other inputs or options" in capsys.readouterr().err
    assert run(*words) == 0


def test_two_processes_do_not_share_a_folder(tmp_path):
    folder = tmp_path / "out.frames"
    folder.mkdir()
    handle = os.open(folder, os.O_RDONLY)
    assert lock(handle)
    with pytest.raises(FileFormatError, match="another process"):
        KeptFrames(folder, {})
    os.close(handle)
    KeptFrames(folder, {}).close(True)
    assert not folder.exists()


def test_an_obstacle_is_pinned_and_not_written(sheets):
    out = sheets / "out.npz"
    words = "sequence", sheets / "upper.npz", "-o", out, "--obstacle", sheets / "lower.npz"
    assert run(*words, "--thickness", "0.001") == 0
    upper, after = positions_of(sheets / "upper.npz"), positions_of(out)
    assert after.shape == upper.shape
    assert not np.array_equal(after, upper)


def test_frames_before_the_start_stay_and_those_after_the_stop_are_left_out(sheets):
    out = sheets / "out.npz"
    assert run("sequence", sheets / "both.npz", "-o", out, "--start", "1", "--stop", "4") == 0
    before, after = positions_of(sheets / "both.npz"), positions_of(out)
    assert len(after) == 5
    assert np.array_equal(before[:2], after[:2])


def test_what_is_tangled_is_pulled_apart_and_a_stopped_run_goes_on(tmp_path, monkeypatch, capsys):
    tangle = crossed_corner()
    frames = np.repeat(tangle.positions_t0[None].astype(np.float32), 9, axis=0)
    path, report = tmp_path / "in.npz", tmp_path / "report.json"
    np.savez(path, positions=frames, faces=tangle.faces)
    words = "sequence", path, "--pull", "0.06", "--json", report
    assert run(*words, "-o", tmp_path / "whole.npz") == 0
    crossings = [frame["crossings"] for frame in json.loads(report.read_text())["frames"]]
    assert crossings[0] > 20
    assert crossings[-1] == 0
    said = f"edges that go through faces: {crossings[0]} at the start, 0 at the end"
    assert said in capsys.readouterr().out
    stop_after(3, monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        run(*words, "-o", tmp_path / "out.npz")
    monkeypatch.undo()
    assert run(*words, "-o", tmp_path / "out.npz") == 0
    assert (tmp_path / "out.npz").read_bytes() == (tmp_path / "whole.npz").read_bytes()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--pull", "-1"), "--pull: expected a finite number of metres >= 0, got -1.0"),
        (("--start", "4", "--stop", "2"), "expected --start and --stop from 0 to 5"),
        (("--stop", "6"), "expected --start and --stop from 0 to 5"),
        (("--pin", "shirt"), "--pin: expected names of meshes"),
        (("--max-substeps", "5"), "max_substeps: expected a power of two"),
    ],
)
def test_wrong_words_are_refused_and_nothing_is_left(sheets, capsys, words, message):
    assert run("sequence", sheets / "both.npz", "-o", sheets / "out.npz", *words) == 2
    assert message in capsys.readouterr().err
    assert not list(sheets.glob("out.npz*"))


def write_objs(folder, frames, faces):
    """Write frames as a folder of OBJ files."""
    folder.mkdir()
    for number, frame in enumerate(frames):
        lines = [f"v {x!r} {y!r} {z!r}\n" for x, y, z in frame.tolist()]
        lines += ["f {} {} {}\n".format(*(face + 1)) for face in faces]
        (folder / f"frame_{number:04d}.obj").write_text("".join(lines))


def test_a_folder_of_frames_is_never_written_over_itself(rng, tmp_path, capsys):
    scene = two_sheets(rng, 4)
    write_objs(tmp_path / "in", [scene.positions_t0, scene.positions_t1], scene.faces)
    before = [path.read_text() for path in sorted((tmp_path / "in").iterdir())]
    (tmp_path / "link").symlink_to(tmp_path / "in")
    for output in ("in", "link", "in/../in"):
        assert run("sequence", tmp_path / "in", "-o", tmp_path / output) == 2
        assert "would be lost" in capsys.readouterr().err
    assert run("sequence", tmp_path / "in", "-o", tmp_path / "no" / "out") == 2
    for _ in range(2):  # an old output is replaced
        assert run("sequence", tmp_path / "in", "-o", tmp_path / "out") == 0
    after = [path.read_text() for path in sorted((tmp_path / "out").iterdir())]
    assert after[0] == before[0]
    assert after[1] != before[1]
    assert [path.read_text() for path in sorted((tmp_path / "in").iterdir())] == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in", "link", "out"]


def write_usd(path, frames, faces, move):
    """Write a mesh whose points have samples, below a transform."""
    usd = pytest.importorskip("pxr.Usd", reason="usd-core reads and writes USD")
    geometry = pytest.importorskip("pxr.UsdGeom", reason="usd-core reads and writes USD")
    stage = usd.Stage.CreateNew(str(path))
    geometry.Xform.Define(stage, "/cloth").AddTranslateOp().Set(tuple(move))
    mesh = geometry.Mesh.Define(stage, "/cloth/sheets")
    mesh.CreateFaceVertexCountsAttr([3] * len(faces))
    mesh.CreateFaceVertexIndicesAttr(faces.ravel().tolist())
    for number, frame in enumerate(frames):
        mesh.CreatePointsAttr().Set([tuple(point) for point in (frame - move).tolist()], number)
    stage.GetRootLayer().Save()


@pytest.mark.parametrize("move", [(0.0, 0.0, 0.0), (0.1, 0.2, 300.0)])
def test_what_a_file_of_usd_holds_is_certified(rng, tmp_path, move):
    """With a transform, not every float32 number in the world can be written."""
    scene = two_sheets(rng, 4)
    travel = scene.positions_t1 - scene.positions_t0
    frames = [scene.positions_t0 + part * travel + move for part in (0.0, 0.4, 0.7, 1.0)]
    write_usd(tmp_path / "in.usdc", frames, scene.faces, np.array(move))
    words = "sequence", tmp_path / "in.usdc", "-o", tmp_path / "out.usdc", "--thickness", "0.001"
    assert run(*words) == 0
    before, after = (open_animation(tmp_path / name) for name in ("in.usdc", "out.usdc"))
    assert not np.array_equal(before.frame(3), after.frame(3))
    for number in range(3):
        start, end = after.frame(number), after.frame(number + 1)
        assert certify_path(Scene(start, end, triangles(after.meshes)), end).free
