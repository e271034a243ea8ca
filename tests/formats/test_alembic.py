import os
from contextlib import suppress

import numpy as np
import pytest

from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import open_animation, triangles
from tests.helpers.damaged_files import damaged

alembic3d = pytest.importorskip("alembic3d", reason="Alembic needs the package alembic3d")

imath = pytest.importorskip("imath", reason="Alembic needs the package alembic3d")
Abc, AbcGeom = alembic3d.Abc, alembic3d.AbcGeom
TimeSampling = alembic3d.AbcCoreAbstract.TimeSampling
TimeSamplingType = alembic3d.AbcCoreAbstract.TimeSamplingType

COUNTS, CORNERS = [4, 3], [0, 1, 2, 3, 0, 2, 1]
RATE = 1 / 24


def points(seed, n=4):
    return np.random.default_rng(seed).random((n, 3)).astype(np.float32)


def whole_numbers(values):
    return imath.IntArrayFromBuffer(np.array(values, "i4"))


def add_mesh(archive, parent, name, samples, *, corners=None, kind=AbcGeom.OPolyMesh, rate=RATE):
    """Add a mesh of a quad and a triangle, with one sample for each array of points."""
    mesh = kind(parent, name)
    schema = mesh.getSchema()
    if len(samples) > 1:
        schema.setTimeSampling(archive.addTimeSampling(TimeSampling(rate, rate)))
    sample = AbcGeom.OSubDSchemaSample if kind is AbcGeom.OSubD else AbcGeom.OPolyMeshSchemaSample
    for number, value in enumerate(samples):
        own = CORNERS if corners is None else corners[number]
        positions = imath.V3fArrayFromBuffer(np.ascontiguousarray(value, "f4"))
        schema.set(sample(positions, whole_numbers(own), whole_numbers(COUNTS)))
    return mesh


def add_transform(archive, parent, name, shifts):
    """Add a turn and a shift, with one sample for each shift."""
    transform = AbcGeom.OXform(parent, name)
    if len(shifts) > 1:
        index = archive.addTimeSampling(TimeSampling(RATE, RATE))
        transform.getSchema().setTimeSampling(index)
    for shift in shifts:
        sample = AbcGeom.XformSample()
        sample.setTranslation(imath.V3d(*shift))
        if any(shift):
            sample.setRotation(imath.V3d(0, 0, 1), 30.0)
            sample.setScale(imath.V3d(2, 2, 2))
        transform.getSchema().set(sample)
    return transform


@pytest.fixture
def cloth(tmp_path):
    """A file with a moving mesh, a subdivision cage that moves, and a mesh that stands still."""
    path = tmp_path / "cloth.abc"
    write_cloth(path)
    return path


def write_cloth(path):
    archive = Abc.CreateArchiveWithInfo(str(path), "the tests", "a cloth")
    mesh = add_mesh(archive, archive.getTop(), "a", [points(k) for k in range(3)])
    group = add_transform(archive, archive.getTop(), "group", [(0, 0, 0)])
    add_mesh(archive, group, "b", [points(k) for k in range(3, 6)], kind=AbcGeom.OSubD)
    add_mesh(archive, group, "floor", [points(9)])
    half = mesh.getSchema().createFaceSet("half").getSchema()
    half.set(AbcGeom.OFaceSetSchemaSample(whole_numbers([1])))
    texts = Abc.OStringArrayProperty(mesh.getSchema().getUserProperties(), "texts")
    texts.setValue(imath.StringArray("wörds", 2))
    colour = Abc.OV3fProperty(mesh.getSchema().getUserProperties(), "colour")
    colour.setValue(imath.V3f(1, 0.5, 0.25))


def second_reader(path, *names):
    """Return the samples of a mesh and its bounds, by plain calls."""
    found = Abc.IArchive(str(path)).getTop()
    for name in names:
        children = [found.getChild(k) for k in range(found.getNumChildren())]
        found = next(child for child in children if child.getName() == name)
    geometry = found.getProperties().getProperty(".geom")
    samples = geometry.getProperty("P").samples
    bounds = geometry.getProperty(".selfBnds").samples
    return [np.array(sample) for sample in samples], list(bounds)


def described(path):
    """Return all that an archive holds, as text, without its date and version."""
    lines = []

    def describe(thing, name):
        lines.append((name, thing.getMetaData().serialize() if name != "/" else ""))
        for k in range(thing.getNumProperties()):
            own = thing.getProperty(k)
            if own.isCompound():
                describe(own, f"{name}.{own.getName()}")
                continue
            values = list(own.samples)
            if own.isArray():
                values = [list(value) for value in values]
            times = [own.getTimeSampling().getSampleTime(n) for n in range(own.getNumSamples())]
            kind = str(own.getDataType())
            lines.append((name, own.getName(), own.getMetaData().serialize(), kind, values, times))

    def walk(thing):
        lines.append((thing.getFullName(),))
        describe(thing.getProperties(), thing.getFullName())
        for k in range(thing.getNumChildren()):
            walk(thing.getChild(k))

    walk(Abc.IArchive(str(path)).getTop())
    return [repr(line) for line in lines]


