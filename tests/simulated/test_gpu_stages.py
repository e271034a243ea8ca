"""Steps on a GPU with too little room at first, and steps that follow in the same buffers."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Options
from izo_ref.base.gpu_arrays import to_cpu, to_gpu
from izo_ref.detection import gpu_detector as detect
from izo_ref.detection.gpu_found import Found
from izo_ref.detection.serial import found_counts as places
from izo_ref.loop import gpu_stages as stages
from izo_ref.loop.gpu_step import GpuStep
from izo_ref.loop.iterate import Loop
from izo_ref.solvers import gpu_augmented_lagrangian as lagrangian
from izo_ref.solvers import gpu_pivoting as pivoting
from izo_ref.solvers import gpu_solve as solve
from tests.helpers.listed import leave_larger_zones
from tests.helpers.same import same_result
from tests.helpers.sample import sample
from tests.helpers.shapes import falling_sheet, two_sheets, vertex_over_face
from tests.helpers.touching import random_scene

# In compiled code, x / 0 is inf without a warning; in the simulator numpy warns.
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")
THICKNESS_M = 1e-3
N_NUMBERS = 10  # of `Iteration`, before its times


@pytest.fixture
def grown(monkeypatch):
    """Let nothing have room at first; return the names of the stages, each as often as it grew."""
    names = []
    for owner, method in (
        (stages.Stages, "grow"),
        (detect.Detector, "grow"),
        (detect.Detector, "put"),
    ):
        monkeypatch.setattr(owner, method, noting(getattr(owner, method), names))
    for owner, name in (
        (stages, "LEAST_IMPACTS"),
        (stages, "IMPACTS_PER_VERTEX"),
        (detect, "LEAST_CONTACTS"),
        (detect, "CONTACTS_PER_VERTEX"),
        (detect, "PAIRS_PER_QUERY"),
    ):
        monkeypatch.setattr(owner, name, 1 if name.startswith("LEAST") else 0)
    return names


def noting(method, names):
    """Return a method that notes its name each time that it says that something grew."""

    def noted(*arguments):
        has_grown = method(*arguments)
        names.extend([method.__qualname__] * has_grown)
        return has_grown

    return noted


def same_history(found, expected):
    """Check that two histories have the same numbers, but for the times."""
    assert [line[:N_NUMBERS] for line in found] == [line[:N_NUMBERS] for line in expected]


NAMED = {"method": "jacobi", "max_steps": 4, "relinearize": 0, "max_iterations": 3}
SCENES = {
    "sheets": (lambda rng: two_sheets(rng, 3), {}),
    "left": (lambda rng: two_sheets(rng, 3), {"relinearize": 0}),
    "deep": (lambda _: falling_sheet(3, 20.0, n=2), {"relinearize": 0}),
    "everything": (lambda rng: two_sheets(rng, 2), {"plan": "everything"}),
    "all": (lambda rng: two_sheets(rng, 2), {"selection": "all"}),
    "named": (lambda rng: two_sheets(rng, 2), NAMED),
    "named-everything": (lambda rng: two_sheets(rng, 2), NAMED | {"plan": "everything"}),
}


@pytest.mark.parametrize("name", sample(SCENES, 3))
def test_steps_without_room_end_with_the_same_bits(rng, request, monkeypatch, name):
    make, options = SCENES[name]
    scene, options = make(rng), Options(**options)
    monkeypatch.setattr(lagrangian, "MANY", 3)
    if name == "left":
        monkeypatch.setattr(solve, "SMALL", 1)
        monkeypatch.setattr(pivoting, "LARGEST", 1)
        leave_larger_zones(monkeypatch, pivoting)
    expected = izo_ref.resolve(scene, THICKNESS_M, "cuda", options)
    grown = request.getfixturevalue("grown")
    found = izo_ref.resolve(scene, THICKNESS_M, "cuda", options)
    same_result(found, expected)
    same_history(found.history, expected.history)
    assert (found.left_to_cpu > 0) == (name == "left")
    assert grown.count("Stages.grow") >= (1 if name == "all" else 2)
    assert grown.count("Detector.grow") >= 2
    if "named" not in name:  # the sums of methods by name are rounded in another order
        on_cpu = izo_ref.resolve(scene, THICKNESS_M, options=options)
        assert np.array_equal(found.positions, on_cpu.positions)


def same_with_more_room(request, scene, thickness):
    """Resolve a scene with and without room; return what grew."""
    options = Options(relinearize=0)
    expected = izo_ref.resolve(scene, thickness, "cuda", options)
    grown = request.getfixturevalue("grown")
    found = izo_ref.resolve(scene, thickness, "cuda", options)
    same_result(found, expected)
    same_history(found.history, expected.history)
    return set(grown)


@pytest.mark.parametrize("seed", [7, 30])
def test_impacts_of_touching_parts_are_selected_again_with_more_room(request, seed):
    start, end, faces, pinned = random_scene(np.random.default_rng(seed))
    scene = izo_ref.Scene(start, end, faces, pinned=pinned, initial_intersections="ratchet")
    assert scene.touching is not None
    grown = same_with_more_room(request, scene, 1e-2)
    assert {"Detector.put", "Stages.grow"} <= grown


def test_impacts_at_the_start_are_selected_again_with_more_room(request, monkeypatch):
    """Three vertices fall from the surface of faces: floats do not know on which side they are."""
    part, n = vertex_over_face(0.2), 3
    part.positions_t1[3, 2] = -0.2
    part.positions_t0[3, 2] = 5e-324
    shifts = 9.0 * np.arange(n)[:, None, None] * np.array([1.0, 0.0, 0.0])
    start, end = ((own + shifts).reshape(-1, 3) for own in (part.positions_t0, part.positions_t1))
    faces = np.concatenate([part.faces + len(part.masses) * k for k in range(n)])
    scene, at_start = izo_ref.Scene(start, end, faces), []
    found = detect.Detector.found

    def noted(detector, counts, *more):
        at_start.append(counts[places.AT_START])
        return found(detector, counts, *more)

    monkeypatch.setattr(detect.Detector, "found", noted)
    assert "Stages.grow" in same_with_more_room(request, scene, THICKNESS_M)
    assert max(at_start) == n


def run(step):
    """Run the main loop of a step, and return its history."""
    loop = Loop(step, 100)
    assert loop.run(0)
    return loop.history


def same_step(found, expected):
    """Check that two steps on a GPU have the same bits."""
    for name in ("positions", "multipliers", "active", "stuck", "known_depths"):
        assert np.array_equal(to_cpu(getattr(found, name)), to_cpu(getattr(expected, name))), name
    for own, other in zip(found.impacts, expected.impacts, strict=True):
        assert np.array_equal(to_cpu(own), to_cpu(other))
    assert found.objective() == expected.objective()
    assert found.longest[1] == expected.longest[1]
    assert np.array_equal(to_cpu(found.longest[0]), to_cpu(expected.longest[0]))


def test_the_path_that_was_free_the_longest_stays_when_the_ends_change(rng):
    scene = two_sheets(rng, 3)
    step = GpuStep(scene, THICKNESS_M, Options())
    assert step.detect().found > 0
    time_free = float(to_cpu(step.found.toi).min())
    first_new = step.n_impacts
    assert step.select() > 0
    step.solve(first_new)
    assert not np.array_equal(to_cpu(step.positions), scene.positions_t1)
    ends, own_time = step.longest
    assert np.array_equal(to_cpu(ends), scene.positions_t1)
    assert own_time == time_free


def test_impacts_that_the_cpu_decided_are_those_of_one_detection(rng):
    scene = two_sheets(rng, 3)
    step, expected = (GpuStep(scene, THICKNESS_M, Options()) for _ in range(2))
    step.detect()
    first = to_gpu(to_cpu(step.found).take(np.zeros(1, np.int64)))
    step._stages.take_found(Found(first, 0, 1.0, in_place=False))
    assert step.select() == 1
    step.begin_again()
    assert step.detect().found == expected.detect().found > 1
    assert step.select() == expected.select() > 1
    same_step(step, expected)


def state_of(step):
    """Return copies of the state of a step, on the CPU."""
    columns = step.positions, step.stuck, *step.impacts, step.multipliers, step.active
    return [to_cpu(column) for column in columns], step.n_active, step.objective()


def test_a_step_goes_back_to_a_saved_state(rng):
    step = GpuStep(two_sheets(rng, 3), THICKNESS_M, Options())
    states, saved = [], []
    for _ in range(2):
        assert step.detect().found > 0
        first_new = step.n_impacts
        assert step.select() > 0
        step.solve(first_new)
        states.append(state_of(step))
        saved.append(step.save())
    assert states[1][1] > states[0][1], "another number of active impacts"
    step.restore(saved[0])
    (columns, *numbers), (expected, *others) = state_of(step), states[0]
    assert numbers == others
    for own, other in zip(columns, expected, strict=True):
        assert np.array_equal(own, other)


def test_a_step_that_follows_is_the_same_as_a_new_one(rng):
    scene = two_sheets(rng, 3)
    step = GpuStep(scene, THICKNESS_M, Options())
    run(step)
    start, end = to_cpu(step.positions), to_cpu(step.positions)
    end[len(end) // 2 :, 2] -= 0.1
    step.proposed.copy_to_device(end)
    step.go_on(step.positions)
    scene.positions_t0[:], scene.positions_t1[:] = start, end
    expected = GpuStep(scene, THICKNESS_M, Options())
    same_history(run(step), run(expected))
    assert expected.n_impacts > 3
    same_step(step, expected)


def test_a_step_that_follows_finds_the_buffers_that_grew_on_the_way(rng, grown):
    scene = two_sheets(rng, 3)
    ends = scene.positions_t1.copy()
    scene.positions_t1[:] = scene.positions_t0
    step = GpuStep(scene, THICKNESS_M, Options())
    run(step)
    grown.clear()
    on_cpu = step.to_cpu()
    on_cpu.positions = ends
    assert on_cpu.detect().found > 3
    assert "Detector.grow" in grown
    step.proposed.copy_to_device(ends)
    step.go_on(step.positions)
    scene.positions_t1[:] = ends
    expected = GpuStep(scene, THICKNESS_M, Options())
    same_history(run(step), run(expected))
    same_step(step, expected)
