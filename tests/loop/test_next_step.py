"""The next step of a simulation, which starts at the certified end of the last one."""

import dataclasses

import numpy as np
import pytest

import izo_ref
from izo_ref import errors, scene
from tests.helpers.shapes import two_sheets


def same_results(a, b):
    """Require that two results have the same bits."""
    for name in ("positions", "multipliers"):
        assert getattr(a, name).tobytes() == getattr(b, name).tobytes(), name
    for x, y in zip(a.impacts, b.impacts, strict=True):
        assert x.tobytes() == y.tobytes()
    assert a.residuals == b.residuals
    assert a.objective == b.objective
    assert a.certificate.candidates == b.certificate.candidates


def new_scene(result, step):
    """Return the same step as `step`, made anew from the positions of the last result."""
    return izo_ref.Scene(result.positions, step.positions_t1, step.faces, step.masses, step.pinned)


def test_steps_have_the_bits_of_scenes_made_anew(rng, monkeypatch):
    """The sheets slide over each other; the elements are sorted anew every other step."""
    monkeypatch.setattr(scene, "KEPT_STEPS", 2)
    step = two_sheets(rng, 10)
    move = rng.uniform(-0.02, 0.02, step.positions_t0.shape) + (0.03, 0.02, 0.0)
    impacts = 0
    for _ in range(5):
        result = izo_ref.resolve(step, 1e-3)
        step = step.after(result, result.positions + rng.permutation(move))
        assert step.positions_t0.tobytes() == result.positions.tobytes()
        again = new_scene(result, step)
        np.testing.assert_array_equal(step.edges, again.edges)
        same_results(izo_ref.resolve(step, 1e-3), izo_ref.resolve(again, 1e-3))
        impacts += len(result.impacts.toi)
    assert impacts > 50


def test_parts_at_rest_are_left_out_of_the_next_step_too(rng):
    step = two_sheets(rng, 6, pinned_below=True)
    result = izo_ref.resolve(step, 1e-3)
    end = result.positions.copy()
    end[0] += (0.0, 0.0, 1e-3)
    following = step.after(result, end)
    same_results(
        izo_ref.resolve(following, 1e-3), izo_ref.resolve(new_scene(result, following), 1e-3)
    )


def test_the_start_is_not_checked_again(rng, monkeypatch):
    step = two_sheets(rng, 6)
    result = izo_ref.resolve(step, 1e-3)

    def fail(*_):
        raise AssertionError("the start was checked")

    for name in ("find_intersections", "edges_of", "tree_orders"):
        monkeypatch.setattr(scene, name, fail)
    following = step.after(result, step.positions_t1)
    assert following.edges is step.edges
    assert following.tree_orders is step.tree_orders
    assert following.components is step.components
    with pytest.raises(AssertionError):
        new_scene(result, step)


def test_masses_and_pins_are_kept_unless_they_are_given(rng):
    step = two_sheets(rng, 6, pinned_below=True)
    result = izo_ref.resolve(step, 1e-3)
    kept = step.after(result, step.positions_t1)
    np.testing.assert_array_equal(kept.masses, step.masses)
    np.testing.assert_array_equal(kept.pinned, step.pinned)
    n = len(step.masses)
    changed = step.after(result, step.positions_t1, np.full(n, 2.0), np.arange(n) == 3)
    assert (changed.masses == 2.0).all()
    assert np.flatnonzero(changed.pinned).tolist() == [3]
    assert step.pinned.sum() > 1
    assert (result.positions == kept.positions_t0).all()


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"positions_t1": np.zeros((3, 3))}, errors.ShapeError),
        ({"positions_t1": np.full((72, 3), np.nan)}, errors.NonFiniteError),
        ({"masses": np.zeros(72)}, errors.MassError),
        ({"pinned": np.zeros(71, bool)}, errors.ShapeError),
    ],
)
def test_bad_arrays_are_refused(rng, arguments, error):
    step = two_sheets(rng, 6)
    result = izo_ref.resolve(step, 1e-3)
    with pytest.raises(error):
        step.after(result, **{"positions_t1": step.positions_t1, **arguments})


def test_only_the_certified_end_of_this_scene_is_a_start(rng):
    step = two_sheets(rng, 6)
    result = izo_ref.resolve(step, 1e-3)
    end = step.positions_t1

    with pytest.raises(errors.UncertifiedStartError, match=r"result of this scene.* 18 vertices"):
        step.after(izo_ref.resolve(two_sheets(rng, 3), 1e-3), end)
    again = new_scene(result, step)
    with pytest.raises(errors.UncertifiedStartError, match="result of this scene"):
        step.after(izo_ref.resolve(again, 1e-3), end)  # of as many vertices and faces
    with pytest.raises(errors.UncertifiedStartError, match="no certificate"):
        step.after(result.positions, end)

    uncertified = izo_ref.certify_path(step, end)
    assert not uncertified.free
    with pytest.raises(errors.UncertifiedStartError, match="pairs meet, the first at t = 0"):
        step.after(dataclasses.replace(result, positions=end, certificate=uncertified), end)

    with pytest.raises(errors.UncertifiedStartError, match="found others"):
        step.after(dataclasses.replace(result, positions=end), end)
    result.positions[5, 1] += 1e-9
    with pytest.raises(errors.UncertifiedStartError, match="found others"):
        step.after(result, end)
    with pytest.raises(ValueError, match="read-only"):
        result.certificate.positions[5, 1] += 1e-9


def test_a_blocked_result_is_no_start():
    """Two pinned faces go through each other."""
    start = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1.0]])
    end = start[[3, 4, 5, 0, 1, 2]]
    step = izo_ref.Scene(
        start, end, [[0, 1, 2], [3, 4, 5]], pinned=np.ones(6, bool), prescribed="block"
    )
    result = izo_ref.resolve(step, 1e-3)
    assert result.status is izo_ref.Status.BLOCKED
    with pytest.raises(errors.UncertifiedStartError, match="smaller step"):
        step.after(result, end)


def test_a_result_of_the_fail_safe_is_a_start(rng):
    step = two_sheets(rng, 6)
    result = izo_ref.resolve(step, 1e-3, options=izo_ref.Options(max_iterations=1))
    assert result.status is izo_ref.Status.FREE_BY_FALLBACK
    following = step.after(result, step.positions_t1)
    izo_ref.Scene(following.positions_t0, following.positions_t1, step.faces)  # checks the start


def test_pairs_that_still_intersect_are_excluded_again_and_others_are_protected():
    """A triangle that pierces another one moves up a little, then out of it, then back."""
    flat = np.array([[-3, -3, 0], [3, -3, 0], [0, 4, 0]], float)
    start = np.concatenate((flat, [[-0.5, 0, -1], [0.5, 0, -1.1], [0, 0.1, 2]]))
    up = np.where(np.arange(6)[:, None] < 3, 0.0, (0.0, 0.0, 1.0))
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    step = izo_ref.Scene(start, start + 0.5 * up, faces, initial_intersections="exclude")
    crossing = step.excluded.nodes.tolist()

    step = step.after(izo_ref.resolve(step, 1e-3), start + 2.0 * up)
    assert step.excluded.nodes.tolist() == crossing
    step = step.after(izo_ref.resolve(step, 1e-3), start)
    assert step.excluded is None
    result = izo_ref.resolve(step, 1e-3)
    assert len(result.impacts.toi) > 0
    assert step.after(result, start).excluded is None