def test_meshes_and_frames_are_those_of_the_file(cloth):
    animation = open_animation(cloth)
    assert [mesh.name for mesh in animation.meshes] == ["/a", "/group/b", "/group/floor"]
    assert [mesh.first for mesh in animation.meshes] == [0, 4, 8]
    assert animation.meshes[1].counts.tolist() == COUNTS
    assert animation.meshes[1].corners.tolist() == CORNERS
    assert np.allclose(animation.times, [RATE, 2 * RATE, 3 * RATE])
    assert animation.is_exact
    assert len(triangles(animation.meshes)) == 9
    for number in range(3):
        expected = np.concatenate([points(number), points(number + 3), points(9)])
        assert (animation.frame(number) == expected).all()
    assert animation.frame(0).dtype == np.float64


def test_what_was_not_changed_is_written_as_it_was(cloth, tmp_path):
    animation = open_animation(cloth)
    copy = tmp_path / "copy.abc"
    animation.write(copy, (animation.frame(number) for number in range(3)))
    assert described(copy) == described(cloth)
    words = Abc.IArchive(str(copy)).getTop().getMetaData()
    assert (words.get("_ai_Application"), words.get("_ai_Description")) == ("the tests", "a cloth")
    assert sorted(os.listdir(tmp_path)) == ["cloth.abc", "copy.abc"]


def test_another_reader_finds_the_new_positions(cloth, tmp_path):
    animation = open_animation(cloth)
    new = [animation.frame(number) for number in range(3)]
    new[1][[2, 9]] += 0.25
    new = [frame.astype("f4").astype("f8") for frame in new]
    copy = tmp_path / "copy.abc"
    animation.write(copy, new)
    own, bounds = second_reader(copy, "a")
    assert [(sample == frame[:4]).all() for sample, frame in zip(own, new, strict=True)] == [1] * 3
    assert np.array_equal(list(bounds[1].max()), new[1][:4].max(axis=0))
    assert (second_reader(copy, "group", "b")[0][2] == new[2][4:8]).all()
    floor, _ = second_reader(copy, "group", "floor")  # it had one sample, and moves now
    assert [(sample == frame[8:]).all() for sample, frame in zip(floor, new, strict=True)] == [
        1
    ] * 3
    again = open_animation(copy)
    assert [(again.frame(number) == new[number]).all() for number in range(3)] == [1] * 3
    assert np.array_equal(again.times, animation.times)
    changed = ("'P'", "'.selfBnds'")
    kept = [
        [line for line in described(path) if not any(word in line for word in changed)]
        for path in (cloth, copy)
    ]
    assert kept[0] == kept[1]


def test_fewer_frames_end_the_animation_sooner(cloth, tmp_path):
    animation = open_animation(cloth)
    copy = tmp_path / "copy.abc"
    animation.write(copy, [animation.frame(0), animation.frame(1)])
    found = open_animation(copy)
    assert found.n_frames == 2
    assert (found.frame(1) == animation.frame(1)).all()


def moved_archive(path):
    archive = Abc.OArchive(str(path))
    above = add_transform(archive, archive.getTop(), "above", [(1, 2, 3), (2, 3, 4), (4, 5, 6)])
    below = add_transform(archive, above, "below", [(7, 8, 9)])
    add_mesh(archive, below, "m", [points(k) for k in range(3)])


