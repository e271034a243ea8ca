"""A whole step: where it ends, what it keeps, and what it reports."""

import threading
from importlib import import_module

import numba
import numpy as np
import pytest

import izo_ref
from izo_ref import Options, Status
from izo_ref.base import errors
from izo_ref.base.devices import require_gpu
from izo_ref.base.records import Exclusion
from izo_ref.solvers.solve import solve_system
from tests.helpers.shapes import (
    falling_sheet,
    grid,
    pinched_sheet,
    two_sheets,
    vertex_over_face,
)
from tests.helpers.steps import load_step


def assert_sound(scene, result, thickness):
    """Check all that a free and converged result promises."""
    assert result.status is Status.FREE
    assert result.certificate.free
    assert result.converged
    assert result.feasible
    assert result.time_free == 1.0
    np.testing.assert_array_equal(result.positions[scene.pinned], scene.positions_t1[scene.pinned])
    touched = np.unique(result.impacts.nodes)
    still = np.setdiff1d(np.arange(len(scene.pinned)), touched)
    np.testing.assert_array_equal(result.positions[still], scene.positions_t1[still])
    i = result.impacts
    points = np.einsum("jk,jkx->jx", i.weights, result.positions[i.nodes])
    assert (np.einsum("jx,jx->j", i.normals, points) >= thickness * (1 - 1e-9)).all()
    for r in result.residuals:
        assert r.solved(1e-9, 1e-9)


def test_a_falling_vertex_ends_at_the_thickness_above_the_face():
    """The face is pinned, so the vertex, of mass 1, makes the whole correction."""
    scene = vertex_over_face(pinned=(True, True, True, False))
    result = izo_ref.resolve(scene, thickness=0.125)
    assert_sound(scene, result, 0.125)
    np.testing.assert_allclose(result.positions[3], [0.25, 0.25, 0.125], rtol=0.0, atol=1e-12)
    # One of three unpinned vertices of mass 1 moves by 1.125.
    assert result.objective == pytest.approx(1.125**2 / 3)


def test_vertices_share_the_correction_by_inverse_mass():
    scene = vertex_over_face(masses=(1.0, 2.0, 4.0, 0.5))
    result = izo_ref.resolve(scene, thickness=0.1, options=Options(relinearize=0))
    w, m = np.array([-0.5, -0.25, -0.25, 1.0]), scene.masses[:4]
    multiplier = 1.1 / np.sum(w**2 / m)
    moved = result.positions[:4] - scene.positions_t1[:4]
    np.testing.assert_allclose(moved[:, 2], multiplier * w / m, rtol=0.0, atol=1e-12)


def test_without_impacts_the_proposed_positions_come_back_bit_for_bit(rng):
    a, faces = grid(20, jitter=0.001 * rng.normal(size=(400, 3)))
    end = a + 0.1 * rng.normal(size=3) + 1e-4 * rng.normal(size=a.shape)
    result = izo_ref.resolve(izo_ref.Scene(a, end, faces))
    np.testing.assert_array_equal(result.positions, end)
    assert result.status is Status.FREE
    assert result.objective == 0.0
    assert len(result.history) == 1
    assert len(result.zones) == 0


@pytest.mark.parametrize("selection", ["independent", "first-of-any", "all"])
@pytest.mark.parametrize("pinned_below", [False, True])
def test_two_sheets_end_free(rng, selection, pinned_below):
    scene = two_sheets(rng, 10, pinned_below=pinned_below)
    result = izo_ref.resolve(scene, 1e-3, options=Options(selection=selection))
    assert_sound(scene, result, 1e-3)
    assert len(result.impacts.toi) > 10


def test_momentum_is_kept_by_zones_without_pinned_vertices(rng):
    scene = two_sheets(rng, 12)
    result = izo_ref.resolve(scene, 1e-3)
    checked = 0
    for z in range(len(result.zones)):
        vertices = result.zones.vertices_of(z)
        if scene.pinned[np.unique(result.impacts.nodes[result.zones.impacts_of(z)])].any():
            continue
        moved = (result.positions - scene.positions_t1)[vertices]
        forces = scene.masses[vertices, None] * moved
        # Positions of size 1 are rounded by u each.
        assert np.abs(forces.sum(axis=0)).max() <= 2.0**-52 * scene.masses[vertices].sum()
        checked += 1
    assert checked > 0


def test_relinearization_never_increases_the_objective(rng):
    gained = 0
    for n in (6, 8, 10):
        scene = two_sheets(rng, n)
        plain = izo_ref.resolve(scene, 1e-3, options=Options(relinearize=0))
        better = izo_ref.resolve(scene, 1e-3)
        assert better.objective <= plain.objective
        assert_sound(scene, better, 1e-3)
        gained += better.objective < plain.objective * (1 - 1e-6)
    assert gained > 0


@pytest.mark.parametrize(("budget", "rounds"), [(0.0, 1), (np.inf, 2)])
def test_a_round_begins_only_within_the_budget(rng, budget, rounds, monkeypatch):
    """The first round always begins; here it pays, so the second one depends on the budget."""
    monkeypatch.setattr(import_module("izo_ref.loop.rounds"), "LITTLE_WORK", 0)
    scene = two_sheets(rng, 8)
    options = Options(relinearize=2, relinearize_gain=0.0, relinearize_budget=budget)
    result = izo_ref.resolve(scene, 1e-3, options=options)
    assert {entry.round for entry in result.history} == set(range(rounds + 1))


