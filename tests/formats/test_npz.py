"""Archives of numpy are read frame by frame, and written with all else as it was."""

import io
import os
import tracemalloc
import zipfile

import numpy as np
import pytest

from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import open_animation, triangles
from izo_ref.formats.npz import NpzAnimation
from tests.helpers.mutated import check_mutations

FACES = np.array([[0, 1, 2], [2, 1, 3]], np.uint8)


def frames_of(count=4, dtype=np.float32):
    return np.random.default_rng(1).normal(size=(count, 4, 3)).astype(dtype)


def saved(path, save=np.savez_compressed, **arrays):
    save(path, **{"positions": frames_of(), "faces": FACES, **arrays})
    return path


def refused(path, **arrays):
    with pytest.raises(FileFormatError) as caught:
        NpzAnimation(saved(path / "a.npz", **arrays)).frame(0)
    assert str(path / "a.npz") in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("dtype", ["<f4", "<f8", ">f4", ">f8"])
@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_frames_are_read_in_any_order(tmp_path, dtype, save):
    positions = frames_of(dtype=dtype)
    animation = open_animation(saved(tmp_path / "a.npz", save, positions=positions))
    assert animation.n_frames == 4
    assert animation.precision == np.dtype(dtype).newbyteorder("=").name
    for number in (0, 1, 3, 2, 2, 0):
        assert animation.frame(number).dtype == np.float64
        np.testing.assert_array_equal(animation.frame(number), positions[number])
    (mesh,) = animation.meshes
    assert (mesh.name, mesh.first, mesh.n_vertices) == ("a", 0, 4)
    np.testing.assert_array_equal(triangles(animation.meshes), FACES)


def test_what_is_written_differs_in_the_changed_positions_alone(tmp_path):
    positions = frames_of(dtype=">f4")
    positions[1, 0] = -0.0
    objects = np.array([{"a": 1}, None], object)  # is never unpickled, but kept
    path = saved(tmp_path / "a.npz", colours=np.eye(3), positions=positions, objects=objects)
    animation = NpzAnimation(path)
    new = [animation.frame(number) for number in range(3)]
    new[1][0] = 0.0  # equal, so the file keeps its sign
    new[2][3, 1] = 0.5
    animation.write(tmp_path / "b.npz", new)
    expected = positions[:3].copy()
    expected[2, 3, 1] = 0.5
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(tmp_path / "b.npz") as written:
        assert old.namelist() == written.namelist()
        for name in old.namelist():
            assert name == "positions.npy" or old.read(name) == written.read(name)
        assert written.getinfo("faces.npy").compress_type == zipfile.ZIP_DEFLATED
    with np.load(tmp_path / "b.npz") as loaded:
        assert loaded["positions"].dtype.str == ">f4"
        assert loaded["positions"].tobytes() == expected.tobytes()
    assert sorted(os.listdir(tmp_path)) == ["a.npz", "b.npz"]


def test_the_same_positions_give_the_same_arrays(tmp_path):
    animation = NpzAnimation(saved(tmp_path / "a.npz", np.savez))
    animation.write(tmp_path / "b.npz", (animation.frame(number) for number in range(4)))
    with zipfile.ZipFile(tmp_path / "a.npz") as old, zipfile.ZipFile(tmp_path / "b.npz") as new:
        assert [old.read(name) for name in old.namelist()] == [
            new.read(name) for name in old.namelist()
        ]


def test_bad_arrays_are_refused(tmp_path):
    bad = frames_of()
    bad[0, 2, 1] = np.nan
    message = refused(tmp_path, positions=bad)
    assert "frame 0: mesh 'a': expected finite" in message
    assert "at vertex 2" in message
    assert "(n_frames, n_vertices, 3)" in refused(tmp_path, positions=frames_of()[0])
    assert "float32 or float64" in refused(tmp_path, positions=frames_of(dtype=np.float16))
    assert "ascontiguousarray" in refused(tmp_path, positions=np.asfortranarray(frames_of()))
    assert "from 0 to 3" in refused(tmp_path, faces=FACES + 1)
    assert "expected integers" in refused(tmp_path, faces=FACES + 0.5)
    assert "pickle" not in refused(tmp_path, faces=np.array([None]))
    np.savez(tmp_path / "c.npz", positions=frames_of())
    with pytest.raises(FileFormatError, match="expected an array 'faces'"):
        NpzAnimation(tmp_path / "c.npz")


