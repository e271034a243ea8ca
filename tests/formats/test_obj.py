"""OBJ files are read frame by frame; what is written differs in changed coordinates alone."""

import os
import tracemalloc

import numpy as np
import pytest
import trimesh

from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import open_animation, triangles
from izo_ref.formats.obj import ObjAnimation
from tests.helpers.mutated import check_mutations, read_all

TWO = b"""# written by hand \xff
mtllib cloth.mtl
o Cloth.001
v 0 0 0 0.1 0.2 0.3
v  1.0\t0.0 -0 1 1 1
v 1.00000000000000000001 1e0 0 # a corner
v 0 1 0
vt 0.25 0.75
vn 0 0 1
usemtl Cotton
s off
f 1/1/1 2/1/1 3/1/1 4/1/1
o Ball
v 5 5 5
v 6 5 5
v 5 6 5
v 5 5 6
f -4//1 -3//1 -2//1
f -4 -2 -1
l 5 8
"""
PLAIN = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def single(path, content=TWO):
    (path / "a.obj").write_bytes(content)
    return ObjAnimation(path / "a.obj")


def folder(path, *contents, names=None):
    (path / "frames").mkdir()
    for number, content in enumerate(contents):
        name = names[number] if names else f"cloth_v2_{number + 9:d}.obj"
        (path / "frames" / name).write_bytes(content)
    return path / "frames"


def refused(path, content):
    with pytest.raises(FileFormatError) as caught:
        single(path, content)
    message = str(caught.value)
    assert message.startswith(f"{path / 'a.obj'}: frame 0: ")
    return message


def moved(content, shift):
    """Return a file with other coordinates."""
    return content.replace(b"v 5 5 5", f"v {5 + shift} 5 5".encode())


