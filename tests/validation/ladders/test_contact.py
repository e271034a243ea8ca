"""The quick rungs of the family of contact are right, and so are the answers that it knows."""

import numpy as np
import pytest

from izo_ref import Scene, certify_path, resolve
from tests.helpers.rungs import quick_rungs
from tests.naive.qp import solve_qp
from validation.ladders.contact import LADDERS
from validation.ladders.ladder import RIGHT
from validation.ladders.stacked import moved_centre
from validation.scenes.gadgets import cage, tiles
from validation.scenes.knots import pulled_knot
from validation.scenes.layers import THICKNESS_M, layers, ordered

QUICK = quick_rungs(LADDERS)


@pytest.mark.parametrize(("ladder", "rung"), QUICK)
def test_a_quick_rung_is_right(ladder, rung):
    own, *_ = ladder.run(rung)
    assert own.verdict == RIGHT, own


def order_rows(k, thickness, low, high):
    """State the order of k heights as constraints rows . x >= b on (k, 3) positions."""
    rows, b = [], []
    for i in range(k + 1):
        row = np.zeros((k, 3))
        at = thickness
        if i > 0:
            row[i - 1, 2] = -1.0
        elif np.isfinite(low):
            at += low
        else:
            continue
        if i < k:
            row[i, 2] = 1.0
        elif np.isfinite(high):
            at -= high
        else:
            continue
        rows.append(row.ravel())
        b.append(at)
    return np.array(rows).reshape(-1, 3 * k), np.array(b)


@pytest.mark.parametrize("walls", [(-np.inf, np.inf), (0.0, np.inf), (0.0, 1.0)])
@pytest.mark.parametrize("k", [1, 2, 3, 5])
def test_ordered_heights_are_the_best_of_all_active_sets(rng, k, walls):
    for _ in range(10):
        heights, thickness = rng.normal(size=k), 0.1
        rows, b = order_rows(k, thickness, *walls)
        proposed = np.zeros((k, 3))
        proposed[:, 2] = heights
        expected = solve_qp(rows, b, np.ones(k), proposed) if len(b) else proposed
        np.testing.assert_allclose(
            ordered(heights, thickness, *walls), expected[:, 2], rtol=0.0, atol=1e-12
        )


def test_heights_fit_exactly_if_the_room_is_what_the_thickness_needs():
    assert ordered([5.0, 1.0], 0.25, 0.0, 0.75).tolist() == [0.25, 0.5]
    assert ordered([5.0, 1.0], 0.25, 0.0, np.nextafter(0.75, 0.0)) is None


def test_layers_are_in_order_at_the_start_and_in_columns():
    scene = layers([0.0, -1.0], 3, low=-0.5, high=4.0)
    heights = scene.start[:, 2].reshape(4, 9)
    assert (np.diff(heights, axis=0) > THICKNESS_M).all()
    assert (np.ptp(scene.start.reshape(4, 9, 3)[:, :, :2], axis=0) == 0.0).all()
    assert scene.pinned.reshape(4, 9).all(axis=1).tolist() == [True, False, False, True]
    assert np.array_equal(scene.best[scene.pinned], scene.end[scene.pinned])
    assert certify_path(Scene(*scene[:3]), scene.best).free


def test_the_vertex_of_a_cage_ends_in_the_corner_that_the_thickness_leaves():
    scene = cage(0.5, (3.0, 2.0, 0.25))
    assert scene.best[8].tolist() == [0.5 - THICKNESS_M, 0.5 - THICKNESS_M, 0.25]
    assert not certify_path(Scene(*scene[:3]), scene.end).free
    assert certify_path(Scene(*scene[:3]), scene.best).free


def test_tiles_are_far_from_each_other():
    scene = tiles(5)
    assert len(scene.faces) == 5
    corners = scene.start.reshape(5, 4, 3)
    apart = np.linalg.norm(corners[:, None, 3] - corners[None, :, 3], axis=2)
    assert (apart + 9.0 * np.eye(5)).min() >= 2.0


@pytest.mark.parametrize("n_rings", [15, 40])
def test_a_knot_starts_free_and_cannot_become_straight(n_rings):
    start, end, faces = pulled_knot(n_rings, 1.0)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    assert len(start) - len(edges) + len(faces) == 0  # Euler: a tube with two open ends
    assert not certify_path(Scene(start, end, faces), end).free
    assert pulled_knot(n_rings, 0.0)[1].tobytes() == start.tobytes()


def test_a_moved_centre_of_mass_is_noticed():
    scene = layers([0.0625, 0.0], 2)
    result = resolve(Scene(*scene[:3]), THICKNESS_M)
    assert moved_centre(result) == ""
    object.__setattr__(result, "positions", result.positions + (0.0, 0.0, 1e-6))
    assert "centre of mass" in moved_centre(result)
