import base64
import copy
import json
import os
import struct
from contextlib import suppress
from urllib.parse import unquote

import numpy as np
import pytest

from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import open_animation
from tests.helpers.damaged_files import damaged

trimesh = pytest.importorskip("trimesh", reason="the second reader is trimesh")

KINDS = ("glb", "gltf", "embedded.gltf")
SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], "f4")
TRIANGLES = np.array([0, 1, 2, 0, 2, 3], "u2")
TIMES = np.array([0.5, 1, 1.5], "f4")


def offsets(seed):
    return np.random.default_rng(seed).normal(size=(4, 3)).astype("f4")


class Builder:
    """A document and the bytes of its buffer."""

    def __init__(self):
        self.content = b""
        self.document = {
            "asset": {"version": "2.0", "generator": "the tests"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
            "animations": [{"channels": [], "samplers": []}],
            "extras": {"kept": [1, 2.5, "wörd"]},
        }

    def add(self, array, kind, bounds=False):
        """Add an accessor; return its number."""
        array = np.ascontiguousarray(array)
        code = {"float32": 5126, "uint16": 5123}[array.dtype.name]
        size = array.nbytes
        views, accessors = self.document["bufferViews"], self.document["accessors"]
        views.append({"buffer": 0, "byteOffset": len(self.content), "byteLength": size})
        entry = {"bufferView": len(views) - 1, "componentType": code, "type": kind}
        entry["count"] = len(array)
        if bounds:
            entry["min"] = np.atleast_1d(array.min(axis=0)).tolist()
            entry["max"] = np.atleast_1d(array.max(axis=0)).tolist()
        accessors.append(entry)
        self.content += array.tobytes() + b"\0" * (-size % 4)
        return len(accessors) - 1

    def mesh(self, name, base, targets=(), **node):
        """Add a node with a mesh; return its number."""
        base = self.add(base, "VEC3", bounds=True)
        primitive = {
            "attributes": {"POSITION": base, "NORMAL": self.add(SQUARE, "VEC3")},
            "indices": self.add(TRIANGLES, "SCALAR"),
        }
        mesh = {"name": f"mesh of {name}", "primitives": [primitive]}
        if len(targets):
            numbers = [self.add(target, "VEC3", bounds=True) for target in targets]
            primitive["targets"] = [{"POSITION": number} for number in numbers]
            mesh["weights"] = [0.0] * len(targets)
        self.document["meshes"].append(mesh)
        nodes = self.document["nodes"]
        nodes.append({"name": name, "mesh": len(self.document["meshes"]) - 1, **node})
        self.document["scenes"][0]["nodes"].append(len(nodes) - 1)
        return len(nodes) - 1

    def animate(self, node, weights, interpolation="LINEAR", times=TIMES):
        """Animate the weights of a node."""
        animation = self.document["animations"][0]
        sampler = {
            "input": self.add(np.array(times, "f4"), "SCALAR", bounds=True),
            "output": self.add(np.array(weights, "f4").reshape(-1), "SCALAR"),
            "interpolation": interpolation,
        }
        animation["samplers"].append(sampler)
        target = {"node": node, "path": "weights"}
        number = len(animation["samplers"]) - 1
        animation["channels"].append({"sampler": number, "target": target})

    def save(self, path):
        """Write a .glb file, a .gltf file with a .bin file, or one with all in it."""
        document = copy.deepcopy(self.document)
        if not document["animations"][0]["channels"]:
            del document["animations"]
        document["buffers"] = [{"byteLength": len(self.content)}]
        if path.name.endswith("embedded.gltf"):
            data = base64.b64encode(self.content).decode()
            document["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{data}"
        elif path.suffix == ".gltf":
            document["buffers"][0]["uri"] = "its%20bytes.bin"
            (path.parent / "its bytes.bin").write_bytes(self.content)
        text = json.dumps(document).encode()
        if path.suffix == ".glb":
            text += b" " * (-len(text) % 4)
            chunks = struct.pack("<I4s", len(text), b"JSON") + text
            chunks += struct.pack("<I4s", len(self.content), b"BIN\0") + self.content
            text = struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
        path.write_bytes(text)
        return path


def a_cloth():
    built = Builder()
    node = built.mesh("cloth", SQUARE, [offsets(k) for k in range(3)])
    built.animate(node, np.eye(3))
    built.mesh("floor", SQUARE - np.float32(5))
    return built


@pytest.fixture(params=KINDS)
def cloth(request, tmp_path):
    return a_cloth().save(tmp_path / f"cloth.{request.param}")


def second_reader(path):
    """Return the document of a file and a function that returns the numbers of an accessor."""
    content = path.read_bytes()
    if path.suffix == ".glb":
        (size,) = struct.unpack_from("<I", content, 12)
        document = json.loads(content[20 : 20 + size])
        buffer = content[28 + size :]
    else:
        document = json.loads(content)
        uri = document["buffers"][0]["uri"]
        is_data = uri.startswith("data:")
        buffer = (
            base64.b64decode(uri.split(",")[1])
            if is_data
            else (path.parent / unquote(uri)).read_bytes()
        )

    def numbers(index):
        entry = document["accessors"][index]
        begin = document["bufferViews"][entry["bufferView"]]["byteOffset"]
        width = {"SCALAR": 1, "VEC3": 3}[entry["type"]]
        return np.frombuffer(buffer, "<f4", entry["count"] * width, begin).reshape(-1, width)

    return document, numbers


def moved(path, mesh=0):
    """Return the frames of a mesh by plain reading: base and one target each."""
    document, numbers = second_reader(path)
    primitive = document["meshes"][mesh]["primitives"][0]
    base = numbers(primitive["attributes"]["POSITION"])
    return [base + numbers(target["POSITION"]) for target in primitive["targets"]]


def copy_of(cloth):
    return cloth.parent / f"copy.{cloth.name.partition('.')[2]}"


def test_meshes_and_frames_are_those_of_the_file(cloth):
    animation = open_animation(cloth)
    assert [mesh.name for mesh in animation.meshes] == ["cloth", "floor"]
    assert [(mesh.first, mesh.n_vertices) for mesh in animation.meshes] == [(0, 4), (4, 4)]
    assert animation.meshes[1].counts.tolist() == [3, 3]
    assert animation.meshes[1].corners.tolist() == TRIANGLES.tolist()
    assert animation.times.tolist() == TIMES.tolist()
    for number in range(3):
        expected = np.concatenate([SQUARE + offsets(number), SQUARE - 5])
        assert (animation.frame(number) == expected).all()
    assert animation.frame(0).dtype == np.float64


def test_what_was_not_changed_is_written_as_it_was(cloth):
    animation = open_animation(cloth)
    target = copy_of(cloth)
    animation.write(target, (animation.frame(number) for number in range(3)))
    if cloth.name.endswith("cloth.gltf"):
        old, new = (json.loads(path.read_text()) for path in (cloth, target))
        own = cloth.parent / new["buffers"][0]["uri"]
        assert own.read_bytes() == (cloth.parent / "its bytes.bin").read_bytes()
        old["buffers"][0]["uri"] = own.name
        assert old == new
    else:
        assert target.read_bytes() == cloth.read_bytes()


def test_another_reader_finds_the_new_positions(cloth):
    animation = open_animation(cloth)
    new = [animation.frame(number) for number in range(3)]
    new[1][2] += 0.25
    new = [animation.as_written(number, frame) for number, frame in enumerate(new)]
    target = copy_of(cloth)
    animation.write(target, new)
    for found, frame in zip(moved(target), new, strict=True):
        assert (found == frame[:4]).all()
    assert np.abs(new[1][2] - (SQUARE + offsets(1))[2] - 0.25).max() < 1e-6
    old, document = (second_reader(path)[0] for path in (cloth, target))
    changed = document["meshes"][0]["primitives"][0]["targets"][1]["POSITION"]
    entry, values = document["accessors"][changed], second_reader(target)[1](changed)
    assert entry["max"] == values.max(axis=0).tolist()
    assert entry["min"] == values.min(axis=0).tolist()
    assert (values[[0, 1, 3]] == offsets(1)[[0, 1, 3]]).all()
    old["accessors"][changed] = entry
    old["buffers"] = document["buffers"]
    assert document == old
    again = open_animation(target)
    assert [(again.frame(number) == new[number]).all() for number in range(3)] == [True] * 3


def test_what_is_written_is_what_was_announced(cloth):
    animation = open_animation(cloth)
    rng = np.random.default_rng(5)
    new = [animation.frame(number) for number in range(3)]
    for frame in new:
        frame[:4] = (rng.normal(size=(4, 3)) * 10.0 ** rng.integers(-9, 9, (4, 3))).astype("f4")
    announced = [animation.as_written(number, frame) for number, frame in enumerate(new)]
    target = copy_of(cloth)
    animation.write(target, new)
    found = open_animation(target)
    for number in range(3):
        assert (found.frame(number) == announced[number]).all()
        assert (animation.as_written(number, announced[number]) == announced[number]).all()
    assert not animation.is_exact


def test_fewer_frames_end_the_animation_sooner(cloth):
    animation = open_animation(cloth)
    target = copy_of(cloth)
    animation.write(target, [animation.frame(0), animation.frame(1)])
    found = open_animation(target)
    assert found.times.tolist() == TIMES[:2].tolist()
    assert (found.frame(1) == animation.frame(1)).all()
    document, numbers = second_reader(target)
    sampler = document["animations"][0]["samplers"][0]
    assert document["accessors"][sampler["input"]]["max"] == [1]
    assert numbers(sampler["output"]).ravel().tolist() == [1, 0, 0, 0, 1, 0]


def test_trimesh_reads_the_mesh_that_was_written(tmp_path):
    built = Builder()
    built.mesh("square", SQUARE)
    path, target = built.save(tmp_path / "still.glb"), tmp_path / "copy.glb"
    animation = open_animation(path)
    assert animation.n_frames == 1
    assert animation.is_exact
    new = animation.frame(0) + 0.125
    animation.write(target, [new])
    found = trimesh.load(target, process=False).to_mesh()
    assert (found.vertices == new).all()
    assert found.faces.tolist() == TRIANGLES.reshape(-1, 3).tolist()
    assert second_reader(target)[0]["accessors"][0]["max"] == [1.125, 1.125, 0.125]


def test_transforms_are_applied_and_undone(tmp_path):
    built = Builder()
    half = float(np.sqrt(0.5))
    node = built.mesh(
        "cloth",
        SQUARE,
        [offsets(k) for k in range(3)],
        translation=[1, 2, 3],
        rotation=[0, 0, half, half],
        scale=[2, 2, 2],
    )
    built.animate(node, np.eye(3))
    matrix = np.diag([1.0, 1, 1, 1])
    matrix[:3, 3] = 10
    built.document["nodes"].append({"children": [node], "matrix": matrix.T.ravel().tolist()})
    built.document["scenes"][0]["nodes"] = [1]
    path, target = built.save(tmp_path / "moved.glb"), tmp_path / "copy.glb"
    animation = open_animation(path)
    own = SQUARE + offsets(1)
    turned = np.column_stack((-own[:, 1], own[:, 0], own[:, 2]))  # a quarter turn about z
    assert np.allclose(animation.frame(1), 2.0 * turned + [11, 12, 13], rtol=0, atol=1e-6)
    loaded = trimesh.load(path, process=False).to_mesh()
    base = np.column_stack((-SQUARE[:, 1], SQUARE[:, 0], SQUARE[:, 2]))
    assert np.allclose(loaded.vertices, 2 * base + [11, 12, 13], atol=1e-6)
    new = [animation.frame(number) for number in range(3)]
    new[1][2] += 0.5
    announced = [animation.as_written(number, frame) for number, frame in enumerate(new)]
    animation.write(target, new)
    for number in range(3):
        assert (open_animation(target).frame(number) == announced[number]).all()
    assert np.abs(announced[1] - new[1]).max() < 1e-5


def test_weights_are_read_at_their_key_times(tmp_path):
    built = Builder()
    node = built.mesh("cloth", SQUARE, [offsets(0), offsets(1)])
    zeros, rows = np.zeros((1, 2)), np.array([[0, 0], [1, 0], [0.25, 0.5]])
    cubic = np.concatenate([np.concatenate([zeros, row[None], zeros]) for row in rows])
    built.animate(node, cubic, "CUBICSPLINE")
    path = built.save(tmp_path / "cubic.glb")
    animation = open_animation(path)
    mixed = (SQUARE + 0.25 * offsets(0).astype("f8") + 0.5 * offsets(1).astype("f8")).astype("f4")
    for number, expected in enumerate((SQUARE, SQUARE + offsets(0), mixed)):
        assert (animation.frame(number) == expected).all()
    frames = [animation.frame(number) for number in range(3)]
    animation.write(tmp_path / "copy.glb", frames)
    assert (tmp_path / "copy.glb").read_bytes() == path.read_bytes()
    for number in (0, 2):  # the base alone, and a mixture
        with pytest.raises(FileFormatError, match=f"frame {number}: mesh cloth: cannot be changed"):
            animation.as_written(number, frames[number] + 1)
    with pytest.raises(FileFormatError, match="frame 2: mesh cloth: needs numbers that another"):
        animation.write(tmp_path / "other.glb", [frames[0], frames[1] + 1, frames[2]])


def test_a_target_of_two_frames_has_one_set_of_positions(tmp_path):
    built = Builder()
    node = built.mesh("cloth", SQUARE, [offsets(0), offsets(1)])
    built.animate(node, [[1, 0], [0, 1], [0, 1]])
    path = built.save(tmp_path / "held.glb")
    animation = open_animation(path)
    frames = [animation.frame(number) for number in range(3)]
    animation.write(tmp_path / "copy.glb", [frames[0], frames[1] + 1, frames[2] + 1])
    with pytest.raises(FileFormatError, match=r"frame 2: mesh cloth: needs numbers"):
        animation.write(tmp_path / "copy.glb", [frames[0], frames[1] + 1, frames[2]])
    with pytest.raises(FileFormatError, match="frame 2: mesh cloth: has the same target"):
        animation.write(tmp_path / "copy.glb", [frames[0], frames[1], frames[2] + 1])


def test_bytes_of_two_accessors_are_not_changed(tmp_path):
    built = a_cloth()
    primitive = built.document["meshes"][0]["primitives"][0]
    primitive["attributes"]["NORMAL"] = primitive["targets"][1]["POSITION"]
    twin = copy.deepcopy(built.document["accessors"][primitive["targets"][1]["POSITION"]])
    built.document["accessors"].append(twin)
    animation = open_animation(built.save(tmp_path / "shared.glb"))
    frames = [animation.frame(number) for number in range(3)]
    animation.write(tmp_path / "copy.glb", frames)
    frames[1][0] += 1
    with pytest.raises(FileFormatError, match="belong to another one too"):
        animation.write(tmp_path / "copy.glb", frames)


def test_interleaved_numbers_are_read_and_written(tmp_path):
    built = Builder()
    node = built.mesh("cloth", SQUARE, [offsets(0)])
    built.animate(node, [[1]], times=[0])
    both = np.column_stack((offsets(1), offsets(2)))
    number = built.add(both, "VEC3")
    view = built.document["bufferViews"][-1]
    view["byteStride"] = 24
    normals = {**built.document["accessors"][number], "byteOffset": 12}
    built.document["accessors"].append(normals)
    target = built.document["meshes"][0]["primitives"][0]["targets"][0]
    target.update(POSITION=number, NORMAL=number + 1)
    path, written = built.save(tmp_path / "both.glb"), tmp_path / "copy.glb"
    animation = open_animation(path)
    assert (animation.frame(0) == SQUARE + offsets(1)).all()
    new = animation.as_written(0, animation.frame(0) + 1)
    animation.write(written, [new])
    assert (open_animation(written).frame(0) == new).all()
    begin = len(written.read_bytes()) - both.nbytes
    found = np.frombuffer(written.read_bytes()[begin:], "f4").reshape(4, 6)
    assert (found[:, 3:] == offsets(2)).all()


@pytest.mark.parametrize(
    ("mode", "corners", "expected"),
    [
        (5, [0, 1, 2, 3], [[0, 1, 2], [1, 3, 2]]),
        (5, [0, 1, 2, 2, 3], [[0, 1, 2]]),
        (6, [0, 1, 2, 3], [[0, 1, 2], [0, 2, 3]]),
    ],
)
def test_strips_and_fans_are_cut_into_triangles(tmp_path, mode, corners, expected):
    built = Builder()
    built.mesh("square", SQUARE)
    primitive = built.document["meshes"][0]["primitives"][0]
    primitive["mode"] = mode
    primitive["indices"] = built.add(np.array(corners, "u2"), "SCALAR")
    animation = open_animation(built.save(tmp_path / "strip.glb"))
    assert animation.meshes[0].corners.reshape(-1, 3).tolist() == expected


def test_a_file_is_not_written_over_itself(cloth):
    animation = open_animation(cloth)
    link = cloth.parent / f"link.{cloth.name.partition('.')[2]}"
    link.symlink_to(cloth)
    before = cloth.read_bytes()
    for target in (cloth, link):
        with pytest.raises(FileFormatError, match="which is read"):
            animation.write(target, [animation.frame(0)])
    assert cloth.read_bytes() == before


@pytest.mark.parametrize(
    "what", ["no frame", "too many", "shape", "nan", "too large", "floor", "error"]
)
def test_nothing_is_left_behind_where_frames_do_not_fit(cloth, what):
    animation = open_animation(cloth)
    frame = animation.frame(0)
    before = sorted(os.listdir(cloth.parent))

    def failing():
        yield frame
        raise ValueError("of the caller")

    frames = {
        "no frame": [],
        "too many": [frame] * 4,
        "shape": [frame[1:]],
        "nan": [frame * np.nan],
        "too large": [frame + 1e39],
        "floor": [frame + np.arange(8)[:, None] // 4],
        "error": failing(),
    }[what]
    with pytest.raises(ValueError if what == "error" else FileFormatError):
        animation.write(copy_of(cloth), frames)
    assert sorted(os.listdir(cloth.parent)) == before


def broken(what):
    built = a_cloth()
    document = built.document
    primitive = document["meshes"][0]["primitives"][0]
    if what == "nan":
        place = document["bufferViews"][primitive["targets"][1]["POSITION"]]["byteOffset"]
        nan = np.float32(np.nan).tobytes()
        built.content = built.content[:place] + nan + built.content[place + 4 :]
    elif what == "sparse":
        document["accessors"][0]["sparse"] = {}
    elif what == "skin":
        document["nodes"][0]["skin"] = 0
    elif what == "draco":
        primitive["extensions"] = {"KHR_draco_mesh_compression": {}}
    elif what == "twice":
        document["nodes"].append({"mesh": 0})
        document["scenes"][0]["nodes"].append(2)
    elif what == "moved":
        channel = {"sampler": 0, "target": {"node": 0, "path": "rotation"}}
        document["animations"][0]["channels"].append(channel)
    elif what == "count":
        document["accessors"][0]["count"] = 10**15
    elif what == "target":
        document["accessors"][primitive["targets"][0]["POSITION"]]["count"] = 3
    elif what == "index":
        primitive["indices"] = built.add(np.array([0, 1, 4], "u2"), "SCALAR")
    elif what == "weights":
        document["accessors"][document["animations"][0]["samplers"][0]["output"]]["count"] = 8
    elif what == "negative":
        primitive["attributes"]["POSITION"] = -1
    elif what == "circle":
        document["nodes"][0]["children"] = [0]
    elif what == "flat":
        document["nodes"][0]["scale"] = [1, 0, 1]
    elif what == "far":
        document["nodes"][0]["scale"] = [1e300, 1e300, 1e300]
        document["nodes"].append({"children": [0], "scale": [1e300, 1e300, 1e300]})
        document["scenes"][0]["nodes"] = [2, 1]
    elif what == "times":
        document["animations"][0]["samplers"][0]["input"] = built.add(TIMES[::-1], "SCALAR")
    return built


@pytest.mark.parametrize(
    ("what", "match"),
    [
        ("nan", "frame 1: mesh cloth: expected finite positions"),
        ("sparse", "accessor 0: is sparse"),
        ("skin", "mesh cloth: is skinned"),
        ("draco", "mesh cloth: is compressed"),
        ("twice", "mesh node 2: shares its vertices"),
        ("moved", "mesh cloth: its transform is animated"),
        ("count", "accessor 0: expected 12000000000000000 bytes, found 48"),
        ("target", "mesh cloth: target 0: expected 4 vertices, found 3"),
        ("index", "expected vertices from 0 to 3 in the triangles, found 4"),
        ("weights", "mesh cloth: expected 9 weights, found 8"),
        ("negative", "expected a whole number as POSITION, found -1"),
        ("circle", "node 0: is below two nodes"),
        ("flat", "mesh cloth: expected a transform that can be undone"),
        ("far", "mesh cloth: expected a transform that is affine and finite"),
        ("times", "expected key times that increase"),
    ],
)
def test_refusals_say_what_was_found(tmp_path, what, match):
    path = broken(what).save(tmp_path / "broken.glb")
    with pytest.raises(FileFormatError, match=match) as caught:
        read_all(path)
    assert str(path) in str(caught.value)


def read_all(path):
    animation = open_animation(path)
    for number in range(animation.n_frames):
        animation.frame(number)


def test_bad_files_are_refused(tmp_path):
    contents = {
        "empty.glb": b"",
        "text.glb": b"solid",
        "long.glb": struct.pack("<4sII", b"glTF", 2, 2**31),
        "chunk.glb": struct.pack("<4sIII4s", b"glTF", 2, 20, 2**31, b"JSON"),
        "empty.gltf": b"",
        "list.gltf": b"[]",
        "nan.gltf": b'{"asset": {"version": "2.0"}, "x": NaN}',
        "deep.gltf": b"[" * 100_000,
        "old.gltf": b'{"asset": {"version": "1.0"}}',
        "none.gltf": b'{"asset": {"version": "2.0"}}',
        "far.gltf": b'{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 1, "uri": "/a"}]}',
    }
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(FileFormatError, match=name):
            open_animation(tmp_path / name)
    with pytest.raises(FileFormatError, match="No such file"):
        open_animation(tmp_path / "nothing.glb")


def test_damaged_files_open_or_are_refused(cloth, capfd):
    whole = cloth.read_bytes()
    for seed in range(300):
        print("seed", seed)
        path = cloth.parent / f"damaged{cloth.suffix}"
        path.write_bytes(damaged(whole, np.random.default_rng(seed)))
        with suppress(FileFormatError):
            read_all(path)
    assert capfd.readouterr().err == ""