def test_objects_are_meshes_and_polygons_stay_whole(tmp_path):
    animation = single(tmp_path)
    cloth, ball = animation.meshes
    assert (cloth.name, cloth.first, cloth.n_vertices) == ("Cloth.001", 0, 4)
    assert (ball.name, ball.first, ball.n_vertices) == ("Ball", 4, 4)
    assert cloth.counts.tolist() == [4]
    assert ball.counts.tolist() == [3, 3]
    assert ball.corners.tolist() == [0, 1, 2, 0, 2, 3]
    assert triangles(animation.meshes).tolist() == [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    assert animation.frame(0)[:3].tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert (animation.n_frames, animation.precision) == (1, "float64")


def test_groups_are_meshes_where_no_polygon_joins_them(tmp_path):
    text = PLAIN.replace(b"f", b"g one\nf") + b"g two\nv 3 0 0\nf 1 2 4\ng three\n" + PLAIN
    one, three = single(tmp_path, text + b"f -3 -2 -1\n").meshes
    assert (one.name, one.first, one.n_vertices) == ("a", 0, 4)
    assert one.corners.tolist() == [0, 1, 2, 0, 1, 3, 0, 1, 2]
    assert (three.name, three.first, three.n_vertices) == ("three", 4, 3)
    assert three.corners.tolist() == [0, 1, 2]


def test_bytes_stay_where_coordinates_are_equal(tmp_path):
    animation = single(tmp_path, TWO.replace(b"\n", b"\r\n"))
    new = animation.frame(0)
    new[1, 2] = 0.0  # the file has -0
    animation.write(tmp_path / "same.obj", [new])
    assert (tmp_path / "same.obj").read_bytes() == TWO.replace(b"\n", b"\r\n")
    new[2, 0], new[7, 1] = 0.1, 1 / 3
    animation.write(tmp_path / "new.obj", [new])
    expected = TWO.replace(b"1.00000000000000000001", b"0.1")
    expected = expected.replace(b"v 5 5 6", b"v 5 0.3333333333333333 6")
    assert (tmp_path / "new.obj").read_bytes() == expected.replace(b"\n", b"\r\n")
    np.testing.assert_array_equal(ObjAnimation(tmp_path / "new.obj").frame(0), new)


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_continued_lines_and_all_ends_of_lines(tmp_path, end):
    text = b"\xef\xbb\xbfv 0 \\\n0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n 3\n".replace(b"\n", end)
    animation = single(tmp_path, text)
    assert animation.meshes[0].corners.tolist() == [0, 1, 2]
    new = animation.frame(0)
    new[0, 1] = 0.5
    animation.write(tmp_path / "b.obj", [new])
    assert (tmp_path / "b.obj").read_bytes() == text.replace(b"0 0", b"0.5 0", 1)


def test_another_reader_finds_the_same(tmp_path):
    dice = np.random.default_rng(3)
    # it reads no comments behind numbers, and colours of all vertices or of none
    text = TWO.replace(b" # a corner", b"").replace(b" 1 1 1\n", b"\n")
    animation = single(tmp_path, text.replace(b" 0.1 0.2 0.3", b""))
    new = dice.normal(size=(8, 3)) * 10.0 ** dice.integers(-30, 30, (8, 3))
    animation.write(tmp_path / "b.obj", [new])
    scene = trimesh.load(tmp_path / "b.obj", process=False, split_objects=True)
    for mesh in animation.meshes:
        found, own = scene.geometry[mesh.name], new[mesh.first :][: mesh.n_vertices]
        np.testing.assert_array_equal(
            np.unique(found.vertices, axis=0), np.unique(own, axis=0), strict=True
        )
        assert len(found.faces) == len(triangles([mesh]))


def test_a_folder_is_written_file_by_file(tmp_path):
    path = folder(tmp_path, TWO, moved(TWO, 1), moved(TWO, 2).replace(b"hand", b"a tool"))
    (path / "cloth.mtl").write_bytes(b"newmtl Cotton\n")
    (path / "._cloth_v2_9.obj").write_bytes(b"hidden")
    animation = open_animation(path)
    assert animation.n_frames == 3
    frames = [animation.frame(number) for number in range(3)]
    assert [frame[4, 0] for frame in frames] == [5, 6, 7]
    frames[1][0, 0] = 0.25
    animation.write(tmp_path / "out", frames[:2])
    names = ["cloth.mtl", "cloth_v2_10.obj", "cloth_v2_9.obj"]
    assert sorted(os.listdir(tmp_path / "out")) == names
    assert (tmp_path / "out/cloth_v2_9.obj").read_bytes() == TWO
    expected = moved(TWO, 1).replace(b"v 0 0 0 0.1", b"v 0.25 0 0 0.1")
    assert (tmp_path / "out/cloth_v2_10.obj").read_bytes() == expected
    animation.write(tmp_path / "out", frames)  # replaces what it wrote
    assert len(os.listdir(tmp_path / "out")) == 4
    assert (tmp_path / "out/cloth_v2_11.obj").read_bytes() == (
        path / "cloth_v2_11.obj"
    ).read_bytes()
    np.testing.assert_array_equal(open_animation(tmp_path / "out").frame(1), frames[1])


def test_a_folder_with_other_files_is_not_replaced(tmp_path):
    animation = open_animation(folder(tmp_path, PLAIN, PLAIN))
    frames = [animation.frame(0)]
    out = tmp_path / "out"
    out.mkdir()
    (out / "notes.txt").write_text("mine")
    with pytest.raises(FileFormatError, match=r"'notes\.txt', which would be deleted"):
        animation.write(out, frames)
    for same in (tmp_path / "frames", tmp_path, tmp_path / "out" / ".." / "frames"):
        with pytest.raises(FileFormatError, match="expected another folder"):
            animation.write(same, frames)
    (tmp_path / "link").symlink_to(tmp_path / "frames")
    with pytest.raises(FileFormatError, match="expected another folder"):
        animation.write(tmp_path / "link", frames)
    (tmp_path / "file").write_text("")
    with pytest.raises(FileFormatError, match="expected a folder or nothing"):
        animation.write(tmp_path / "file", frames)
    assert sorted(os.listdir(tmp_path)) == ["file", "frames", "link", "out"]
    assert os.listdir(out) == ["notes.txt"]


def test_links_to_frames_protect_their_folder(tmp_path):
    frames = folder(tmp_path, PLAIN)
    (tmp_path / "links").mkdir()
    (tmp_path / "links/1.obj").symlink_to(frames / "cloth_v2_9.obj")
    animation = open_animation(tmp_path / "links")
    with pytest.raises(FileFormatError, match="expected another folder"):
        animation.write(frames, [animation.frame(0)])
    assert os.listdir(frames) == ["cloth_v2_9.obj"]


def test_the_file_that_is_read_is_never_written_over(tmp_path):
    animation = single(tmp_path)
    os.link(tmp_path / "a.obj", tmp_path / "b.obj")
    for path in (tmp_path / "a.obj", tmp_path / "b.obj"):
        with pytest.raises(FileFormatError, match="which is read"):
            animation.write(path, [animation.frame(0)])


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["a1.obj", "a2.obj", "a5.obj"], "from 1 to 5; missing: 3, 4$"),
        (["a1.obj", "a2.obj", "a99.obj"], "missing: 3, 4, 5, 6, 7 and 91 more"),
        (["a1.obj", "a999999999999999999.obj", "b3.obj"], "'aN' and 'bN'"),
        (["a1.obj", "a01.obj", "a2.obj"], r"each number once, found 'a01\.obj' and 'a1\.obj'"),
        (["a1.obj", "a2.obj", "a.obj"], "a number of the frame in the name"),
    ],
)
def test_numbers_that_are_missing_are_named(tmp_path, names, message):
    with pytest.raises(FileFormatError, match=message):
        open_animation(folder(tmp_path, PLAIN, PLAIN, PLAIN, names=names))


