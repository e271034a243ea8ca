"""Proposed positions that are free are the answer, also where floats cannot tell."""

from importlib import import_module

import numpy as np
import pytest

import izo_ref
from izo_ref.base.options import Options
from tests.helpers.shapes import grid

FACE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])


def above_a_face(gap, at=(0.2, 0.3), scale=1.0):
    """Return positions and faces of a vertex that is above a face by `gap` [m]."""
    return np.concatenate((scale * FACE, [[scale * at[0], scale * at[1], gap]])), [[0, 1, 2]]


def assert_is_the_proposal(scene):
    result = izo_ref.resolve(scene, 1e-4)
    assert result.status is izo_ref.Status.FREE
    assert result.certificate.free
    np.testing.assert_array_equal(result.positions, scene.positions_t1)
    assert result.objective == 0.0
    assert len(result.impacts.toi) == 0
    assert len(result.history) == 1


@pytest.mark.parametrize("gap", [1e-12, 1e-15, 1e-17, 1e-300, 5e-324])
def test_a_vertex_nearer_than_rounding_moves_with_its_face(gap):
    start, faces = above_a_face(gap)
    assert_is_the_proposal(izo_ref.Scene(start, start + (1.0, 2.0, 0.0), faces))


@pytest.mark.parametrize("rise", [5e-324, 1e-9, 1.0])
def test_a_sheet_lifts_off_a_pinned_table(rise):
    sheet, faces = grid(4)
    start = np.concatenate((sheet * (4.0, 4.0, 0.0) - (1.0, 1.0, 0.0), sheet + (0.0, 0.0, 4e-15)))
    end = start.copy()
    end[16:, 2] += rise
    pinned = np.arange(32) < 16
    faces = np.concatenate((faces, faces + 16))
    assert_is_the_proposal(izo_ref.Scene(start, end, faces, pinned=pinned))


def test_pinned_parts_that_start_nearer_than_rounding_do_not_block():
    start, faces = above_a_face(1e-17)
    end = start.copy()
    end[3, 2] = 0.5
    assert_is_the_proposal(izo_ref.Scene(start, end, faces, pinned=[1, 1, 1, 1]))


def test_a_vertex_thrown_far_away_leaves_a_free_scene_free():
    start, faces = above_a_face(1e-6)
    start = np.concatenate((start, start + (5.0, 0.0, 0.0)))
    end = start.copy()
    end[3] = (1e11, 2e11, 3e11)
    scene = izo_ref.Scene(start, end, [*faces, [4, 5, 6]])
    assert izo_ref.certify_path(scene, end).free
    assert_is_the_proposal(scene)


def test_free_proposals_at_random_are_the_answer_and_others_are_resolved(rng):
    free = 0
    for _ in range(60):
        gap = 10.0 ** rng.uniform(-17, -13)
        start, faces = above_a_face(gap, rng.uniform(0.1, 0.4, 2), 10.0 ** rng.uniform(-3, 3))
        start = start @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
        try:
            scene = izo_ref.Scene(start, start + rng.normal(size=3), faces)
        except izo_ref.errors.InitialIntersectionError:
            continue  # turning took the gap away
        if izo_ref.certify_path(scene, scene.positions_t1).free:
            free += 1
            assert_is_the_proposal(scene)
        else:
            result = izo_ref.resolve(scene, 1e-4, options=Options(max_iterations=5))
            assert result.certificate.free
    assert free > 10


def test_one_impact_that_is_real_is_resolved_beside_a_doubtful_one():
    start, faces = above_a_face(1e-15)
    start = np.concatenate((start, start + (5.0, 0.0, 0.0)))
    start[7, 2] = 1.0
    end = start + (0.5, 0.0, 0.0)
    end[7, 2] = -1.0
    scene = izo_ref.Scene(start, end, [*faces, [4, 5, 6]])
    result = izo_ref.resolve(scene, 1e-4)
    assert result.certificate.free
    assert result.objective > 0.0


def test_layers_that_meet_vertex_on_vertex_are_not_certified_in_full(monkeypatch):
    """Floats cannot tell there; exact arithmetic is asked about one impact, not about all pairs."""
    sheet, faces = grid(4)
    start = np.concatenate((sheet, sheet + (0.0, 0.0, 0.1)))
    end = start.copy()
    end[16:, 2] -= 0.2
    asked = []
    module = import_module("izo_ref.loop.iterate")
    monkeypatch.setattr(module, "certify_in_time", lambda *_args: asked.append(1))
    result = izo_ref.resolve(izo_ref.Scene(start, end, np.concatenate((faces, faces + 16))), 1e-4)
    assert result.status is izo_ref.Status.FREE
    assert result.objective > 0.0
    assert asked == []


@pytest.mark.parametrize("gap", [1e-9, 1e-12, 1e-15, 1e-16, 1e-30, 1e-300, 5e-324])
@pytest.mark.parametrize("slide", [0.0, 0.3])
def test_a_vertex_pressed_from_nearer_than_rounding_is_solved(gap, slide):
    """It ends at the thickness above the pinned face; the normal is exact and of unit length."""
    start, faces = above_a_face(gap)
    end = start.copy()
    end[3] += (slide, 0.0, -0.1)
    scene = izo_ref.Scene(start, end, faces, pinned=[1, 1, 1, 0])
    result = izo_ref.resolve(scene, 1e-3)
    assert result.status is izo_ref.Status.FREE
    assert result.objective == pytest.approx((0.1 + 1e-3) ** 2, rel=1e-5)
    np.testing.assert_allclose(np.linalg.norm(result.impacts.normals, axis=1), 1.0)
    assert len(result.impacts.toi) == 1
    assert len(result.history) < 6


@pytest.mark.parametrize("gap", [1e-12, 1e-15, 1e-30, 5e-324])
def test_an_edge_pressed_from_nearer_than_rounding_is_solved(gap):
    start = [[-1, 0, gap], [1, 0, gap], [0, 0, 1], [0, -1, 0], [0, 1, 0], [0, 0, -1]]
    end = np.array(start, float) - (np.arange(6)[:, None] < 3) * (0.0, 0.0, 0.1)
    scene = izo_ref.Scene(start, end, [[0, 1, 2], [3, 4, 5]], pinned=[0, 0, 0, 1, 1, 1])
    result = izo_ref.resolve(scene, 1e-3)
    assert result.status is izo_ref.Status.FREE
    assert result.objective == pytest.approx(2.0 / 3.0 * (0.1 + 1e-3) ** 2, rel=1e-5)


def test_a_doubtful_pair_is_no_impact_beside_a_real_one():
    """One vertex starts 1e-15 m above its face and lifts off; another one goes through its face."""
    start, faces = above_a_face(1e-15)
    start = np.concatenate((start, start + (5.0, 0.0, 0.0)))
    start[7, 2] = 0.1
    end = start.copy()
    end[3, 2], end[7, 2] = 0.5, -0.1
    pinned = [1, 1, 1, 0, 1, 1, 1, 0]
    scene = izo_ref.Scene(start, end, [*faces, [4, 5, 6]], pinned=pinned)
    assert izo_ref.find_impacts(scene).nodes.tolist() == [[7, 4, 5, 6]]
    result = izo_ref.resolve(scene, 1e-3)
    assert result.status is izo_ref.Status.FREE
    np.testing.assert_array_equal(result.positions[3], end[3])
