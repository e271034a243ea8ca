"""The command `izo inspect`: what it says, writes and returns."""

import json
import shlex
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from izo_ref.app import inspect_command
from izo_ref.app.cli import main
from izo_ref.app.inspect_text import ranges
from izo_ref.detection.mesh import edges_of
from tests.helpers.dips import dipping_spike, passing_sheets
from tests.helpers.shapes import grid
from validation import house
from validation.scenes.tangles import crossed_corner

N_PLATE = 5


def run(*words):
    """Run the command in this process and return its exit code."""
    return main([str(word) for word in words])


def save(path, frames, faces, dtype=np.float64):
    """Write an animation as an archive."""
    np.savez(path, positions=np.array(frames, dtype), faces=faces)
    return path


def write_objs(folder, frames, faces, names):
    """Write frames as a folder of OBJ files with several objects.

    Args:
        folder: Where to write.
        frames: (n, 3) each.
        faces: (m, 3).
        names: Name of each object, the vertices, and the faces that it has.
    """
    folder.mkdir()
    for number, frame in enumerate(frames):
        lines = []
        for name, vertices, own in names:
            lines.append(f"o {name}\n")
            lines += [f"v {x!r} {y!r} {z!r}\n" for x, y, z in frame[vertices].tolist()]
            lines += ["f {} {} {}\n".format(*(face + 1)) for face in faces[own]]
        (folder / f"frame_{number:04d}.obj").write_text("".join(lines))
    return folder


@pytest.fixture
def spike(tmp_path):
    """Return the path of a spike that dips through a plate in frames 3 to 7."""
    frames, faces, _ = dipping_spike()
    return save(tmp_path / "spike.npz", frames, faces)


def test_the_table_names_frames_parts_and_what_to_do(spike, capsys):
    assert run("inspect", spike) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{spike}: frames 0-9, 2 parts"
    assert lines[1:3] == ["  piece 1: 5 vertices", "  piece 2: 4 vertices"]
    rows = [line.split() for line in lines[4:12]]
    assert rows[0][:4] == ["frame", "crosses", "new", "gone"]
    assert rows[1] == ["0-2", *"--------", "clean"]
    assert rows[2][:9] == ["3", "3", "3", "-", "-", "-", "1", "0.05", "0.05"]
    assert " ".join(rows[2][9:]) == "can be resolved piece 1 x piece 2"
    assert " ".join(rows[4][9:]) == "can be resolved piece 1 x piece 2 (since 3)"
    assert rows[7][:4] == ["8", "-", "-", "3"]
    text = "\n".join(lines)
    assert "piece 1 x piece 2: cross in frames 3-7, most in frame 3 (3 crossings)" in text
    assert "can be resolved (frames 3-7):" in text


def test_the_command_that_is_named_resolves_what_crosses(spike, capsys):
    """Typed as it stands, it writes an animation of which nothing is wrong."""
    run("inspect", spike, "--thickness", "0.01")
    last = capsys.readouterr().out.splitlines()[-1]
    words = shlex.split(last.removeprefix("next: "))
    assert words[:3] == ["izo", "sequence", str(spike)]
    assert words[-2:] == ["--thickness", "0.01"]
    assert run(*words[1:]) == 0
    capsys.readouterr()
    assert run("inspect", words[words.index("-o") + 1]) == 0
    assert "clean: Nothing crosses or touches" in capsys.readouterr().out


def test_the_example_of_the_documentation_is_what_the_command_prints(capsys, monkeypatch):
    monkeypatch.chdir(house.ROOT)
    run("inspect", "data/scenes/sleeve.npz")
    page = (house.ROOT / "docs" / "animations.md").read_text()
    block = page.partition("<!-- inspect:begin -->")[2].partition("<!-- inspect:end -->")[0]
    assert block.strip() == f"```text\n{capsys.readouterr().out}```"