def same_bits(a, b):
    """Check that two results have the same bits."""
    np.testing.assert_array_equal(a.positions, b.positions)
    np.testing.assert_array_equal(a.multipliers, b.multipliers)
    for x, y in zip(a.impacts, b.impacts, strict=True):
        np.testing.assert_array_equal(x, y)


def with_threads(n, scene, *args):
    """Resolve a scene with n threads."""
    before = numba.get_num_threads()
    numba.set_num_threads(n)
    try:
        return izo_ref.resolve(scene, *args)
    finally:
        numba.set_num_threads(before)


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="needs two threads")
def test_same_bits_with_one_thread_and_with_two(rng):
    scene = two_sheets(rng, 14)
    same_bits(with_threads(1, scene, 1e-3), with_threads(2, scene, 1e-3))


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="needs two threads")
@pytest.mark.parametrize("name", ["stack", pytest.param("stack-6k", marks=pytest.mark.data)])
def test_same_bits_with_one_thread_and_with_two_on_a_stored_step(name):
    scene = load_step(name)
    same_bits(with_threads(1, scene, 1e-4), with_threads(2, scene, 1e-4))


def test_calls_in_several_python_threads_give_the_same_bits(rng):
    scenes = [two_sheets(rng, 8 + k) for k in range(4)]
    alone = [izo_ref.resolve(scene, 1e-3) for scene in scenes]
    together = [None] * 4

    def work(k):
        together[k] = izo_ref.resolve(scenes[k], 1e-3)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for a, b in zip(alone, together, strict=True):
        same_bits(a, b)


def test_pinned_sheets_that_meet_block_the_step():
    scene = pinched_sheet(-0.05)
    result = izo_ref.resolve(scene, 1e-3)
    assert result.status is Status.BLOCKED
    assert not result.certificate.free
    assert result.zone_statuses == [Status.BLOCKED] * len(result.zones)
    excluded = result.certificate.excluded
    assert scene.pinned[excluded.nodes].all(axis=1).all()
    assert excluded.reasons.tolist() == [Exclusion.PRESCRIBED] * len(excluded.nodes)
    # The pinned sheets close the gap of 0.2 at t = 0.2 / 0.25.
    assert 0.0 < result.time_free <= 0.8 + 1e-12
    part = scene.positions_t0 + 0.999 * result.time_free * (result.positions - scene.positions_t0)
    assert izo_ref.certify_path(scene, part).free


def test_a_sheet_that_fits_between_pinned_sheets_ends_free():
    scene = pinched_sheet(0.05, bump=0.2)
    result = izo_ref.resolve(scene, 1e-3)
    assert_sound(scene, result, 1e-3)


def test_a_method_that_does_not_converge_is_not_called_free(rng):
    scene = two_sheets(rng, 6)
    options = Options(method="gradient", preset="xrtailor", max_iterations=10)
    result = izo_ref.resolve(scene, 1e-3, options=options)
    assert result.status is not Status.FREE
    assert not result.converged


def test_without_a_median_edge_length_a_thickness_has_to_be_passed():
    """After a collapse, the corners of all faces may coincide; the value was not the caller's."""
    start = np.array([[0.0, 0, 0], [0, 0, 0], [0, 0, 0], [1, 0, 0]])
    scene = izo_ref.Scene(start, start, [[0, 1, 2]], initial_intersections="exclude")
    with pytest.raises(errors.ThicknessError, match=r"the default is .* pass a thickness"):
        izo_ref.resolve(scene)
    assert izo_ref.resolve(scene, 0.25).thickness == 0.25


def test_the_thickness_has_a_default_and_bad_values_are_refused():
    scene = vertex_over_face()
    lengths = np.linalg.norm(
        scene.positions_t0[scene.edges[:, 0]] - scene.positions_t0[scene.edges[:, 1]], axis=1
    )
    assert izo_ref.resolve(scene).thickness == pytest.approx(1e-3 * np.median(lengths))
    assert izo_ref.resolve(scene, 0.25).thickness == 0.25
    for bad in (0.0, -1.0, np.nan, np.inf, "x"):
        with pytest.raises(errors.ThicknessError):
            izo_ref.resolve(scene, bad)


def has_gpu():
    """Return whether this machine has a GPU that can be used."""
    try:
        require_gpu()
    except errors.DeviceUnavailableError:
        return False
    return True


def test_unavailable_and_unknown_devices_are_refused():
    scene = vertex_over_face()
    if not has_gpu():
        with pytest.raises(errors.DeviceUnavailableError, match="install"):
            izo_ref.resolve(scene, device="cuda")
    with pytest.raises(errors.OptionError, match="tpu"):
        izo_ref.resolve(scene, device="tpu")
    assert izo_ref.resolve(scene, device="auto").status is Status.FREE


