"""Scenes of deep contact: free at the start, of the size asked for, and in contact at the end."""

import numpy as np
import pytest

from izo_ref import certify_path
from validation.scenes.balls import BALL_FACES, RADIUS_M, pressed_balls
from validation.scenes.garments import garment

SMALL = {
    "balls": lambda rng: pressed_balls(rng, 9),
    "garment": lambda rng: garment(rng, 3_000),
}


@pytest.mark.parametrize("family", SMALL)
def test_a_deep_scene_is_free_at_the_start_only(rng, family):
    """Making the scene checks the start exactly."""
    scene = SMALL[family](rng)
    assert not certify_path(scene, scene.positions_t1).free
    assert certify_path(scene, scene.positions_t0).free


@pytest.mark.parametrize("family", SMALL)
def test_a_deep_scene_is_the_same_for_a_seed(family):
    one, two = (SMALL[family](np.random.default_rng(7)) for _ in range(2))
    for name in ("positions_t0", "positions_t1", "faces", "masses", "pinned"):
        assert np.array_equal(getattr(one, name), getattr(two, name))


def test_balls_are_closed_and_keep_their_shape(rng):
    scene = pressed_balls(rng, 9)
    assert len(scene.faces) == 9 * BALL_FACES
    assert len(scene.pinned) - len(scene.edges) + len(scene.faces) == 9 * 2  # Euler: 2 for each
    assert not scene.pinned.any()
    balls = scene.positions_t0.reshape(9, -1, 3)
    assert np.ptp(balls, axis=1).max() <= 2.0 * RADIUS_M
    lengths = [
        np.linalg.norm(np.diff(positions[scene.edges], axis=1), axis=2)
        for positions in (scene.positions_t0, scene.positions_t1)
    ]
    np.testing.assert_allclose(*lengths, rtol=1e-9)


@pytest.mark.parametrize("n_triangles", [5_000, 20_000])
def test_a_garment_has_the_size_that_was_asked_for(rng, n_triangles):
    scene = garment(rng, n_triangles)
    assert abs(len(scene.faces) / n_triangles - 1.0) < 0.05
    assert np.unique(scene.components.component).size == 6  # the body and five layers
    assert 0.1 < scene.pinned.mean() < 0.25
    assert np.array_equal(scene.positions_t0[scene.pinned], scene.positions_t1[scene.pinned])


def test_the_layers_of_a_garment_pass_through_one_another(rng):
    """At the start each layer is outside the one below; at the end about half of it is not."""
    scene = garment(rng, 3_000)
    layers = scene.components.component[~scene.pinned].reshape(5, -1)
    assert all(len(np.unique(layer)) == 1 for layer in layers)
    radius = np.hypot(*scene.positions_t1[~scene.pinned, :2].T).reshape(5, -1)
    assert (np.diff(radius, axis=0) < 0.0).mean() > 0.3
