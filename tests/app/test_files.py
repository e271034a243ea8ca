"""Files of steps and results: round trips, and messages about files that cannot be used."""

import numpy as np
import pytest

import izo_ref
from izo_ref.app.files import (
    SavedResult,
    check_writable,
    load_result,
    load_scene,
    save_result,
    save_scene,
)
from izo_ref.base import errors
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
    with pytest.raises(errors.FileFormatError, match="length"):
        load_result(tmp_path / "short.npz")
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