def test_iterations_are_reported_as_they_end(rng):
    seen = []
    result = izo_ref.resolve(two_sheets(rng), 1e-3, on_iteration=seen.append)
    assert seen == result.history
    assert seen[-1].found == 0 or seen[-1].round > 0


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scaled_units_give_the_scaled_positions(rng, scale):
    scene = two_sheets(rng)
    scaled = izo_ref.Scene(
        scale * scene.positions_t0, scale * scene.positions_t1, scene.faces, 1e-5 * scene.masses
    )
    a, b = izo_ref.resolve(scene, 1e-3), izo_ref.resolve(scaled, scale * 1e-3)
    np.testing.assert_allclose(b.positions / scale, a.positions, rtol=0.0, atol=1e-9)


def test_steps_far_from_the_origin_end_free(rng):
    """Far away, a thousandth of an edge is near the rounding of the coordinates."""
    scene = two_sheets(rng, 12)
    for shift in (1e3, 1e5):
        far = izo_ref.Scene(
            scene.positions_t0 + shift, scene.positions_t1 + shift, scene.faces, scene.masses
        )
        result = izo_ref.resolve(far, 1e-3)
        assert result.status is Status.FREE
        assert result.converged


@pytest.mark.parametrize("gap", [1e-3, 1e-9, 1e-12])
def test_triangles_at_rest_a_hair_apart_are_free(rng, gap):
    """Two triangles rest in one plane, which is turned at random, with a small gap in between."""
    flat = np.array([[0, 0], [1, 0], [0.4, 1], [0.45, -gap], [0.2, -1], [0.9, -1]])
    for _ in range(10):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        start = np.column_stack((flat, np.zeros(6))) @ turn.T
        try:
            scene = izo_ref.Scene(start, start, [[0, 1, 2], [3, 4, 5]])
        except errors.InitialIntersectionError:
            assert gap < 1e-10  # the rotation has rounded the gap away
            continue
        assert izo_ref.resolve(scene).status is Status.FREE
        drift = scene.positions_t0 + 0.3 * rng.normal(size=3)
        if gap > 1e-10:
            assert izo_ref.certify_path(scene, drift).free


def test_a_scene_may_be_empty():
    result = izo_ref.resolve(izo_ref.Scene(np.empty((0, 3)), np.empty((0, 3)), []))
    assert result.status is Status.FREE
    assert result.positions.shape == (0, 3)


def objective_of_layers(n_layers, depth, gap, thickness):
    """Return the objective if all sheets of `falling_sheet` end as flat layers at the thickness."""
    layers = np.arange(n_layers)
    proposed = -gap * layers - depth * (layers == 0)
    left = proposed + thickness * layers  # the layers leave the centre of mass where it is
    return float(((left - left.mean()) ** 2).mean())


@pytest.mark.parametrize("rotated", [False, True])
@pytest.mark.parametrize(("n_layers", "depth"), [(2, 100.0), (4, 10.0), (6, 100.0), (4, 1000.0)])
def test_a_sheet_that_falls_far_through_others_takes_them_along(rng, n_layers, depth, rotated):
    """Impacts are up to 3000 edges deep. Each sheet is held before the next one is met."""
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0] if rotated else None
    scene = falling_sheet(n_layers, depth, rotation=rotation)
    result = izo_ref.resolve(scene, 1e-4)
    assert result.status is Status.FREE
    assert result.certificate.free
    expected = objective_of_layers(n_layers, depth, 0.05, 1e-4)
    # floats this far from the origin round by up to 1e-13 m, which is 1e-9 of the thickness
    assert result.objective == pytest.approx(expected, rel=1e-9)
    assert sum(line.round == 0 for line in result.history) <= n_layers + 1


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_sheet_of_which_each_vertex_is_thrown_far_ends_free(seed):
    rng = np.random.default_rng(seed)
    start, faces = grid(6)
    scene = izo_ref.Scene(start, start + 10.0 * rng.normal(size=start.shape), faces)
    result = izo_ref.resolve(scene, 1e-4)
    assert result.status is Status.FREE
    assert result.certificate.free


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="needs two threads")
def test_same_bits_with_one_thread_and_with_two_in_a_deep_step():
    scene = falling_sheet(6, 100.0, n=8)
    same_bits(with_threads(1, scene, 1e-4), with_threads(2, scene, 1e-4))


def test_a_zone_that_is_solved_again_starts_from_its_own_multipliers(rng, monkeypatch):
    """Impacts are told apart by their weights and normals, which stay as they are in the loop."""
    module, known, n_warm = import_module("izo_ref.loop.cpu_step"), {}, 0

    def recorded(system, options, *, start, deadline):
        nonlocal n_warm
        solution = solve_system(system, options, start=start, deadline=deadline)
        for j, value in enumerate(start):
            impact = system.weights[j].tobytes(), system.normals[j].tobytes()
            if value > 0.0:
                assert value == known[impact]
                n_warm += 1
            known[impact] = solution.multipliers[j]
        return solution

    monkeypatch.setattr(module, "solve_system", recorded)
    izo_ref.resolve(two_sheets(rng, 8), 1e-3, options=Options(relinearize=0))
    assert n_warm > 20
