"""PLY files, texts or binary, are read frame by frame and written with all else as it was."""

import io
import os
import struct
from itertools import chain

import numpy as np
import pytest
import trimesh

from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import open_animation, triangles
from izo_ref.formats.ply import PlyAnimation
from tests.helpers.mutated import check_mutations

POINTS = [[0.0, 0.0, 0.1], [1.0, -0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.25], [7.0, 7.0, 7.0]]
POLYGONS = [[0, 1, 2, 3], [0, 2, 4], [4, 3, 2]]
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
CODES = {"float": "f", "double": "d", "uchar": "B", "int": "i", "uint": "I", "short": "h"}


def ply(
    order="ascii",
    kind="float",
    lists=("uchar", "int"),
    points=POINTS,
    polygons=POLYGONS,
    end="\n",
    is_first=True,
):
    """Return a PLY file; each vertex has a number before and a colour behind, each face a flag."""
    n_points, n_polygons = len(points), len(polygons)
    vertex = [f"element vertex {n_points}", "property short age"]
    vertex += [f"property {kind} {axis}" for axis in "xyz"] + ["property uchar red"]
    face = [f"element face {n_polygons}", f"property list {lists[0]} {lists[1]} vertex_indices"]
    face += ["property uchar flag"]
    edge = ["element wire 1", "property list uchar int ends", "property int age"]
    elements = vertex + face + edge if is_first else edge + face + vertex
    head = ["ply", f"format {order} 1.0", "comment made by hand", *elements, "end_header", ""]
    vertices = [
        [("short", i - 2), *((kind, number) for number in point), ("uchar", 200 + i)]
        for i, point in enumerate(points)
    ]
    faces = [
        [(lists[0], len(polygon)), *((lists[1], i) for i in polygon), ("uchar", 9)]
        for polygon in polygons
    ]
    edges = [[("uchar", 2), ("int", 0), ("int", 1), ("int", -7)]]
    rows = vertices + faces + edges if is_first else edges + faces + vertices
    return end.join(head).encode() + b"".join(packed(row, ORDERS[order], end) for row in rows)


def packed(row, order, end):
    if order:
        return b"".join(struct.pack(order + CODES[kind], number) for kind, number in row)
    words = [f"{number:.9e}" if kind == "float" else repr(number) for kind, number in row]
    return (" ".join(words) + end).encode()


def single(path, content):
    (path / "a.ply").write_bytes(content)
    return PlyAnimation(path / "a.ply")


def refused(path, content):
    with pytest.raises(FileFormatError) as caught:
        single(path, content)
    message = str(caught.value)
    assert message.startswith(f"{path / 'a.ply'}: frame 0: ")
    return message


def as_read(kind):
    return np.array(POINTS).astype({"float": np.float32, "double": np.float64}[kind])


@pytest.mark.parametrize("is_first", [True, False])
@pytest.mark.parametrize("lists", [("uchar", "int"), ("int", "uint"), ("uint", "short")])
@pytest.mark.parametrize("kind", ["float", "double"])
@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("polygons", [POLYGONS, POLYGONS[1:]])
def test_all_kinds_are_read_and_written_again(tmp_path, order, kind, lists, is_first, polygons):
    content = ply(order, kind, lists, polygons=polygons, is_first=is_first)
    animation = single(tmp_path, content)
    (mesh,) = animation.meshes
    assert (mesh.name, mesh.first, mesh.n_vertices) == ("a", 0, 5)
    assert mesh.counts.tolist() == [len(polygon) for polygon in polygons]
    assert mesh.corners.tolist() == list(chain.from_iterable(polygons))
    assert animation.precision == {"float": "float32", "double": "float64"}[kind]
    np.testing.assert_array_equal(animation.frame(0), as_read(kind), strict=kind == "double")
    same = np.where(animation.frame(0) == 0.0, 0.0, animation.frame(0))  # without the sign
    animation.write(tmp_path / "same.ply", [same])
    assert (tmp_path / "same.ply").read_bytes() == content
    new = as_read(kind).astype(np.float64)
    new[3] = np.array([1 / 3, 1e-30, -5e20]).astype(animation.precision)
    animation.write(tmp_path / "new.ply", [new])
    np.testing.assert_array_equal(PlyAnimation(tmp_path / "new.ply").frame(0), new)
    if order != "ascii":
        points = [*POINTS[:3], new[3].tolist(), POINTS[4]]
        expected = ply(order, kind, lists, points, polygons, is_first=is_first)
        assert (tmp_path / "new.ply").read_bytes() == expected


