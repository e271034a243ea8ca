"""A whole step on the GPU, compared with one on the CPU."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Options, Status
from izo_ref.base import devices
from izo_ref.base.options import LAGRANGIAN
from izo_ref.loop import gpu_zones
from izo_ref.solvers import gpu_augmented_lagrangian as lagrangian
from izo_ref.solvers import gpu_pivoting as pivoting
from izo_ref.solvers import gpu_solve as solve
from izo_ref.solvers.presets import PRESETS
from izo_ref.solvers.solve import solve_system
from tests.helpers.listed import leave_larger_zones
from tests.helpers.same import same_result
from tests.helpers.shapes import falling_sheet, pinched_sheet, two_sheets, vertex_over_face

UPDATES = ("every-step", "inner-solve")
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


def small_pinched_sheet(end_gap):
    """Return a pinched sheet of four vertices."""
    return pinched_sheet(end_gap, bump=0.2, side=2)


def scenes(rng):
    """Return small scenes by name; nothing moves in the last one."""
    apart = two_sheets(rng, 2)
    apart.positions_t1[:] = apart.positions_t0
    return {
        "face": vertex_over_face(),
        "sheets": two_sheets(rng, 3),
        "pinned": two_sheets(rng, 3, pinned_below=True),
        "fits": small_pinched_sheet(0.05),
        "apart": apart,
    }


def same_as_on_cpu(found, expected):
    """Check that two results have the same bits, except for the objectives of the history."""
    same_result(found, expected)
    assert found.certificate.candidates == expected.certificate.candidates
    for count in ("proofs", "most_proofs"):  # a GPU proves most pairs in float32 before
        assert getattr(found.certificate, count) <= getattr(expected.certificate, count)
    assert found.certificate.free == expected.certificate.free
    assert len(found.history) == len(expected.history)
    for own, other in zip(found.history, expected.history, strict=True):
        assert own[:3] == other[:3]
        assert own[4:9] == other[4:9]
        # The GPU sums in another order n terms that are not negative.
        assert own.objective == pytest.approx(other.objective, rel=1e-13)
    if found.history[0].round == 0:  # later detections on the CPU skip what did not move
        assert found.history[0].candidates == expected.history[0].candidates


def test_a_deep_step_ends_as_on_the_cpu():
    scene = falling_sheet(3, 20.0, n=2)
    expected = izo_ref.resolve(scene, 1e-3)
    assert expected.status is Status.FREE
    found = izo_ref.resolve(scene, 1e-3, device="cuda")
    same_as_on_cpu(found, expected)
    assert [line.added for line in found.history if line.round == 0] == [4, 4, 0]


@pytest.mark.parametrize("name", ["face", "sheets", "pinned", "fits", "apart"])
def test_a_step_ends_as_on_the_cpu(rng, name):
    scene = scenes(rng)[name]
    expected = izo_ref.resolve(scene, 1e-3)
    assert expected.status is Status.FREE
    assert (len(expected.impacts.toi) > 0) == (name != "apart")
    same_as_on_cpu(izo_ref.resolve(scene, 1e-3, device="cuda"), expected)


@pytest.mark.parametrize("selection", ["first-of-any", "all"])
def test_every_selection_ends_as_on_the_cpu(rng, selection):
    scene, options = two_sheets(rng, 2), Options(selection=selection)
    expected = izo_ref.resolve(scene, 1e-3, options=options)
    same_as_on_cpu(izo_ref.resolve(scene, 1e-3, "cuda", options), expected)


@pytest.mark.parametrize("plan", ["everything", ("incremental",)])
def test_plans_with_fewer_rules_end_as_on_the_cpu(rng, plan):
    scene, options = two_sheets(rng, 2), Options(plan=plan)
    expected = izo_ref.resolve(scene, 1e-3, options=options)
    found = izo_ref.resolve(scene, 1e-3, "cuda", options)
    assert np.array_equal(found.positions, expected.positions)
    assert [i.solved for i in found.history] == [i.solved for i in expected.history]


def test_a_sheet_that_does_not_fit_ends_as_on_the_cpu(rng):
    scene = small_pinched_sheet(0.01)
    expected = izo_ref.resolve(scene, 0.02)
    assert expected.status is not Status.FREE
    same_as_on_cpu(izo_ref.resolve(scene, 0.02, "cuda"), expected)


def test_pinned_sheets_that_meet_are_blocked_as_on_the_cpu(rng):
    scene = small_pinched_sheet(-0.05)
    expected = izo_ref.resolve(scene, 1e-3)
    assert expected.status is Status.BLOCKED
    found = izo_ref.resolve(scene, 1e-3, "cuda")
    same_as_on_cpu(found, expected)
    assert found.time_free == expected.time_free


@pytest.mark.parametrize("enough", [True, False])
def test_auto_takes_a_gpu_for_large_scenes_alone(rng, monkeypatch, enough):
    scene = two_sheets(rng, 2)
    monkeypatch.setattr(devices, "GPU_FACES", len(scene.faces) + (not enough))
    line = {line.stage: line for line in izo_ref.plan(scene).lines}["a GPU"]
    assert line.needed == ("all" if enough else "none")
    found = izo_ref.resolve(scene, 1e-3, "auto")
    assert (found.positions_on_gpu is not None) == enough
    same_as_on_cpu(found, izo_ref.resolve(scene, 1e-3))
    assert izo_ref.certify_path(scene, found.positions, device="auto").free
    assert len(izo_ref.find_impacts(scene, "auto").toi) > 0


def test_a_spent_budget_ends_as_on_the_cpu(rng):
    scene, options = two_sheets(rng, 2), Options(max_iterations=1)
    expected = izo_ref.resolve(scene, 1e-3, options=options)
    assert expected.scaled_back
    same_as_on_cpu(izo_ref.resolve(scene, 1e-3, "cuda", options), expected)


@pytest.mark.parametrize("largest", [1, 512])
def test_zones_that_the_gpu_does_not_solve_are_left_to_the_cpu(rng, monkeypatch, largest):
    """There is no room for any factor."""
    monkeypatch.setattr(solve, "SMALL", 1)
    monkeypatch.setattr(pivoting, "THREADS", 3)
    monkeypatch.setattr(pivoting, "LARGEST", largest)
    leave_larger_zones(monkeypatch, pivoting)
    scene = two_sheets(rng, 3)
    expected = izo_ref.resolve(scene, 1e-3)
    found = izo_ref.resolve(scene, 1e-3, "cuda")
    same_as_on_cpu(found, expected)
    assert found.left_to_cpu > 0
    assert expected.left_to_cpu == 0


def test_zones_that_are_left_start_from_their_last_solution(rng, monkeypatch):
    monkeypatch.setattr(solve, "SMALL", 1)
    monkeypatch.setattr(pivoting, "LARGEST", 1)
    leave_larger_zones(monkeypatch, pivoting)
    scene, starts = two_sheets(rng, 3), []

    def noted(system, options, **more):
        starts.append(more["start"])
        return solve_system(system, options, **more)

    monkeypatch.setattr(gpu_zones, "solve_system", noted)
    options = Options(relinearize=0)
    found = izo_ref.resolve(scene, 1e-3, "cuda", options)
    assert found.left_to_cpu >= len(starts) > 1
    assert max(start.max() for start in starts) > 0.0
    assert min(start.min() for start in starts) == 0.0


@pytest.mark.parametrize("largest", [1, 512])
@pytest.mark.parametrize("name", ["sheets", "pinned"])
def test_zones_of_one_block_and_of_all_blocks_end_near_the_cpu(rng, monkeypatch, name, largest):
    monkeypatch.setattr(solve, "SMALL", 1)
    monkeypatch.setattr(pivoting, "LARGEST", largest)
    monkeypatch.setattr(pivoting, "THREADS", 3)
    scene, options = scenes(rng)[name], Options(relinearize=0)
    expected = izo_ref.resolve(scene, 1e-3, options=options)
    found = izo_ref.resolve(scene, 1e-3, "cuda", options)
    assert found.left_to_cpu == 0
    assert found.status is Status.FREE
    for own, other in zip(found.impacts[:2], expected.impacts[:2], strict=True):
        assert np.array_equal(own, other)
    # Both have a gap of at most 1e-9, so each is within sqrt(2e-9) of the distance to the optimum.
    offsets = [r.positions - scene.positions_t1 for r in (found, expected)]
    size = np.sqrt((scene.masses[:, None] * offsets[1] ** 2).sum())
    apart = np.sqrt((scene.masses[:, None] * (offsets[0] - offsets[1]) ** 2).sum())
    assert 0.0 < apart <= 2.0 * np.sqrt(2e-9) * size


METHODS = [
    *({"method": m, "multiplier_update": u} for m in LAGRANGIAN for u in UPDATES),
    *({"preset": preset} for preset in PRESETS),
]


@pytest.mark.parametrize("named", METHODS, ids=lambda named: "-".join(named.values()))
def test_each_method_takes_the_steps_of_the_cpu(rng, monkeypatch, named):
    monkeypatch.setattr(lagrangian, "FEW", 3)
    monkeypatch.setattr(lagrangian, "MANY", 3)
    scene = two_sheets(rng, 2, pinned_below=True)
    scene.masses[:] = rng.uniform(1.0, 9.0, len(scene.masses))
    # So few steps that roundings neither grow nor decide when a zone is done.
    options = Options(**named, max_steps=6, relinearize=0)
    expected = izo_ref.resolve(scene, 1e-3, options=options)
    found = izo_ref.resolve(scene, 1e-3, "cuda", options)
    assert found.left_to_cpu == 0
    assert found.status is expected.status
    assert len(found.history) == len(expected.history) > 1
    size = np.abs(expected.positions - scene.positions_t1).max()
    np.testing.assert_allclose(found.positions, expected.positions, rtol=0.0, atol=1e-11 * size)
    largest = expected.multipliers.max()
    np.testing.assert_allclose(
        found.multipliers, expected.multipliers, rtol=0.0, atol=1e-11 * largest
    )


@pytest.mark.parametrize("method", LAGRANGIAN)
def test_each_method_converges_on_the_gpu(rng, monkeypatch, method):
    monkeypatch.setattr(lagrangian, "FEW", 1)
    monkeypatch.setattr(lagrangian, "MANY", 1)
    options = Options(method=method, gap_tolerance=1e-5, violation_tolerance=1e-5, relinearize=0)
    found = izo_ref.resolve(two_sheets(rng, 2), 1e-3, "cuda", options)
    assert found.left_to_cpu == 0
    assert found.status is Status.FREE


def test_float32_zones_end_as_on_the_cpu(monkeypatch):
    monkeypatch.setattr(lagrangian, "FEW", 1)
    monkeypatch.setattr(lagrangian, "MANY", 1)
    # a round starts from multipliers in float32, which differ in their last digits
    scene, options = vertex_over_face(), Options(method="cg", precision="float32", relinearize=0)
    found = izo_ref.resolve(scene, 1e-3, "cuda", options)
    same_as_on_cpu(found, izo_ref.resolve(scene, 1e-3, options=options))
    assert found.left_to_cpu == 0


def test_methods_of_the_cpu_alone_have_all_zones_left_to_the_cpu():
    scene, options = vertex_over_face(), Options(method="interior-point", relinearize=0)
    found = izo_ref.resolve(scene, 1e-3, "cuda", options)
    same_as_on_cpu(found, izo_ref.resolve(scene, 1e-3, options=options))
    assert found.left_to_cpu > 0


def test_a_free_proposal_is_the_answer_where_floats_cannot_tell():
    start = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.3, 1e-17]])
    scene = izo_ref.Scene(start, start + (1.0, 2.0, 0.0), [[0, 1, 2]])
    result = izo_ref.resolve(scene, 1e-4, device="cuda")
    assert result.status is izo_ref.Status.FREE
    np.testing.assert_array_equal(result.positions, scene.positions_t1)
    assert len(result.history) == 1
