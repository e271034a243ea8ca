"""Files of steps and results: round trips, and messages about files that cannot be used."""

import re

import numpy as np
import pytest

import izo_ref
from izo_ref.app.files import (
    SavedResult,
    check_outputs,
    check_writable,
    load_result,
    load_scene,
    save_result,
    save_scene,
)
from izo_ref.base import errors
from tests.helpers.seams import seams
from tests.helpers.shapes import vertex_over_face


def test_a_step_survives_the_round_trip(tmp_path):
    scene = vertex_over_face(masses=(1.0, 2.0, 3.0, 4.0), pinned=(True, False, False, True))
    save_scene(tmp_path / "step.npz", scene)
    again = load_scene(tmp_path / "step.npz")
    for name in ("positions_t0", "positions_t1", "faces", "masses", "pinned"):
        np.testing.assert_array_equal(getattr(again, name), getattr(scene, name))


def test_masses_and_pinned_are_optional(tmp_path):
    scene = vertex_over_face()
    np.savez(
        tmp_path / "step.npz",
        positions_t0=scene.positions_t0,
        positions_t1=scene.positions_t1,
        faces=scene.faces,
    )
    assert load_scene(tmp_path / "step.npz").masses.tolist() == [1.0] * 6


def test_a_welded_step_survives_the_round_trip(tmp_path, rng):
    """The file has the faces, masses and pins of all vertices, as they were passed in."""
    mesh = seams(rng)["pinned soup"]
    scene = izo_ref.Scene(**mesh, weld=0)
    save_scene(tmp_path / "step.npz", scene)
    with np.load(tmp_path / "step.npz") as archive:
        assert sorted(archive.files) == sorted(mesh)
        for name, array in mesh.items():
            np.testing.assert_array_equal(archive[name], array)
    again = load_scene(tmp_path / "step.npz", weld=0)
    for name in ("positions_t0", "positions_t1", "faces", "masses", "pinned", "copies"):
        np.testing.assert_array_equal(getattr(again, name), getattr(scene, name))


def positions_only(positions):
    """Return a saved result that has positions and no zones."""
    return SavedResult(positions, None, None, None)


def test_a_result_survives_the_round_trip(tmp_path):
    """The zones are saved too, so that they can be judged again."""
    result = izo_ref.resolve(vertex_over_face(), 1e-3)
    save_result(tmp_path / "out.npz", result)
    again = load_result(tmp_path / "out.npz")
    assert again.thickness == 1e-3
    np.testing.assert_array_equal(again.positions, result.positions)
    np.testing.assert_array_equal(again.multipliers, result.multipliers)
    for column, expected in zip(again.impacts, result.impacts, strict=True):
        np.testing.assert_array_equal(column, expected)


def test_a_result_with_incomplete_zones_is_refused(tmp_path):
    result = izo_ref.resolve(vertex_over_face(), 1e-3)
    save_result(tmp_path / "out.npz", result)
    with np.load(tmp_path / "out.npz") as archive:
        arrays = {name: archive[name] for name in archive.files}
    np.savez(tmp_path / "short.npz", **arrays | {"multipliers": arrays["multipliers"][:0]})
    with pytest.raises(
        errors.FileFormatError, match=r"a row for each impact, .*multipliers \(0,\)"
    ):
        load_result(tmp_path / "short.npz")
    single = {name: array.ravel()[0] for name, array in arrays.items() if name != "positions"}
    np.savez(tmp_path / "single.npz", **arrays | single)
    with pytest.raises(errors.FileFormatError, match=r"multipliers \(\), impact_nodes \(\)"):
        load_result(tmp_path / "single.npz")
    np.savez(tmp_path / "two.npz", **arrays | {"thickness": [1e-3, 1e-3]})
    with pytest.raises(errors.FileFormatError, match="thickness"):
        load_result(tmp_path / "two.npz")
    del arrays["impact_normals"]
    np.savez(tmp_path / "half.npz", **arrays)
    with pytest.raises(errors.FileFormatError, match="impact_normals is missing"):
        load_result(tmp_path / "half.npz")


def test_positions_survive_the_round_trip(tmp_path):
    save_result(tmp_path / "out", positions_only(np.eye(3)))  # numpy would add an ending
    np.testing.assert_array_equal(load_result(tmp_path / "out").positions, np.eye(3))