@pytest.mark.parametrize("kind", ["float", "double"])
@pytest.mark.parametrize("order", ORDERS)
def test_another_reader_finds_the_same(tmp_path, order, kind):
    dice = np.random.default_rng(5)
    content = ply(order, kind, polygons=[[0, 1, 2], [2, 3, 4]])
    animation = single(tmp_path, content)
    new = dice.normal(size=(5, 3)) * 10.0 ** dice.integers(-30, 30, (5, 3))
    new = new.astype(animation.precision).astype(np.float64)
    animation.write(tmp_path / "b.ply", [new])
    found = trimesh.load(tmp_path / "b.ply", process=False)
    np.testing.assert_array_equal(found.vertices, new)
    np.testing.assert_array_equal(found.faces, triangles(animation.meshes))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("order", ORDERS)
def test_all_ends_of_lines_stay(tmp_path, order, end):
    content = ply(order, end=end) + (end * 2).encode() * (order == "ascii")
    animation = single(tmp_path, content)
    animation.write(tmp_path / "b.ply", [animation.frame(0)])
    assert (tmp_path / "b.ply").read_bytes() == content


def test_in_a_text_only_changed_numbers_change(tmp_path):
    text = ply().replace(
        b"property float x\nproperty float y", b"property float y\nproperty float x"
    )
    text = text.replace(b" 7.000000000e+00", b"\t  7.00", 1)
    animation = single(tmp_path, text)
    new = animation.frame(0)
    assert new[1].tolist() == [0, 1, 0]
    new[1] = np.float32([0.1, 1, 1 / 3])
    animation.write(tmp_path / "b.ply", [new])
    old_row = b"-1 1.000000000e+00 -0.000000000e+00 0.000000000e+00 201"
    expected = text.replace(old_row, b"-1 1.000000000e+00 0.1 0.33333334 201")
    assert expected != text
    assert (tmp_path / "b.ply").read_bytes() == expected


def test_a_folder_is_written_file_by_file(tmp_path):
    (tmp_path / "in").mkdir()
    for number in range(3):
        points = [[x + number, y, z] for x, y, z in POINTS]
        content = ply("binary_little_endian", points=points)
        (tmp_path / f"in/f{number:04d}.ply").write_bytes(content)
    animation = open_animation(tmp_path / "in")
    frames = [animation.frame(number) for number in range(3)]
    assert [frame[0, 0] for frame in frames] == [0, 1, 2]
    animation.write(tmp_path / "out", frames[:2])
    assert sorted(os.listdir(tmp_path / "out")) == ["f0000.ply", "f0001.ply"]
    for name in os.listdir(tmp_path / "out"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "in" / name).read_bytes()


