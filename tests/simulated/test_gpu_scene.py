"""Steps of a simulation on a GPU, compared with the same steps one by one on the CPU."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Options, Status
from izo_ref.base.errors import (
    DeviceMemoryError,
    NonFiniteError,
    OptionError,
    ShapeError,
    SizeError,
    UncertifiedStartError,
)
from izo_ref.base.gpu_arrays import shared_copy, to_cpu
from izo_ref.base.gpu_interop import own_array
from izo_ref.loop import gpu_scene
from izo_ref.loop.gpu_scene import ResidentScene
from tests.helpers.shapes import pinched_sheet, two_sheets, vertex_over_face

THICKNESS = 1e-3
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


def on_cpu(result):
    return to_cpu(own_array(result.positions))


def proposed_after(result, start, rng):
    """Return positions that go on as before, and waver a little."""
    return result.positions + 0.7 * (result.positions - start) + rng.normal(0, 0.02, start.shape)


def run(scene, on_gpu, n_steps, rng, send=lambda positions: positions):
    """Resolve steps on the GPU and on the CPU, and yield both results and the scene of the step."""
    proposed = scene.positions_t1
    for _ in range(n_steps):
        found, expected = on_gpu.resolve(send(proposed)), izo_ref.resolve(scene, THICKNESS)
        yield found, expected, scene
        proposed = proposed_after(expected, scene.positions_t0, rng)
        scene = scene.after(expected, proposed)


def check(found, expected, scene):
    """Check that a step ended as on the CPU, but for the rounding that the numbering decides."""
    assert found.status is expected.status is Status.FREE
    assert found.full is None
    assert found.n_impacts == len(expected.impacts.toi) > 0
    assert len(found.history) == len(expected.history)
    ends = on_cpu(found)
    assert izo_ref.certify_path(scene, ends).free
    size = np.abs(expected.positions).max()
    np.testing.assert_allclose(ends, expected.positions, rtol=0.0, atol=1e-13 * size)
    assert found.objective == pytest.approx(expected.objective, rel=1e-12)


@pytest.mark.parametrize("kept", [1, 32])
def test_steps_end_as_one_by_one_on_the_cpu(rng, monkeypatch, kept):
    monkeypatch.setattr(gpu_scene, "KEPT_STEPS", kept)
    scene = two_sheets(rng, 2)
    ends = []
    for found, expected, own in run(scene, ResidentScene(scene, THICKNESS), 3, rng):
        check(found, expected, own)
        ends.append((found, on_cpu(found)))
    for found, positions in ends:
        assert np.array_equal(on_cpu(found), positions), "a later step changes no earlier result"


def test_positions_are_taken_where_they_are(rng):
    scene = two_sheets(rng, 2, pinned_below=True)
    on_gpu = izo_ref.keep_on_gpu(scene)
    proposed = shared_copy(scene.positions_t1)
    found = on_gpu.resolve(proposed)
    assert np.array_equal(on_cpu(found), on_cpu(ResidentScene(scene).resolve(scene.positions_t1)))
    assert on_gpu.thickness == izo_ref.resolve(scene).thickness
    again = on_gpu.resolve(found.positions)
    assert np.array_equal(on_cpu(again), on_cpu(found)), "what does not move stays bit for bit"
    assert again.n_impacts == 0


def test_a_mesh_that_travels_gets_new_coordinates(rng, monkeypatch):
    scene = two_sheets(rng, 2)
    on_gpu, made = ResidentScene(scene, THICKNESS), []
    make = ResidentScene._make

    def counted(own, *arguments):
        made.append(1)
        make(own, *arguments)

    monkeypatch.setattr(ResidentScene, "_make", counted)
    first = on_cpu(on_gpu.resolve(scene.positions_t1))
    assert made == []
    far = first + (100.0, 0.0, 0.0)
    assert np.array_equal(on_cpu(on_gpu.resolve(far)), far)
    assert len(made) == 1


@pytest.mark.parametrize(
    ("bad", "error", "message"),
    [
        (lambda ends: ends[:-1], ShapeError, "positions_t1"),
        (lambda ends: shared_copy(ends[:-1].copy()), ShapeError, "positions_t1: expected float64"),
        (lambda ends: np.where(np.arange(len(ends))[:, None] == 1, np.nan, ends),
         NonFiniteError, r"positions_t1.*1"),
        (lambda ends: shared_copy(np.full_like(ends, np.inf)), NonFiniteError, "positions_t1"),
        (lambda ends: ends + 1e300, (SizeError, OptionError), "."),
    ],
)  # fmt: skip
def test_bad_positions_are_refused_and_change_nothing(bad, error, message):
    scene = vertex_over_face()
    on_gpu = ResidentScene(scene, THICKNESS)
    with pytest.raises(error, match=message):
        on_gpu.resolve(bad(scene.positions_t1))
    first = on_gpu.resolve(scene.positions_t1)
    expected = izo_ref.resolve(scene, THICKNESS).positions
    assert np.array_equal(on_cpu(first), expected)
    with pytest.raises(error, match=message):
        on_gpu.resolve(bad(scene.positions_t1))
    assert np.array_equal(on_cpu(on_gpu.resolve(first.positions)), expected)


def test_scenes_that_need_the_cpu_each_step_are_refused():
    start = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [1, 1, -1], [1, 1, 1], [1, 2, 1]], float)
    faces = [[0, 1, 2], [3, 4, 5]]
    scene = izo_ref.Scene(start, start, faces, initial_intersections="exclude")
    with pytest.raises(OptionError, match="pairs that are left out"):
        ResidentScene(scene)


def test_rows_of_a_wider_array_are_taken_in_every_way(rng, monkeypatch):
    scene = two_sheets(rng, 2)
    expected = on_cpu(ResidentScene(scene, THICKNESS).resolve(scene.positions_t1))
    wide = shared_copy(np.hstack((scene.positions_t1, np.full((len(scene.pinned), 2), 7.0))))
    for kept in (0, 32):
        monkeypatch.setattr(gpu_scene, "KEPT_STEPS", kept)
        found = ResidentScene(scene, THICKNESS).resolve(wide[:, :3])
        assert np.array_equal(on_cpu(found), expected)


def test_nothing_follows_a_step_that_an_error_ended(rng, monkeypatch):
    scene = two_sheets(rng, 2)
    on_gpu = ResidentScene(scene, THICKNESS)

    def failing(step):
        raise DeviceMemoryError("no memory")

    with monkeypatch.context() as patch:
        patch.setattr(gpu_scene.GpuStep, "select", failing)
        with pytest.raises(DeviceMemoryError):
            on_gpu.resolve(scene.positions_t1)
    with pytest.raises(UncertifiedStartError, match="ended with an error"):
        on_gpu.resolve(scene.positions_t1)


def test_pinned_parts_that_pass_through_each_other_are_no_free_start():
    start = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [1, 1, 1.0], [1, 1.5, 1], [1.5, 1, 1]])
    end = start - np.where(np.arange(6)[:, None] > 2, (0.0, 0.0, 2.0), 0.0)
    scene = izo_ref.Scene(start, end, [[0, 1, 2], [3, 4, 5]], pinned=np.ones(6, bool))
    on_gpu = ResidentScene(scene, THICKNESS)
    found = on_gpu.resolve(end)
    assert found.full is not None
    assert found.status is izo_ref.resolve(scene, THICKNESS).status
    assert found.status is not Status.FREE


def test_a_step_without_a_free_path_is_resolved_with_the_fail_safe(rng):
    scene = two_sheets(rng, 2)
    on_gpu = ResidentScene(scene, THICKNESS, Options(max_iterations=1))
    found = on_gpu.resolve(scene.positions_t1)
    expected = izo_ref.resolve(scene, THICKNESS, options=Options(max_iterations=1))
    assert found.status is expected.status is Status.FREE_BY_FALLBACK
    assert found.full is not None
    assert np.array_equal(on_cpu(found), expected.positions)
    again = on_gpu.resolve(expected.positions)
    assert again.status is Status.FREE
    assert np.array_equal(on_cpu(again), expected.positions)


def test_nothing_follows_a_blocked_step():
    scene = pinched_sheet(-0.05, bump=0.2, side=2)
    on_gpu = ResidentScene(scene, THICKNESS)
    assert on_gpu.resolve(scene.positions_t1).status is Status.BLOCKED
    with pytest.raises(UncertifiedStartError, match="was blocked"):
        on_gpu.resolve(scene.positions_t0)


def test_a_time_limit_ends_a_step_with_a_certified_answer(rng):
    scene = two_sheets(rng, 2)
    on_gpu = ResidentScene(scene, THICKNESS, Options(max_seconds=1e-9))
    found = on_gpu.resolve(scene.positions_t1)
    assert found.full is not None
    assert found.full.reason
    assert found.full.certificate.free or found.status is Status.BLOCKED
