"""Point caches are read frame by frame; their polygons come from a file with the same vertices."""

import os
import struct
import tracemalloc

import numpy as np
import pytest

from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import open_animation, triangles
from izo_ref.formats.caches import Mdd, PointCache2
from tests.helpers.mutated import check_mutations

OBJ = (
    b"o A\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no B\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 5 6 7\n"
)
FRAMES = np.random.default_rng(1).normal(size=(4, 7, 3)).astype(np.float32)
KINDS = {".pc2": PointCache2, ".mdd": Mdd}


def pc2(frames, start=1.0, rate=0.5):
    head = b"POINTCACHE2\0" + struct.pack("<iiffi", 1, frames.shape[1], start, rate, len(frames))
    return head + struct.pack(f"<{frames.size}f", *frames.ravel().tolist())


def mdd(frames):
    times = [number * number / 25 for number in range(len(frames))]
    head = struct.pack(">ii", *frames.shape[:2]) + struct.pack(f">{len(frames)}f", *times)
    return head + struct.pack(f">{frames.size}f", *frames.ravel().tolist())


PACKED = {".pc2": pc2, ".mdd": mdd}
EACH = pytest.mark.parametrize("suffix", KINDS)


def saved(folder, suffix, content=None):
    (folder / "a.obj").write_bytes(OBJ)
    path = folder / f"a{suffix}"
    path.write_bytes(PACKED[suffix](FRAMES) if content is None else content)
    return path


def refused(folder, suffix, content):
    path = saved(folder, suffix, content)
    with pytest.raises(FileFormatError) as caught:
        open_animation(path).frame(0)
    assert str(path) in str(caught.value)
    return str(caught.value)


@EACH
def test_frames_are_read_in_any_order(tmp_path, suffix):
    animation = open_animation(saved(tmp_path, suffix))
    assert (animation.n_frames, animation.precision) == (4, "float32")
    for number in (0, 3, 1, 2, 2):
        np.testing.assert_array_equal(animation.frame(number), FRAMES[number])
        assert animation.frame(number).dtype == np.float64
    assert [(mesh.name, mesh.first, mesh.n_vertices) for mesh in animation.meshes] == [
        ("A", 0, 3),
        ("B", 3, 4),
    ]
    assert triangles(animation.meshes).tolist() == [[0, 1, 2], [3, 4, 5], [3, 5, 6]]
    with pytest.raises(FileFormatError, match="from 0 to 3"):
        animation.frame(-1)


@EACH
def test_what_is_written_differs_in_the_changed_positions_alone(tmp_path, suffix):
    frames = FRAMES.copy()
    frames[1, 0] = -0.0
    path = saved(tmp_path, suffix, PACKED[suffix](frames))
    animation = open_animation(path)
    new = [animation.frame(number) for number in range(4)]
    new[1][0] = 0.0  # equal, so the file keeps its sign
    animation.write(tmp_path / f"same{suffix}", new)
    assert (tmp_path / f"same{suffix}").read_bytes() == path.read_bytes()
    new[2][3, 1] = frames[2, 3, 1] = 0.5
    animation.write(tmp_path / f"short{suffix}", iter(new[:3]))
    assert (tmp_path / f"short{suffix}").read_bytes() == PACKED[suffix](frames[:3])
    names = ["a.obj", path.name, f"same{suffix}", f"short{suffix}"]
    assert sorted(os.listdir(tmp_path)) == sorted(names)