def test_transforms_are_applied_and_undone(tmp_path):
    path, copy = tmp_path / "moved.abc", tmp_path / "copy.abc"
    moved_archive(path)
    animation = open_animation(path)
    assert not animation.is_exact
    turn = np.radians(30)
    matrix = 2 * np.array(
        [[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    inner = points(1) @ matrix + [7, 8, 9]
    assert np.allclose(animation.frame(1), inner @ matrix + [2, 3, 4], rtol=0, atol=1e-13)
    new = [animation.frame(number) for number in range(3)]
    new[1][2] += 0.5
    written = [animation.as_written(number, frame) for number, frame in enumerate(new)]
    for number in range(3):
        assert np.array_equal(animation.as_written(number, written[number]), written[number])
    animation.write(copy, new)
    found = open_animation(copy)
    for number in range(3):
        assert np.array_equal(found.frame(number), written[number])
        assert np.abs(written[number] - new[number]).max() < 1e-5
    kept = second_reader(copy, "above", "below", "m")[0][1]
    assert (kept[[0, 1, 3]] == points(1)[[0, 1, 3]]).all()


def test_times_need_no_rate(tmp_path):
    path, copy = tmp_path / "times.abc", tmp_path / "copy.abc"
    write_without_rate(path)
    animation = open_animation(path)
    assert animation.times.tolist() == [0, 0.5, 2]
    new = [(animation.frame(number) + 1).astype("f4").astype("f8") for number in range(3)]
    animation.write(copy, new)
    assert open_animation(copy).times.tolist() == [0, 0.5, 2]
    assert (open_animation(copy).frame(2) == new[2]).all()


def write_without_rate(path):
    archive = Abc.OArchive(str(path))
    times = alembic3d.AbcCoreAbstract.TimeVector()
    for time in (0.0, 0.5, 2.0):
        times.append(time)
    kind = TimeSamplingType(alembic3d.AbcCoreAbstract.AcyclicFlag.kAcyclic)
    mesh = AbcGeom.OPolyMesh(archive.getTop(), "m").getSchema()
    mesh.setTimeSampling(archive.addTimeSampling(TimeSampling(kind, times)))
    for number in range(3):
        positions = imath.V3fArrayFromBuffer(points(number))
        faces = whole_numbers(CORNERS), whole_numbers(COUNTS)
        mesh.set(AbcGeom.OPolyMeshSchemaSample(positions, *faces))


def test_a_file_is_not_written_over_itself(cloth, tmp_path):
    animation = open_animation(cloth)
    link = tmp_path / "link.abc"
    link.symlink_to(cloth)
    before = cloth.read_bytes()
    for target in (cloth, link):
        with pytest.raises(FileFormatError, match="which is read"):
            animation.write(target, [animation.frame(0)])
    assert cloth.read_bytes() == before


@pytest.mark.parametrize("what", ["no frame", "too many", "shape", "nan", "too large", "error"])
def test_nothing_is_left_behind_where_frames_do_not_fit(cloth, tmp_path, what):
    animation = open_animation(cloth)
    frame = animation.frame(0)

    def failing():
        yield frame
        raise ValueError("of the caller")

    frames = {
        "no frame": [],
        "too many": [frame] * 4,
        "shape": [frame[1:]],
        "nan": [frame * np.nan],
        "too large": [frame + 1e39],
        "error": failing(),
    }[what]
    with pytest.raises(ValueError if what == "error" else FileFormatError):
        animation.write(tmp_path / "copy.abc", frames)
    assert os.listdir(tmp_path) == ["cloth.abc"]


def write_refused(path, what):
    archive = Abc.OArchive(str(path))
    top = archive.getTop()
    two = [points(0), points(1)]
    if what == "nan":
        add_mesh(archive, top, "m", [points(0), points(1) * np.float32(np.nan)])
    elif what == "count":
        add_mesh(archive, top, "m", [points(0), points(1, 5)])
    elif what == "polygons":
        add_mesh(archive, top, "m", two, corners=[CORNERS, [0, 1, 2, 3, 1, 2, 3]])
    elif what == "corners":
        add_mesh(archive, top, "m", [points(0)], corners=[[0, 1, 2, 3, 0, 2, 4]])
    elif what == "times":
        add_mesh(archive, top, "a", two)
        add_mesh(archive, top, "m", two, rate=0.1)
    elif what == "instance":
        mesh = add_mesh(archive, top, "m", two)
        top.addChildInstance(mesh, "copy")


@pytest.mark.parametrize(
    ("what", "match"),
    [
        ("nan", "frame 1: mesh /m: expected finite positions"),
        ("count", "frame 1: mesh /m: expected 4 vertices, as in frame 0, found 5"),
        ("polygons", "frame 1: mesh /m: expected the polygons of frame 0"),
        ("corners", "mesh /m: expected vertices from 0 to 3 in the polygons, found 0 to 4"),
        ("times", "mesh /m: expected samples at the 2 times of mesh /a"),
        ("instance", "/copy: is an instance"),
        ("empty", "expected meshes, found none"),
    ],
)
def test_refusals_name_frame_and_mesh(tmp_path, what, match):
    path = tmp_path / "refused.abc"
    write_refused(path, what)
    with pytest.raises(FileFormatError, match=match) as caught:
        read_all(path)
    assert str(path) in str(caught.value)


def test_a_property_that_the_package_cannot_write_is_refused_before_the_frames(
    tmp_path, monkeypatch
):
    path = tmp_path / "cloth.abc"
    write_cloth(path)
    animation = open_animation(path)
    monkeypatch.setattr("izo_ref.formats.alembic_copy._write_samples", lambda *arguments: None)
    with pytest.raises(FileFormatError, match=r"cannot write .* as it was"):
        animation.write(tmp_path / "copy.abc", [animation.frame(0)])
    assert os.listdir(tmp_path) == ["cloth.abc"]


def read_all(path):
    animation = open_animation(path)
    for number in range(animation.n_frames):
        animation.frame(number)


def test_bad_files_are_refused(tmp_path):
    for name, content in {"empty.abc": b"", "text.abc": b"solid\n", "ogawa.abc": b"Ogawa"}.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(FileFormatError, match=name):
            open_animation(tmp_path / name)
    with pytest.raises(FileFormatError, match="No such file"):
        open_animation(tmp_path / "nothing.abc")


def test_damaged_files_open_or_are_refused(cloth, tmp_path, capfd):
    whole = cloth.read_bytes()
    for seed in range(300):
        print("seed", seed)
        path = tmp_path / "damaged.abc"
        path.write_bytes(damaged(whole, np.random.default_rng(seed)))
        with suppress(FileFormatError):
            read_all(path)
    assert capfd.readouterr().err == ""
