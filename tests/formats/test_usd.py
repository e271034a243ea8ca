import os
from contextlib import suppress

import numpy as np
import pytest

from izo_ref.base.errors import FileFormatError
from izo_ref.formats.animation import open_animation, triangles
from tests.helpers.damaged_files import damaged

pytest.importorskip("pxr", reason="USD needs the package usd-core")

from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

SUFFIXES = (".usda", ".usdc", ".usd")
QUAD = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def points(seed, n=4):
    return np.random.default_rng(seed).random((n, 3)).astype(np.float32)


def add_mesh(stage, path, samples):
    """Add a mesh of a quad and a triangle; `samples` are points by time, None is the default."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreateFaceVertexCountsAttr([4, 3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 0, 2, 1])
    mesh.CreateNormalsAttr([(0, 0, 1)] * 4)
    mesh.CreateExtentAttr([(0, 0, 0), (1, 1, 1)])
    coordinates = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    coordinates.Set([(0, 0), (1, 0), (1, 1), (0, 1)])
    for time, value in samples.items():
        where = Usd.TimeCode.Default() if time is None else time
        mesh.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(np.array(value, "f4")), where)
    return mesh


def new_stage(path):
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(3)
    stage.SetTimeCodesPerSecond(30)
    return stage


@pytest.fixture(params=SUFFIXES)
def cloth(request, tmp_path):
    """A file with two moving meshes and one that stands still."""
    path = tmp_path / f"cloth{request.param}"
    stage = new_stage(path)
    add_mesh(stage, "/a", {1: points(1), 2: points(2), 3: points(3)})
    add_mesh(stage, "/group/b", {1: points(4), 3: points(5)})
    add_mesh(stage, "/group/floor", {None: QUAD})
    stage.Save()
    return path


@pytest.mark.parametrize("up", ["y", "z"])
def test_the_axis_that_points_up_is_that_of_the_stage(cloth, up):
    stage = Usd.Stage.Open(str(cloth))
    UsdGeom.SetStageUpAxis(stage, up.upper())
    stage.Save()
    assert open_animation(cloth).up == up


def second_reader(path, name, time):
    stage = Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(path)))
    return np.array(UsdGeom.Mesh(stage.GetPrimAtPath(name)).GetPointsAttr().Get(time))


def text_of(path):
    return Sdf.Layer.OpenAsAnonymous(str(path)).ExportToString()


def test_meshes_and_frames_are_those_of_the_file(cloth):
    animation = open_animation(cloth)
    assert [mesh.name for mesh in animation.meshes] == ["/a", "/group/b", "/group/floor"]
    assert [mesh.first for mesh in animation.meshes] == [0, 4, 8]
    assert animation.meshes[1].counts.tolist() == [4, 3]
    assert animation.meshes[1].corners.tolist() == [0, 1, 2, 3, 0, 2, 1]
    assert animation.times.tolist() == [1, 2, 3]
    assert animation.n_frames == 3
    assert animation.is_exact
    assert len(triangles(animation.meshes)) == 9
    between = (points(4) + points(5)) / 2
    expected = np.concatenate([points(2), between, np.array(QUAD)])
    assert np.allclose(animation.frame(1), expected, atol=1e-7)
    assert animation.frame(0).dtype == np.float64
    assert (animation.frame(0)[:4] == points(1)).all()


def test_what_was_not_changed_is_written_as_it_was(cloth, tmp_path):
    animation = open_animation(cloth)
    copy = tmp_path / f"copy{cloth.suffix}"
    animation.write(copy, (animation.frame(number) for number in range(3)))
    assert text_of(copy) == text_of(cloth)
    assert copy.read_bytes()[:8] == cloth.read_bytes()[:8]  # text or binary, as it was
    assert sorted(os.listdir(tmp_path)) == sorted([cloth.name, copy.name])


def test_another_reader_finds_the_new_positions(cloth, tmp_path):
    animation = open_animation(cloth)
    new = [animation.frame(number) for number in range(3)]
    new[1] = new[1].copy()
    new[1][5] += 0.25
    new = [frame.astype(np.float32).astype(np.float64) for frame in new]
    copy = tmp_path / f"copy{cloth.suffix}"
    animation.write(copy, new)
    for number, time in enumerate((1, 2, 3)):
        found = [second_reader(copy, mesh.name, time) for mesh in animation.meshes]
        assert (np.concatenate(found) == new[number]).all()
    stage = Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(copy)))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/group/b"))
    assert np.array_equal(mesh.GetExtentAttr().Get(2)[1], new[1][4:8].max(axis=0).astype("f4"))
    assert mesh.GetPointsAttr().GetTimeSamples() == [1, 2, 3]
    unchanged = UsdGeom.Mesh(stage.GetPrimAtPath("/group/floor"))
    assert unchanged.GetPointsAttr().GetTimeSamples() == []
    assert UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get() is not None
    assert len(mesh.GetNormalsAttr().Get()) == 4
    assert stage.GetTimeCodesPerSecond() == 30
    assert (open_animation(copy).frame(1) == new[1]).all()


def test_a_mesh_that_stood_still_moves_from_the_frame_where_it_changes(cloth, tmp_path):
    animation = open_animation(cloth)
    new = [animation.frame(number).astype("f4").astype("f8") for number in range(3)]
    new[2][8:] += 1
    copy = tmp_path / f"copy{cloth.suffix}"
    animation.write(copy, new)
    floor = [second_reader(copy, "/group/floor", time) for time in (1, 2, 3)]
    assert (floor[0] == QUAD).all()
    assert (floor[1] == QUAD).all()
    assert (floor[2] == np.array(QUAD) + 1).all()


def test_fewer_frames_end_the_animation_sooner(cloth, tmp_path):
    animation = open_animation(cloth)
    copy = tmp_path / f"copy{cloth.suffix}"
    animation.write(copy, [animation.frame(0), animation.frame(1)])
    found = open_animation(copy)
    assert found.times.tolist() == [1, 2]
    assert (found.frame(1)[:4] == points(2)).all()
    assert Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(copy))).GetEndTimeCode() == 2


def test_a_mesh_without_a_sample_at_the_new_end_gets_one(cloth, tmp_path):
    animation = open_animation(cloth)
    copy = tmp_path / f"copy{cloth.suffix}"
    animation.write(copy, [animation.frame(0), animation.frame(1)])
    assert np.array_equal(open_animation(copy).frame(1), animation.frame(1))


def moved_stage(path):
    stage = new_stage(path)
    above = UsdGeom.Xform.Define(stage, "/above")
    above.AddTranslateOp().Set((1, 2, 3))
    turn = above.AddRotateXYZOp()
    for time in (1, 2, 3):
        turn.Set((10 * time, 20, 30), time)
    UsdGeom.Xform(add_mesh(stage, "/above/m", {1: points(1), 2: points(2)})).AddScaleOp().Set(
        (2, 2, 2)
    )
    stage.Save()


def test_transforms_are_applied_and_undone(tmp_path):
    path, copy = tmp_path / "moved.usdc", tmp_path / "copy.usdc"
    moved_stage(path)
    animation = open_animation(path)
    assert not animation.is_exact
    assert animation.times.tolist() == [1, 2, 3]
    stage = Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(path)))
    matrix = UsdGeom.XformCache(2).GetLocalToWorldTransform(stage.GetPrimAtPath("/above/m"))
    expected = [matrix.Transform(Gf.Vec3d(*map(float, p))) for p in points(2)]
    assert np.allclose(animation.frame(1), expected, rtol=0, atol=1e-14)
    new = [animation.frame(number) for number in range(3)]
    new[1][2] += 0.5
    written = [animation.as_written(number, frame) for number, frame in enumerate(new)]
    for number in range(3):
        assert np.array_equal(animation.as_written(number, written[number]), written[number])
    animation.write(copy, new)
    found = open_animation(copy)
    for number in range(3):
        assert np.array_equal(found.frame(number), written[number])
        assert np.abs(written[number] - new[number]).max() < 1e-6
    # vertices that stayed have the bits that were read
    assert (second_reader(copy, "/above/m", 2)[[0, 1, 3]] == points(2)[[0, 1, 3]]).all()


def test_a_stage_of_references_is_written_as_one_layer(cloth, tmp_path):
    path, copy = tmp_path / "shot.usda", tmp_path / "elsewhere" / "copy.usda"
    copy.parent.mkdir()
    stage = Usd.Stage.CreateNew(str(path))
    stage.DefinePrim("/actor").GetReferences().AddReference(f"./{cloth.name}", "/a")
    stage.Save()
    animation = open_animation(path)
    before = cloth.read_bytes()
    new = [(animation.frame(number) + 1).astype("f4").astype("f8") for number in range(3)]
    animation.write(copy, new)
    assert cloth.read_bytes() == before
    assert (second_reader(copy, "/actor", 3) == new[2]).all()
    for target in (path, cloth):
        with pytest.raises(FileFormatError, match=r"which is read|expected the suffix"):
            animation.write(target, new)


def test_a_file_is_not_written_over_itself(cloth, tmp_path):
    animation = open_animation(cloth)
    link = tmp_path / f"link{cloth.suffix}"
    link.symlink_to(cloth)
    before = cloth.read_bytes()
    for target in (cloth, link):
        with pytest.raises(FileFormatError, match="which is read"):
            animation.write(target, [animation.frame(0)])
    assert cloth.read_bytes() == before


def test_a_file_that_changed_is_read_anew(cloth, tmp_path):
    first = open_animation(cloth)
    new = [(first.frame(number) + 1).astype("f4").astype("f8") for number in range(3)]
    copy = tmp_path / f"copy{cloth.suffix}"
    first.write(copy, new)
    held = open_animation(copy)
    assert (held.frame(0) == new[0]).all()
    first.write(copy, [new[1]])
    again = open_animation(copy)
    assert (again.frame(0) == new[1]).all()
    assert again.n_frames == 1


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
        animation.write(tmp_path / f"copy{cloth.suffix}", frames)
    assert os.listdir(tmp_path) == [cloth.name]


def read_all(path):
    animation = open_animation(path)
    for number in range(animation.n_frames):
        animation.frame(number)


def refused(stage, path, match):
    stage.Save()
    with pytest.raises(FileFormatError, match=match) as caught:
        read_all(path)
    assert str(path) in str(caught.value)


def test_refusals_name_frame_and_mesh(tmp_path):
    path = tmp_path / "nan.usda"
    stage = new_stage(path)
    add_mesh(stage, "/m", {1: points(1), 2: points(2) * np.float32(np.nan)})
    refused(stage, path, "frame 1: mesh /m: expected finite positions")

    path = tmp_path / "count.usda"
    stage = new_stage(path)
    add_mesh(stage, "/m", {1: points(1), 2: points(2, 5)})
    refused(stage, path, "frame 1: mesh /m: expected 4 vertices, as in frame 0, found 5")

    path = tmp_path / "topology.usda"
    stage = new_stage(path)
    corners = add_mesh(stage, "/m", {1: points(1), 2: points(2)}).GetFaceVertexIndicesAttr()
    corners.Set([0, 1, 2, 3, 0, 2, 1], 1)
    corners.Set([0, 1, 2, 3, 1, 2, 3], 2)
    refused(stage, path, "frame 1: mesh /m: expected the polygons of frame 0")

    path = tmp_path / "corners.usda"
    stage = new_stage(path)
    add_mesh(stage, "/m", {1: points(1)}).GetFaceVertexIndicesAttr().Set([0, 1, 2, 3, 0, 2, 4])
    refused(stage, path, "mesh /m: expected vertices from 0 to 3 in the polygons, found 0 to 4")

    path = tmp_path / "flat.usda"
    stage = new_stage(path)
    UsdGeom.Xform(add_mesh(stage, "/m", {1: points(1)})).AddScaleOp().Set((1, 0, 1))
    refused(stage, path, "frame 0: mesh /m: expected a transform that can be undone")


def test_what_is_no_mesh_of_its_own_is_refused(tmp_path):
    path = tmp_path / "instance.usda"
    stage = new_stage(path)
    add_mesh(stage, "/m", {1: points(1)})
    copy = stage.DefinePrim("/copy")
    copy.GetReferences().AddInternalReference("/m")
    copy.SetInstanceable(True)
    refused(stage, path, "/copy: is an instance")

    path = tmp_path / "skinned.usda"
    stage = new_stage(path)
    binding = UsdSkel.BindingAPI.Apply(add_mesh(stage, "/m", {1: points(1)}).GetPrim())
    binding.CreateJointIndicesPrimvar(False, 1).Set([0] * 4)
    refused(stage, path, "mesh /m: is skinned")

    path = tmp_path / "empty.usda"
    refused(new_stage(path), path, "expected meshes, found none")

    path = tmp_path / "missing.usda"
    stage = new_stage(path)
    add_mesh(stage, "/m", {1: points(1)})
    stage.DefinePrim("/a").GetReferences().AddReference("./nowhere.usda")
    refused(stage, path, "USD warns: .*nowhere")


def test_bad_files_are_refused(tmp_path):
    for name, content in {"empty.usda": b"", "empty.usdc": b"", "text.usdc": b"solid\n"}.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(FileFormatError, match=name):
            open_animation(tmp_path / name)
    with pytest.raises(FileFormatError, match="No such file"):
        open_animation(tmp_path / "nothing.usd")


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_damaged_files_open_or_are_refused(suffix, tmp_path, capfd):
    path = tmp_path / f"whole{suffix}"
    moved_stage(path)
    whole = path.read_bytes()
    for seed in range(150):
        print("seed", seed)
        path = tmp_path / f"damaged{suffix}"
        path.write_bytes(damaged(whole, np.random.default_rng(seed)))
        with suppress(FileFormatError):
            read_all(path)
    assert capfd.readouterr().err == ""