@EACH
def test_the_polygons_are_named_or_beside_the_cache(tmp_path, suffix):
    path = saved(tmp_path, suffix)
    (tmp_path / "a.obj").rename(tmp_path / "b.obj")
    assert open_animation(path, tmp_path / "b.obj").meshes[1].name == "B"
    with pytest.raises(FileFormatError, match=r"a\.obj or a\.ply, beside it, found neither"):
        open_animation(path)
    ply = b"ply\nformat ascii 1.0\nelement vertex 7\n"
    ply += b"".join(b"property float %s\n" % axis for axis in (b"x", b"y", b"z"))
    ply += b"end_header\n" + b"0 0 0\n" * 7
    (tmp_path / "a.ply").write_bytes(ply)
    assert open_animation(path).meshes[0].n_vertices == 7
    (tmp_path / "a.obj").write_bytes(OBJ)
    with pytest.raises(FileFormatError, match="found both; name it"):
        open_animation(path)
    (tmp_path / "b.obj").write_bytes(OBJ.replace(b"v 0 0 0\n", b"").replace(b"7", b"6"))
    with pytest.raises(FileFormatError, match=r"expected the 6 vertices of .*b\.obj, found 7"):
        open_animation(path, tmp_path / "b.obj")
    for wrong in (tmp_path, path, tmp_path / "none.obj"):
        with pytest.raises(FileFormatError):
            open_animation(path, wrong)


@EACH
def test_bad_caches_are_refused(tmp_path, suffix):
    good = PACKED[suffix](FRAMES)
    for cut in range(0, len(good), 5):
        refused(tmp_path, suffix, good[:cut])
    assert "but there are" in refused(tmp_path, suffix, good + b"\0")
    assert "at least one frame" in refused(tmp_path, suffix, PACKED[suffix](FRAMES[:, :0]))
    assert "at least one frame" in refused(tmp_path, suffix, PACKED[suffix](FRAMES[:0]))
    frames = FRAMES.copy()
    frames[0, 4, 1] = np.inf
    message = refused(tmp_path, suffix, PACKED[suffix](frames))
    assert "frame 0: mesh 'B': expected finite coordinates" in message
    assert "at vertex 1" in message


def test_wrong_heads_are_refused(tmp_path):
    good = pc2(FRAMES)
    assert "version 1, found" in refused(tmp_path, ".pc2", good.replace(b"CACHE2", b"CACHE3"))
    for number in (-1, 2**31 - 1):
        huge = struct.pack("<i", number)
        for content in (good[:16] + huge + good[20:], good[:28] + huge + good[32:]):
            refused(tmp_path, ".pc2", content)
    good = mdd(FRAMES)
    tracemalloc.start()
    for number in (-1, 2**31 - 1):
        huge = struct.pack(">i", number)
        for content in (huge + good[4:], good[:4] + huge + good[8:]):
            refused(tmp_path, ".mdd", content)
    assert tracemalloc.get_traced_memory()[1] < 1 << 20
    tracemalloc.stop()


@EACH
def test_files_that_are_read_are_never_written_over(tmp_path, suffix):
    path = saved(tmp_path, suffix)
    animation = open_animation(path)
    os.link(path, tmp_path / f"hard{suffix}")
    (tmp_path / f"topology{suffix}").symlink_to(tmp_path / "a.obj")
    for name in (path.name, f"hard{suffix}", f"topology{suffix}"):
        with pytest.raises(FileFormatError, match="which is read"):
            animation.write(tmp_path / name, [animation.frame(0)])
    with pytest.raises(FileFormatError, match="expected the suffix"):
        animation.write(tmp_path / "a.obj", [animation.frame(0)])
    assert (tmp_path / "a.obj").read_bytes() == OBJ
    assert path.read_bytes() == PACKED[suffix](FRAMES)


@EACH
def test_memory_does_not_grow_with_the_number_of_frames(tmp_path, suffix):
    text = b"v 0 0 0\n" * 1000
    frames = np.ones((300, 1000, 3), np.float32)
    path = saved(tmp_path, suffix, PACKED[suffix](frames))
    (tmp_path / "a.obj").write_bytes(text)
    animation = open_animation(path)
    peaks = []
    for count in (20, len(frames)):
        tracemalloc.start()
        animation.write(tmp_path / f"b{suffix}", map(animation.frame, range(count)))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]


@EACH
def test_damaged_caches_are_refused_or_read_whole(tmp_path, suffix):
    saved(tmp_path, suffix)
    content = PACKED[suffix](FRAMES)
    topology = tmp_path / "a.obj"
    refused, read, _ = check_mutations(
        [content], tmp_path / f"a{suffix}", lambda path: open_animation(path, topology), n_copies=20
    )
    assert refused > 0
    assert read > 0