def test_a_step_is_inspected_and_its_next_command_resolves_it(tmp_path, capsys):
    frames, faces, _ = dipping_spike((0.5, -0.5))
    path = tmp_path / "the step.npz"
    np.savez(path, positions_t0=frames[0], positions_t1=frames[1], faces=faces)
    assert run("inspect", path) == 1
    out = capsys.readouterr().out
    assert "a step, whose start is frame 0 and whose proposed end is frame 1" in out
    words = shlex.split(out.splitlines()[-1].removeprefix("next: "))
    assert words == ["izo", "resolve", str(path), "-o", str(tmp_path / "the step-resolved.npz")]
    assert run(*words[1:]) == 0
    np.savez(path, positions_t0=frames[1], positions_t1=frames[0], faces=faces, pinned=[True] * 9)
    assert run("inspect", path) == 3
    out = capsys.readouterr().out
    assert "piece 1: 5 vertices, pinned" in out
    assert out.splitlines()[-1].endswith("--initial-intersections ratchet")


def test_a_sequence_that_starts_crossed_is_to_begin_at_its_first_clean_frame(tmp_path, capsys):
    frames, faces, _ = dipping_spike((-0.1, -0.1, 0.3, -0.1))
    path = save(tmp_path / "in.npz", frames, faces)
    assert run("inspect", path) == 1
    out = capsys.readouterr().out
    assert "crosses since the start (frames 0-1)" in out
    assert "The first frame without crossings is 2." in out
    words = shlex.split(out.splitlines()[-1].removeprefix("next: "))
    assert words[-2:] == ["--start", "2"]
    assert run(*words[1:]) == 0


def test_a_sequence_that_crosses_in_all_frames_is_to_be_pulled_apart(tmp_path, capsys):
    tangle = crossed_corner()
    frames = np.repeat(tangle.positions_t0[None], 9, axis=0)
    path = save(tmp_path / "in.npz", frames, tangle.faces)
    assert run("inspect", path) == 1
    words = shlex.split(capsys.readouterr().out.splitlines()[-1].removeprefix("next: "))
    ends = tangle.positions_t0[edges_of(tangle.faces)]
    half = 0.5 * np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))
    assert words[-2] == "--pull"
    assert float(words[-1]) == pytest.approx(half, rel=0.05)
    assert run(*words[1:]) == 0
    assert "at the start, 0 at the end" in capsys.readouterr().out


def test_the_report_has_everything_as_json(spike, tmp_path, capsys):
    assert run("inspect", spike, "--json", tmp_path / "report.json") == 1
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["verdict"] == "RESOLVABLE"
    assert [part["name"] for part in report["parts"]] == ["piece 1", "piece 2"]
    assert [frame["frame"] for frame in report["frames"]] == list(range(10))
    assert [frame["crossings"] for frame in report["frames"]] == [0] * 3 + [3] * 5 + [0] * 2
    frame = report["frames"][5]
    assert frame["pairs"][0]["since"] == 3
    assert frame["depth"] == pytest.approx(0.3)
    assert frame["first"] == [{"edge": [5, k], "face": [0, 1, 4]} for k in (6, 7, 8)]
    capsys.readouterr()
    assert run("inspect", spike, "--json", "-") == 1
    printed = capsys.readouterr()
    assert json.loads(printed.out) == report
    assert printed.err.startswith(f"{spike}: frames 0-9")


def test_named_meshes_are_the_parts_and_can_be_pinned(tmp_path, capsys):
    frames, faces, _ = dipping_spike()
    plate, spike = (slice(0, 5), slice(0, 4)), (slice(5, 9), slice(4, 7))
    folder = write_objs(tmp_path / "in", frames, faces, [("plate", *plate), ("spike", *spike)])
    assert run("inspect", folder) == 1
    assert "plate x spike (since 3)" in capsys.readouterr().out
    assert run("inspect", folder, "--pin", "plate", "--pin", "spike") == 3
    out = capsys.readouterr().out
    assert "  plate: 5 vertices, pinned" in out
    assert "cannot be resolved (frames 3-7): Pinned vertices alone cross or meet." in out
    assert run("inspect", folder, "--pin", "plate", "--start", "4", "--stop", "8") == 1
    out = capsys.readouterr().out
    assert "crosses since the start (frames 4-7)" in out
    assert out.splitlines()[-1].endswith("-resolved --start 4 --stop 8 --pin plate")