@pytest.mark.parametrize(
    ("second", "message"),
    [
        (ply(points=[*POINTS, [1, 2, 3]]), "expected 5 vertices, as in the first frame, found 6"),
        (ply(polygons=[*POLYGONS[:2], [4, 2, 3]]), "expected the polygons of the first frame"),
        (ply(kind="double"), "expected float32, as in the first frame, found float64"),
        (ply(points=[*POINTS[:4], [1e39, 0, 0]]), r"found \[inf, 0.0, 0.0\] at vertex 4"),
        (ply(points=[*POINTS[:4], [0, float("nan"), 0]]), "expected finite coordinates"),
        (b"", "expected 'ply' in the first line, found ''"),
    ],
)
def test_a_frame_that_does_not_fit_the_first_is_named(tmp_path, second, message):
    (tmp_path / "1.ply").write_bytes(ply())
    (tmp_path / "2.ply").write_bytes(second)
    animation = open_animation(tmp_path)
    with pytest.raises(FileFormatError, match=message) as caught:
        animation.frame(1)
    assert "2.ply: frame 1: " in str(caught.value)


def test_the_kind_of_file_may_differ_from_frame_to_frame(tmp_path):
    for number, order in enumerate(ORDERS):
        (tmp_path / f"{number}.ply").write_bytes(ply(order))
    animation = open_animation(tmp_path)
    for number in range(3):
        np.testing.assert_array_equal(animation.frame(number), np.float32(POINTS))


@pytest.mark.parametrize("order", ORDERS)
def test_bad_files_are_refused(tmp_path, order):
    good = ply(order)
    for cut in range(0, len(good) - 1, 7):
        refused(tmp_path, good[:cut])
    assert "expected" in refused(tmp_path, good + b"1")
    for old, new, message in (
        (b"vertex 5", b"vertex 99999999999999", "declares"),
        (b"face 3", b"face 999999999999999999", "declares"),
        (b"vertex 5", b"vertex 0", "expected vertices"),
        (b"element vertex", b"element points", "expected vertices"),
        (b"float y", b"int y", "expected x, y and z, all float or all double"),
        (b"float y", b"float x", "line 7 of the header"),
        (b"short age", b"list uchar int age", "expected numbers, found a list"),
        (b"list uchar int vertex_indices", b"list uchar float vertex_indices", "expected one list"),
        (b"list uchar int vertex_indices", b"list float int vertex_indices", "of the header"),
        (b"vertex_indices", b"corners", "expected one list"),
        (b"element face", b"element tristrips", "triangle strips"),
        (b" 1.0\n", b" 2.0\n", "line 2 of the header: expected 'format'"),
        (b"end_header", b"end", "line 16 of the header"),
    ):
        assert good != good.replace(old, new)
        assert message in refused(tmp_path, good.replace(old, new)), old
    assert "expected vertices from 0 to 4, found 5 in face 1" in refused(
        tmp_path, ply(order, polygons=[[0, 1, 2], [0, 1, 5]])
    )


def test_negative_lengths_and_vertices_are_refused(tmp_path):
    for order in list(ORDERS)[1:]:
        content = ply(order, lists=("int", "int"), polygons=[[0, 1, 2], [0, 1, -1]])
        assert "found -1 in face 1" in refused(tmp_path, content)
        code = ORDERS[order] + "i"
        content = content.replace(struct.pack(code, 3), struct.pack(code, -3), 1)
        assert "declares -3 numbers of a list" in refused(tmp_path, content)
    content = ply(lists=("int", "int"), polygons=[[0, 1, 2], [0, 1, -1]])
    assert "row 1: expected lists" in refused(tmp_path, content)


def test_points_without_faces_are_a_mesh_without_polygons(tmp_path):
    for order in ORDERS:
        (mesh,) = single(tmp_path, ply(order, polygons=[])).meshes
        assert len(mesh.counts) == len(mesh.corners) == 0


def test_damaged_files_are_refused_or_read_whole(tmp_path):
    contents = [ply(order, is_first=first) for order in ORDERS for first in (True, False)]
    contents.append(ply("binary_little_endian", polygons=POLYGONS[1:]))
    written = io.BytesIO(trimesh.creation.icosphere(1).export(file_type="ply"))
    contents.append(written.getvalue())
    refused, _, _ = check_mutations(contents, tmp_path / "a.ply", PlyAnimation, n_copies=20)
    assert refused > 0
