"""The command `izo view`: steps, results, animations, and input that it refuses."""

import sys
import types

import numpy as np
import pytest

import izo_ref
from izo_ref.app.cli import main
from izo_ref.app.files import SavedResult, load_scene, save_result, save_scene
from izo_ref.app.view import of_sequence, of_step
from izo_ref.app.view.live import show_live
from izo_ref.app.view.of_sequence import sequence_view
from izo_ref.app.view.of_step import step_view
from izo_ref.app.view.pack import unpack
from izo_ref.base.errors import OptionError
from izo_ref.formats.animation import open_animation
from tests.helpers.shapes import two_sheets, vertex_over_face
from tests.helpers.views import content_of, dipping_sheet, positions_of


@pytest.fixture
def step(tmp_path):
    """Write a step in which one vertex falls through a face, and return the file."""
    save_scene(tmp_path / "step.npz", vertex_over_face())
    return tmp_path / "step.npz"


@pytest.fixture
def animation(tmp_path):
    """Write an animation that crosses itself from frame 3 on, and return the file."""
    frames, faces = dipping_sheet()
    np.savez(tmp_path / "dip.npz", positions=frames, faces=faces)
    return tmp_path / "dip.npz"


def run(*arguments):
    return main(["view", *map(str, arguments)])


def test_a_step_is_shown_with_what_meets_on_its_path(step, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(step) == 0
    said = capsys.readouterr().out.splitlines()
    impacts = izo_ref.find_impacts(load_scene(step))
    assert said[0] == "1 pair meets on the proposed path."
    assert said[-1].startswith("page: step-view.html, ")
    content = content_of((tmp_path / "step-view.html").read_text(encoding="utf-8"))
    assert content["isStep"] is True
    assert [side["nPairs"] for side in content["sides"]] == [[0, len(impacts.toi)]]
    assert content["nZones"] == 1


def test_a_result_is_shown_beside_the_proposed_path(step, tmp_path, capsys):
    scene = load_scene(step)
    result = izo_ref.resolve(scene, 1e-3)
    save_result(tmp_path / "out.npz", result)
    page = tmp_path / "page.html"
    assert run(step, tmp_path / "out.npz", "-o", page, "--up", "y") == 0
    assert "certified free" in capsys.readouterr().out
    content = content_of(page.read_text(encoding="utf-8"))
    assert content["up"] == "y"
    assert content["sides"][1]["nPairs"] == [0, 0]
    ends = np.concatenate((scene.positions_t0, scene.positions_t1, result.positions))
    found = positions_of(content, 0.5 * (ends.min(axis=0) + ends.max(axis=0)))
    expected = [[scene.positions_t0, scene.positions_t1], [scene.positions_t0, result.positions]]
    assert np.abs(np.array(found) - np.array(expected)).max() < 1e-6

    save_result(tmp_path / "bad.npz", SavedResult(scene.positions_t1, None, None, None))
    assert run(step, tmp_path / "bad.npz", "-o", page) == 0
    said = capsys.readouterr().out
    assert "1 pair meets on the resolved path, the first at t = 0.5." in said


def test_a_step_that_crosses_at_its_start_is_shown_and_says_so(tmp_path, capsys):
    scene = vertex_over_face()
    np.savez(
        tmp_path / "crossed.npz",
        positions_t0=scene.positions_t1,
        positions_t1=scene.positions_t1,
        faces=scene.faces,
    )
    assert run(tmp_path / "crossed.npz", "-o", tmp_path / "page.html") == 0
    assert "they cross or touch at the start already" in capsys.readouterr().out


def test_an_animation_is_shown_with_what_crosses_in_each_frame(animation, tmp_path, capsys):
    page = tmp_path / "page.html"
    assert run(animation, "-o", page) == 0
    assert "edges go through faces in 3 of 6 frames" in capsys.readouterr().out
    content = content_of(page.read_text(encoding="utf-8"))
    counts = content["sides"][0]["nPairs"]
    assert counts[:3] == [0, 0, 0]
    assert all(count == 2 for count in counts[3:])  # two edges of the corner go through
    resolved = tmp_path / "resolved.npz"
    assert main(["sequence", str(animation), "-o", str(resolved), "--stop", "4"]) == 0
    capsys.readouterr()
    assert run(animation, resolved, "-o", page) == 0
    said = capsys.readouterr().out
    assert "Resolved: edges go through faces in no frame" in said
    assert "6 and 5 frames; the first 5 are shown" in said
    assert content_of(page.read_text(encoding="utf-8"))["frames"] == [0, 1, 2, 3, 4]


def test_a_long_animation_is_thinned_out_and_says_so(animation, monkeypatch):
    monkeypatch.setattr(of_sequence, "MOST_POSITIONS", 18)
    monkeypatch.setattr(of_sequence, "MOST_PAIRS", 3)
    view = sequence_view("dip", [open_animation(animation)])
    assert view.frames == [0, 2, 5]
    assert view.notes[0].startswith("3 of 6 frames are shown")
    assert view.notes[1].startswith("1 lists of pairs hold only the first pairs")
    assert view.sides[0].n_pairs == [0, 0, 2]
    assert [len(pairs.kinds) for pairs in view.sides[0].pairs] == [0, 0, 1]


def test_a_triangle_with_a_vertex_twice_is_left_out_and_said(tmp_path, capsys):
    frames, faces = dipping_sheet()
    np.savez(tmp_path / "dip.npz", positions=frames, faces=[*faces.tolist(), [3, 4, 3]])
    assert run(tmp_path / "dip.npz", "-o", tmp_path / "page.html") == 0
    said = capsys.readouterr().out
    assert "3 of 6 frames" in said
    assert "as a vertex is in them twice: 1." in said


def test_meshes_of_a_folder_are_parts_with_their_names(tmp_path):
    frames, _ = dipping_sheet(2)
    (tmp_path / "run").mkdir()
    for number, positions in enumerate(frames):
        lines = [f"v {x} {y} {z}" for x, y, z in positions.tolist()]
        text = "\n".join(["o floor", *lines[:3], "f 1 2 3", "o tip", *lines[3:], "f 4 5 6", ""])
        (tmp_path / "run" / f"f.{number}.obj").write_text(text)
    assert run(tmp_path / "run", "-o", tmp_path / "page.html") == 0
    content = content_of((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert content["parts"] == ["floor", "tip"]
    assert content["up"] == "y"
    assert unpack(content["partOf"], 1).ravel().tolist() == [0, 0, 0, 1, 1, 1]


def test_an_obstacle_is_shown_with_both_and_pinned(tmp_path, step, capsys):
    frames, faces = dipping_sheet()
    own, body = tmp_path / "own.npz", tmp_path / "body.npz"
    np.savez(own, positions=frames[:, 3:], faces=faces[:1])
    np.savez(body, positions=frames[:1, :3], faces=faces[:1])
    page = tmp_path / "page.html"
    assert run(own, own, "--obstacle", body, "-o", page) == 0
    content = content_of(page.read_text(encoding="utf-8"))
    assert content["parts"] == ["own", "body"]
    assert unpack(content["pinned"], 1).ravel().tolist() == [0, 0, 0, 1, 1, 1]
    assert [side["nPairs"] for side in content["sides"]] == [[0, 0, 0, 2, 2, 2]] * 2
    np.savez(body, positions=frames[:2, :3], faces=faces[:1])
    assert run(own, "--obstacle", body, "-o", page) == 2
    assert "expected one frame or 6" in capsys.readouterr().err
    assert run(step, "--obstacle", body, "-o", page) == 2
    assert "a step has no obstacle" in capsys.readouterr().err


def test_a_step_with_many_pairs_holds_the_first_ones(rng, monkeypatch):
    monkeypatch.setattr(of_step, "MOST_PAIRS", 2)
    view = step_view("sheets", two_sheets(rng), None)
    assert len(view.sides[0].pairs[1].kinds) == 2
    assert view.sides[0].n_pairs[1] > 2
    assert "the list has the first 2 of" in view.notes[0]


def test_input_that_does_not_fit_is_refused_and_nothing_is_written(
    step, animation, tmp_path, capsys
):
    frames, faces = dipping_sheet()
    np.savez(tmp_path / "small.npz", positions=frames[:, :5], faces=faces[:1])
    np.savez(tmp_path / "other.npz", positions=frames, faces=faces[:, ::-1])
    np.savez(tmp_path / "alone.npz", positions=frames[0])
    np.savez(tmp_path / "nan.npz", positions=np.full((6, 3), np.nan))
    page = tmp_path / "page.html"
    for words, sentence in (
        ([tmp_path / "alone.npz"], "this result has no faces; name the step first"),
        ([animation, tmp_path / "small.npz"], "expected 6 vertices"),
        ([animation, tmp_path / "other.npz"], "expected the same polygons"),
        ([animation, step], "expected an animation, as PROPOSED is; found a step"),
        ([step, tmp_path / "nan.npz"], "finite"),
        ([tmp_path / "none.npz"], "cannot be read"),
        ([tmp_path / "none.xyz"], "expected a file with one of the suffixes"),
    ):
        assert run(*words, "-o", page) == 2, words
        assert sentence in capsys.readouterr().err, words
        assert not page.exists()
    assert run(step, "-o", step) == 2
    assert "is the same file as PROPOSED" in capsys.readouterr().err


def test_live_needs_polyscope_and_says_so(step, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "polyscope", None)
    assert run(step, "--live") == 2
    assert "pip install polyscope" in capsys.readouterr().err


class Recorder(types.ModuleType):
    """Stands for polyscope: records the meshes, and calls the function of the user once."""

    def __init__(self):
        super().__init__("polyscope")
        self.meshes, self.callback = [], None
        self.imgui = types.SimpleNamespace(SliderInt=lambda *_args: (True, 0))

    def init(self):
        """Do nothing."""

    def set_up_dir(self, up):
        """Keep the axis."""
        self.up = up

    def register_surface_mesh(self, name, positions, faces):
        """Keep a mesh."""
        mesh = types.SimpleNamespace(name=name, shown=positions, faces=faces, quantities={})
        mesh.translate = lambda _offset: None
        mesh.add_scalar_quantity = lambda name, values, **_: mesh.quantities.update({name: values})
        mesh.update_vertex_positions = lambda positions: setattr(mesh, "shown", positions)
        self.meshes.append(mesh)
        return mesh

    def set_user_callback(self, callback):
        """Keep the function."""
        self.callback = callback

    def show(self):
        """Draw one frame."""
        self.callback()


def test_live_shows_each_side_and_its_frames(animation, monkeypatch):
    monkeypatch.setitem(sys.modules, "polyscope", recorder := Recorder())
    opened = open_animation(animation)
    show_live(sequence_view("dip", [opened, opened]))
    assert [mesh.name for mesh in recorder.meshes] == ["Proposed", "Resolved"]
    assert recorder.up == "z_up"
    for mesh in recorder.meshes:
        assert np.array_equal(mesh.shown, opened.frame(0))  # the slider went to frame 0
        assert set(mesh.quantities) == {"part", "pinned"}


def test_polyscope_that_is_missing_is_an_error_of_options(animation, monkeypatch):
    monkeypatch.setitem(sys.modules, "polyscope", None)
    with pytest.raises(OptionError, match="--live needs"):
        show_live(sequence_view("dip", [open_animation(animation)]))