def test_an_obstacle_is_a_part_that_is_pinned(tmp_path, capsys):
    frames, faces, _ = dipping_spike()
    plate = save(tmp_path / "plate.npz", [frames[0][:N_PLATE]], faces[:4])
    own = faces[4:] - N_PLATE
    spike = save(tmp_path / "spike.npz", [f[N_PLATE:] for f in frames], own, np.float32)
    assert run("inspect", spike, "--obstacle", plate) == 1
    out = capsys.readouterr().out
    assert "  plate: 5 vertices, pinned" in out
    assert "spike x plate (since 3)" in out
    assert out.splitlines()[-1].endswith(f"--obstacle {plate}")
    save(tmp_path / "short.npz", [f[:N_PLATE] for f in frames[:4]], faces[:4])
    assert run("inspect", spike, "--obstacle", tmp_path / "short.npz") == 2
    assert "expected one frame or 10" in capsys.readouterr().err


def test_what_passes_through_between_frames_is_said(tmp_path, capsys):
    frames, faces, _ = passing_sheets((0.2, -0.2, -0.4))
    path = save(tmp_path / "in.npz", frames, faces)
    assert run("inspect", path) == 1
    out = capsys.readouterr().out
    assert "piece 1 x piece 2: pass through before frame 1" in out
    assert "can be resolved (frame 1)" in out


def test_faults_of_the_mesh_are_said(tmp_path, capsys):
    sheet, faces = grid(3)
    positions = np.concatenate((sheet, [(9.0, 9.0, 9.0), (9.5, 9.0, 9.0), (10.0, 9.0, 9.0)]))
    bad = np.concatenate((faces, [(0, 0, 1), (9, 10, 11)]))
    path = save(tmp_path / "in.npz", [positions, positions], bad)
    assert run("inspect", path) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert (
        "cannot be resolved: 1 face with a vertex twice, the first of the vertices [0, 0, 1]" in out
    )
    assert "1 face without area in the first frame, the first of the vertices [9, 10, 11]" in out
    assert "next:" not in out
    twice = np.concatenate((sheet, sheet))
    path = save(tmp_path / "twice.npz", [twice], np.concatenate((faces, faces + 9)))
    assert run("inspect", path) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert "9 vertices are exactly at the place of others in the first frame, the first is" in out
    assert "A single frame has no free one before it" in out
    assert run("inspect", path, "--weld") == 0


def test_many_coincident_vertices_are_said_before_the_work(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(inspect_command, "MANY", 5)
    sheet, faces = grid(3)
    path = save(tmp_path / "in.npz", [sheet[faces.ravel()]], np.arange(24).reshape(-1, 3))
    assert run("inspect", path) == 1
    assert capsys.readouterr().err.startswith("15 vertices are at the place of others; if they are")
    assert run("inspect", path, "--weld") == 0
    assert capsys.readouterr().err == ""


def test_coarse_floats_and_far_moves_are_said(tmp_path, capsys):
    frames, faces, _ = dipping_spike((0.5, 0.4))
    far = save(tmp_path / "far.npz", [f + 1e5 for f in frames], faces, np.float32)
    assert run("inspect", far, "--thickness", "0.001") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "numbers of float32 are 0.00781 m apart, more than the thickness of 0.001 m" in out
    moved = save(tmp_path / "moved.npz", [frames[0], 100.0 + frames[1]], faces)
    assert run("inspect", moved) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "Moves too far in frame 1: a vertex goes up to 173 m" in out


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_the_picture_is_written_whole(spike, tmp_path, suffix):
    path = tmp_path / f"picture{suffix}"
    assert run("inspect", spike, "--picture", path) == 1
    assert sorted(file.name for file in tmp_path.iterdir()) == [path.name, "spike.npz"]
    if suffix == ".svg":
        text = path.read_text()
        assert text.rstrip().endswith("</svg>")
        return
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    assert pixels.shape[1] > 1000
    # what crosses is red, and new crossings are orange
    red, green, blue = pixels.reshape(-1, 3).T
    assert np.count_nonzero((red > 100) & (green < 80) & (blue < 80)) > 200
    assert np.count_nonzero((red > 200) & (abs(green - 138) < 12) & (abs(blue - 60) < 12)) > 200


def test_the_picture_of_a_clean_animation_has_no_mesh(tmp_path):
    frames, faces, _ = dipping_spike((0.5, 0.4))
    path = save(tmp_path / "in.npz", frames, faces)
    assert run("inspect", path, "--picture", tmp_path / "picture.png") == 0
    with Image.open(tmp_path / "picture.png") as image:
        assert image.size[0] < 1200


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--start", "4", "--stop", "2"), "expected --start and --stop from 0 to 9"),
        (("--stop", "10"), "expected --start and --stop from 0 to 9"),
        (("--pin", "shirt"), "--pin: expected names of meshes, which are spike"),
        (("--picture", "picture.jpg"), "--picture: expected a file .png or .svg"),
        (("--json", "no/report.json"), "there is no folder"),
        (("--json", "spike.npz"), "is the same file as"),
        (("--thickness", "-1"), "--thickness: expected a finite number > 0"),
        (("--weld", "-1"), "--weld: expected None or a finite number >= 0"),
    ],
)
def test_wrong_words_are_refused(spike, capsys, monkeypatch, words, message):
    monkeypatch.chdir(spike.parent)
    assert run("inspect", spike, *words) == 2
    assert message in capsys.readouterr().err
    assert [path.name for path in spike.parent.iterdir()] == ["spike.npz"]