def test_unreadable_files_are_named(tmp_path):
    with pytest.raises(errors.FileFormatError, match="none"):
        load_scene(tmp_path / "none.npz")
    (tmp_path / "text.npz").write_text("not an archive")
    with pytest.raises(errors.FileFormatError, match="expected an"):
        load_scene(tmp_path / "text.npz")
    np.save(tmp_path / "one.npy", np.eye(3))
    with pytest.raises(errors.FileFormatError, match="single array"):
        load_scene(tmp_path / "one.npy")
    np.savez(tmp_path / "part.npz", positions_t0=np.eye(3))
    with pytest.raises(errors.FileFormatError, match="positions_t1, faces missing"):
        load_scene(tmp_path / "part.npz")
    np.savez(tmp_path / "objects.npz", positions=np.array([None]))
    with pytest.raises(errors.FileFormatError):
        load_result(tmp_path / "objects.npz")


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("cloth.obj", b"v 0 0 0\n", [r"another format \(\.obj\)", "trimesh", "numpy.savez"]),
        ("README.md", b"# A step\n", [r"another format \(\.md\)", "only format"]),
        ("step.npz", b"", ["an empty file"]),
        ("step.npz", b"nothing known", ["something else"]),
        ("step.npz", b"PK\x03\x04 and then something else", ["damaged"]),
    ],
)
def test_a_file_of_another_format_is_named(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(errors.FileFormatError) as caught:
        load_scene(tmp_path / name)
    for word in (name, *words):
        assert re.search(word, str(caught.value))


def test_any_damage_is_an_error_of_the_file(tmp_path):
    """1,000 copies of a step with up to three damaged bytes are read, or refused as files.

    The zip format checks each array by a sum of 32 bits, so a copy that is read has its numbers.
    """
    rng = np.random.default_rng(20261128)
    path, whole = tmp_path / "step.npz", izo_ref.Scene(np.eye(3), np.eye(3) + 1.0, [[0, 1, 2]])
    save_scene(path, whole)
    content, refused = path.read_bytes(), 0
    for _ in range(1000):
        damaged = bytearray(content)
        for place in rng.integers(len(content), size=rng.integers(1, 4)):
            damaged[place] = rng.integers(256)
        path.write_bytes(damaged[: rng.integers(len(content))] if rng.random() < 0.1 else damaged)
        try:
            found = load_scene(path)
        except errors.IzoError:
            refused += 1
        else:
            np.testing.assert_array_equal(found.positions_t1, whole.positions_t1)
    assert refused > 500


def test_an_output_that_is_an_input_or_another_output_is_refused(tmp_path):
    step, out = tmp_path / "step.npz", tmp_path / "out.npz"
    step.write_bytes(b"")
    (tmp_path / "link.npz").symlink_to(step)
    check_outputs({"the step": step, "--positions": step}, {"-o": out, "--json": None})
    for inputs, outputs in (
        ({"the step": step}, {"-o": tmp_path / "link.npz"}),
        ({"the step": step}, {"-o": tmp_path / "." / "step.npz"}),
        ({"the step": step}, {"-o": out, "--json": out}),
    ):
        with pytest.raises(errors.FileFormatError, match="is the same file as"):
            check_outputs(inputs, outputs)


def test_a_failed_write_keeps_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "out.npz"
    save_result(path, positions_only(np.eye(3)))

    def fail(file, **arrays):
        file.write(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(np, "savez_compressed", fail)
    with pytest.raises(KeyboardInterrupt):
        save_result(path, positions_only(np.zeros((3, 3))))
    assert [p.name for p in tmp_path.iterdir()] == ["out.npz"]
    np.testing.assert_array_equal(load_result(path).positions, np.eye(3))


def test_an_output_that_cannot_be_written_is_refused_before_work(tmp_path):
    check_writable(tmp_path / "fine.npz")
    with pytest.raises(errors.FileFormatError, match="cannot be written"):
        check_writable(tmp_path / "nowhere" / "out.npz")
    with pytest.raises(errors.FileFormatError, match="cannot be written"):
        check_writable(tmp_path)