@pytest.mark.parametrize(
    ("second", "message"),
    [
        (
            PLAIN + b"v 1 2 3\n",
            "mesh 'frames': expected 3 vertices, as in the first frame, found 4",
        ),
        (PLAIN.replace(b"1 2 3\n", b"1 3 2\n"), "mesh 'frames': expected the polygons"),
        (b"o x\n" + PLAIN, "expected a mesh 'frames', as in the first frame, found 'x'"),
        (PLAIN + b"o x\n" + PLAIN, "expected 1 meshes"),
        (PLAIN.replace(b"1 0 0", b"1 nan 0"), r"found \[1.0, nan, 0.0\] at vertex 1"),
        (PLAIN.replace(b"1 0 0", b"1 1e999 0"), r"found \[1.0, inf, 0.0\] at vertex 1"),
        (PLAIN[:10], "expected 'v X Y Z', found 'v '"),
        (b"", "expected vertices"),
    ],
)
def test_a_frame_that_does_not_fit_the_first_is_named(tmp_path, second, message):
    animation = open_animation(folder(tmp_path, PLAIN, second))
    with pytest.raises(FileFormatError, match=message) as caught:
        animation.frame(1)
    assert "cloth_v2_10.obj: frame 1: " in str(caught.value)


def test_other_normals_and_comments_are_no_other_polygons(tmp_path):
    animation = open_animation(folder(tmp_path, PLAIN, b"# 2\n" + PLAIN.replace(b"3\n", b"-1\n")))
    assert animation.frame(1).shape == (3, 3)


def test_bad_lines_are_named(tmp_path):
    assert "line 2: expected 'v X Y Z'" in refused(tmp_path, PLAIN.replace(b"1 0 0", b"1 0"))
    assert "line 2: expected three numbers" in refused(tmp_path, PLAIN.replace(b"1 0 0", b"1 _0 0"))
    assert "line 2: expected three numbers" in refused(tmp_path, PLAIN.replace(b"1 0 0", b"1 x 0"))
    for corner in (b"0", b"4", b"-4", b"99999999999"):
        message = refused(tmp_path, PLAIN.replace(b"1 2 3", b"1 2 " + corner))
        assert "line 4: expected vertices from 1 to 3" in message
    for corner in (b"x", b"1/2/3/4", b"1.5", b"9" * 5000):
        message = refused(tmp_path, PLAIN.replace(b"1 2 3", b"1 2 " + corner))
        assert "line 4: expected 'f' and corners" in message
    assert "without a backslash" in refused(tmp_path, b"# C:\\\n" + PLAIN)
    assert "expected vertices" in refused(tmp_path, b"")


def test_memory_does_not_grow_with_the_number_of_frames(tmp_path):
    text = b"".join(b"v %d 0.5 0.25\n" % i for i in range(500)) + b"f 1 2 3\n"
    animation = open_animation(folder(tmp_path, *[text] * 30))
    peaks = []
    for count in (2, 30):
        tracemalloc.start()
        animation.write(tmp_path / "out", map(animation.frame, range(count)))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]


def test_a_long_line_takes_no_long_time(tmp_path):
    for text in (b"v " + b"1" * 10**6, b"f" + b" " * 10**6 + b"x", b"# " * 10**6 + b"\\\n"):
        (tmp_path / "a.obj").write_bytes(PLAIN + text)
        assert read_all(ObjAnimation, tmp_path / "a.obj") is not None


def test_damaged_files_are_refused_or_read_whole(tmp_path):
    refused, _, _ = check_mutations([TWO, PLAIN], tmp_path / "a.obj", ObjAnimation, n_copies=20)
    assert refused > 0
