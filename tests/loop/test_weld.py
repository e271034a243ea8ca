"""Vertices that coincide are one vertex: the answers are those of a mesh that is welded by hand."""

import time

import numpy as np
import pytest

import izo_ref
from izo_ref import Status, errors
from tests.helpers.seams import (
    crossing_cloths,
    cut,
    doubled_layer,
    folding_cloth,
    seams,
    shuffled,
)
from tests.helpers.shapes import grid
from tests.naive.welding import weld_by_hand

NAMES = (
    "one seam",
    "seam on the fold",
    "crossing seams",
    "seams in a T",
    "closed tube",
    "soup",
    "soup of masses",
    "pinned soup",
    "seam of the pinned part",
    "doubled layer",
    "negative zeros",
)


def by_hand(mesh, **options):
    """Return the mesh welded by hand as a scene, and which of its vertices each vertex is."""
    pinned = mesh.get("pinned", np.zeros(len(mesh["positions_t0"]), bool))
    arrays = mesh["positions_t0"], mesh["positions_t1"], mesh["faces"]
    welded, of = weld_by_hand(*arrays, mesh.get("masses"), pinned)
    return izo_ref.Scene(**welded, **options), of


def test_every_kind_of_seam_is_tried(rng):
    assert tuple(seams(rng)) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_the_answer_is_that_of_the_mesh_welded_by_hand(rng, name):
    mesh = seams(rng)[name]
    with pytest.raises(errors.InitialIntersectionError, match=r"coincide exactly.*weld=0"):
        izo_ref.Scene(**mesh, prescribed="block")  # or pinned seams are left out
    merged, of = by_hand(mesh)
    scene = izo_ref.Scene(**mesh, weld=0)
    assert len(scene.faces) == len(merged.faces)
    assert scene.components.count == merged.components.count
    expected, found = izo_ref.resolve(merged, 1e-3), izo_ref.resolve(scene, 1e-3)
    assert len(expected.impacts.toi) > 0
    assert found.status is expected.status is Status.FREE
    assert found.positions.tobytes() == expected.positions[of].tobytes()
    assert found.positions.tobytes() == found.positions[scene.copies].tobytes()
    assert found.multipliers.tobytes() == expected.multipliers.tobytes()
    np.testing.assert_array_equal(of[found.impacts.nodes], expected.impacts.nodes)
    assert found.objective == expected.objective
    assert found.residuals == expected.residuals
    assert found.certificate.candidates == expected.certificate.candidates
    assert [row[:7] for row in found.history] == [row[:7] for row in expected.history]
    np.testing.assert_array_equal(
        of[izo_ref.find_impacts(scene).nodes], izo_ref.find_impacts(merged).nodes
    )


@pytest.mark.parametrize(("name", "n_faces"), [("soup", 0), ("doubled layer", 288)])
def test_the_refusal_is_quick_and_says_what_coincides(rng, name, n_faces):
    """The soup has 576 faces and takes 0.1 CPU s."""
    labels = {"soup": np.arange(576), "doubled layer": np.zeros(576)}[name]
    mesh = crossing_cloths(rng, 13)
    mesh = cut(mesh, labels) if name == "soup" else doubled_layer(mesh, np.arange(576) >= 288)
    for _ in range(2):  # the first time compiles
        begin = time.process_time()
        with pytest.raises(errors.InitialIntersectionError) as caught:
            izo_ref.Scene(**mesh, prescribed="block")  # or pinned seams are left out
        taken = time.process_time() - begin
    assert taken < 0.5
    said = str(caught.value)
    n = len(mesh["positions_t0"])
    places, counts = np.unique(mesh["positions_t0"], axis=0, return_counts=True)
    several = counts[counts > 1]
    assert n > len(places)
    assert said.startswith(
        f"positions_t0: {several.sum()} vertices coincide exactly, in {len(several)} groups"
    )
    assert (f"{n_faces} faces lie exactly on others" in said) == (n_faces > 0)
    assert "different places" not in said
    assert len(caught.value.pairs.nodes) > 0


def test_the_options_of_a_plan_do_not_change_the_answer(rng):
    mesh = seams(rng)["pinned soup"]
    scene = izo_ref.Scene(**mesh, weld=0)
    everything = izo_ref.Options(plan="everything")
    found = izo_ref.resolve(scene, 1e-3, options=everything)
    expected = izo_ref.resolve(by_hand(mesh)[0], 1e-3, options=everything)
    assert found.positions.tobytes() == expected.positions[by_hand(mesh)[1]].tobytes()
    first = found.plan.lines[1]
    assert first.stage == "vertices"
    assert first.reason.startswith(f"{(scene.masses == 0.0).sum()} of {len(scene.masses)} ")