def test_bad_files_are_refused(tmp_path, capsys):
    sheet, faces = grid(3)
    path = tmp_path / "step.npz"
    for arrays, message in (
        ({"positions_t0": sheet, "faces": faces}, "positions_t1 is missing"),
        ({"positions_t0": sheet, "positions_t1": sheet[:5], "faces": faces}, "positions_t1"),
        ({"positions_t0": sheet, "positions_t1": sheet, "faces": faces + 5}, "faces: expected"),
        ({"positions_t0": sheet, "positions_t1": sheet, "faces": faces, "pinned": [1]}, "pinned"),
    ):
        np.savez(path, **arrays)
        assert run("inspect", path) == 2
        err = capsys.readouterr().err
        assert f"FileFormatError: {path}: " in err
        assert message in err
    path.write_bytes(b"PK nothing")
    assert run("inspect", path) == 2
    assert run("inspect", tmp_path / "none.obj") == 2
    frames, faces, _ = dipping_spike()
    frames[4][2, 1] = np.nan
    bad = save(tmp_path / "nan.npz", frames, faces)
    assert run("inspect", bad) == 2
    assert "frame 4" in capsys.readouterr().err


def test_a_picture_without_matplotlib_is_refused_before_the_work(spike, capsys, monkeypatch):
    monkeypatch.setattr(inspect_command, "find_spec", lambda name: None)
    assert run("inspect", spike, "--picture", spike.parent / "picture.png") == 2
    assert "pip install 'izo-ref[pictures]'" in capsys.readouterr().err


def test_an_interrupt_leaves_nothing_behind(spike, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(inspect_command._Progress, "tick", interrupt)
    with pytest.raises(KeyboardInterrupt):
        run("inspect", spike, "--json", spike.parent / "report.json")
    assert [path.name for path in spike.parent.iterdir()] == ["spike.npz"]


def test_a_reader_that_ends_first_is_no_error(spike):
    program = "from izo_ref.app.cli import entry; entry()"
    command = shlex.join([sys.executable, "-c", program, "inspect", str(spike)])
    done = subprocess.run(
        ["bash", "-c", f"{command} | head -c 0; exit ${{PIPESTATUS[0]}}"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (141, "")


def test_numbers_of_frames_are_written_as_ranges():
    assert ranges([]) == ""
    assert ranges([4]) == "4"
    assert ranges([0, 1, 2, 5, 7, 8]) == "0-2, 5, 7-8"
    assert ranges(range(0, 20, 2)) == "0, 2, 4, 6, 8, 10, and 4 more ranges"