def test_a_wrong_checksum_is_noticed_when_the_archive_is_opened(tmp_path):
    path = saved(tmp_path / "a.npz", np.savez)
    content = bytearray(path.read_bytes())
    content[content.find(frames_of()[3].tobytes())] ^= 1
    path.write_bytes(content)
    with pytest.raises(FileFormatError, match="the array 'positions': the archive is damaged"):
        NpzAnimation(path)


def test_frames_that_do_not_fit_are_not_written(tmp_path):
    animation = NpzAnimation(saved(tmp_path / "a.npz"))
    frames = [animation.frame(number) for number in range(4)]
    far = frames[0].copy()
    far[0, 0] = np.inf
    for wrong, message in (
        ([], "at least one"),
        (frames + frames[:1], "frame 4 to write: expected at most 4"),
        ([frames[0][:3]], r"frame 0 to write: expected floats of shape \(4, 3\)"),
        ([frames[0], far], "frame 1 to write: mesh 'a': expected finite"),
        ([frames[0] + 1e-12], "rounded to float32"),
    ):
        with pytest.raises(FileFormatError, match=message):
            animation.write(tmp_path / "b.npz", wrong)
    with pytest.raises(FileFormatError, match=r"suffix \.npz"):
        animation.write(tmp_path / "b.ply", frames)
    with pytest.raises(FileFormatError, match="cannot be written"):
        animation.write(tmp_path / "no" / "b.npz", frames)
    with pytest.raises(FileFormatError, match="from 0 to 3"):
        animation.frame(4)
    assert os.listdir(tmp_path) == ["a.npz"]


@pytest.mark.parametrize("link", [os.symlink, os.link, None])
def test_the_archive_that_is_read_is_never_written_over(tmp_path, link):
    path = saved(tmp_path / "a.npz")
    content, output = path.read_bytes(), tmp_path / "b.npz"
    if link is None:
        output = tmp_path / "." / "a.npz"
    else:
        link(path, output)
    animation = NpzAnimation(path)
    with pytest.raises(FileFormatError, match="which is read"):
        animation.write(output, [animation.frame(0)])
    assert path.read_bytes() == content


def test_a_file_that_is_replaced_keeps_its_permissions(tmp_path):
    animation = NpzAnimation(saved(tmp_path / "a.npz"))
    output = saved(tmp_path / "b.npz")
    output.chmod(0o640)
    animation.write(output, [animation.frame(0)])
    assert output.stat().st_mode & 0o777 == 0o640
    assert NpzAnimation(output).n_frames == 1


def test_an_error_of_the_frames_leaves_nothing_behind(tmp_path):
    animation = NpzAnimation(saved(tmp_path / "a.npz"))

    def frames():
        yield animation.frame(0)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        animation.write(tmp_path / "b.npz", frames())
    assert os.listdir(tmp_path) == ["a.npz"]


def test_memory_does_not_grow_with_the_number_of_frames(tmp_path):
    frame = np.random.default_rng(2).normal(size=(1, 2000, 3))
    path = saved(tmp_path / "a.npz", positions=np.repeat(frame, 300, 0))
    tracemalloc.start()
    animation = NpzAnimation(path)
    animation.write(tmp_path / "b.npz", map(animation.frame, range(300)))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 300 * frame.nbytes / 2


def test_damaged_archives_are_refused_or_read_whole(tmp_path):
    contents = []
    for save in (np.savez, np.savez_compressed):
        buffer = io.BytesIO()
        saved(buffer, save, notes=np.arange(3))
        contents.append(buffer.getvalue())
    refused, _, _ = check_mutations(contents, tmp_path / "a.npz", NpzAnimation)
    assert refused > 0