def test_a_vertex_that_ends_elsewhere_is_not_welded(rng):
    """It is told apart in the message, and intersects what it touches."""
    mesh = cut(folding_cloth(rng), np.repeat([0, 1], 49))
    end = mesh["positions_t1"]
    end[-1] += (0.0, 0.0, 1e-9)
    with pytest.raises(errors.InitialIntersectionError) as caught:
        izo_ref.Scene(**mesh, prescribed="block")  # or pinned seams are left out
    assert "weld=0" in str(caught.value)
    assert "The vertices of 1 group end at different places" in str(caught.value)
    with pytest.raises(errors.InitialIntersectionError) as caught:
        izo_ref.Scene(**mesh, weld=0)
    assert "2 vertices coincide exactly, in 1 group, the first" in str(caught.value)
    assert "weld=0" not in str(caught.value)
    assert izo_ref.Scene(**mesh, weld=1e-8).copies is not None


def test_a_copy_at_another_place_is_not_certified(rng):
    scene = izo_ref.Scene(**seams(rng)["one seam"], weld=0)
    positions = izo_ref.resolve(scene, 1e-3).positions.copy()
    copy = np.flatnonzero(scene.copies != np.arange(len(positions)))[1]
    positions[copy, 2] += 1e-12
    with pytest.raises(errors.WeldError, match=rf"1 elsewhere, the first is vertex {copy}, 1e-12"):
        izo_ref.certify_path(scene, positions)


@pytest.mark.parametrize("name", ["crossing seams", "pinned soup", "doubled layer"])
def test_the_next_step_keeps_the_weld(rng, name):
    mesh = seams(rng)[name]
    merged, of = by_hand(mesh)
    scene, move = izo_ref.Scene(**mesh, weld=0), rng.normal(scale=0.02, size=(of.max() + 1, 3))
    for _ in range(2):
        found, expected = izo_ref.resolve(scene, 1e-3), izo_ref.resolve(merged, 1e-3)
        assert found.positions.tobytes() == expected.positions[of].tobytes()
        end = expected.positions + move
        copies = scene.copies
        scene, merged = scene.after(found, end[of]), merged.after(expected, end)
        assert scene.copies is copies
    wrong = end[of]
    wrong[copies != np.arange(len(of))] += 1e-9
    result = izo_ref.resolve(scene, 1e-3)
    with pytest.raises(errors.WeldError, match=r"positions_t1: .*positions_t1\[scene.copies\]"):
        scene.after(result, wrong)


def test_new_masses_and_pins_are_those_of_all_vertices(rng):
    mesh = seams(rng)["soup of masses"]
    scene = izo_ref.Scene(**mesh, weld=0)
    result, n = izo_ref.resolve(scene, 1e-3), len(scene.masses)
    own, copies = np.unique(scene.copies), scene.copies
    copy = int(np.flatnonzero(copies != np.arange(n))[0])
    pinned, masses = np.arange(n) == copy, rng.uniform(1.0, 2.0, n)
    following = scene.after(result, result.positions, masses, pinned)
    assert (following.pinned == (copies == copies[copy])).all()
    np.testing.assert_array_equal(following.masses, np.bincount(copies, masses, n))
    assert following.masses[own].all()
    kept = following.after(izo_ref.resolve(following, 1e-3), result.positions)
    np.testing.assert_array_equal(kept.masses, following.masses)
    np.testing.assert_array_equal(kept.pinned, following.pinned)


def test_a_group_without_mass_is_not_set_free(rng):
    mesh = seams(rng)["pinned soup"]
    mesh["masses"][mesh["pinned"]] = 0.0
    scene = izo_ref.Scene(**mesh, weld=0)
    result = izo_ref.resolve(scene, 1e-3)
    with pytest.raises(errors.MassError, match="set free"):
        scene.after(result, result.positions, pinned=np.zeros(len(scene.masses), bool))


def test_excluded_pairs_and_the_weld_are_kept_together(rng):
    """Two sheets with seams start crossed, and a part of them stays so in the next step."""
    n = 5
    sheet, faces = grid(n)
    start = np.concatenate((sheet, sheet[:, [0, 2, 1]] + (0.05, 0.4, -0.45)))
    mesh = {"positions_t0": start, "faces": np.concatenate((faces, faces + n * n))}
    mesh["positions_t1"] = start + np.repeat([[0.0, 0, 0], [0, 0, 0.3]], n * n, axis=0)
    mesh = shuffled(rng, cut(mesh, np.arange(2 * len(faces)) % 2))
    scene = izo_ref.Scene(**mesh, weld=0, initial_intersections="exclude")
    of = np.unique(scene.copies, return_inverse=True)[1]
    merged, _ = by_hand(mesh, initial_intersections="exclude")
    for _ in range(2):
        assert len(scene.excluded.nodes) > 0
        np.testing.assert_array_equal(of[scene.excluded.nodes], merged.excluded.nodes)
        found, expected = izo_ref.resolve(scene, 1e-3), izo_ref.resolve(merged, 1e-3)
        assert found.certificate.free
        assert found.positions.tobytes() == expected.positions[of].tobytes()
        scene = scene.after(found, found.positions)
        merged = merged.after(expected, expected.positions)
