"""Scaling back: the fallback for pairs that still meet when the loop ends."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Options, Status
from tests.helpers.shapes import pinched_sheet, two_sheets


def test_a_sheet_that_does_not_fit_falls_back_or_is_blocked():
    """The sheet needs a thickness on both sides, and the pinned sheets leave less."""
    scene = pinched_sheet(0.01, bump=0.2)
    result = izo_ref.resolve(scene, thickness=0.02)
    assert result.status in (Status.FREE_BY_FALLBACK, Status.BLOCKED)
    assert result.certificate.free is (result.status is Status.FREE_BY_FALLBACK)
    assert not result.converged
    np.testing.assert_array_equal(result.positions[scene.pinned], scene.positions_t1[scene.pinned])


@pytest.mark.parametrize("budget", [0, 1, 2])
def test_a_spent_budget_ends_free_by_fallback(rng, budget):
    scene = two_sheets(rng, 12)
    result = izo_ref.resolve(scene, 1e-3, options=Options(max_iterations=budget))
    assert result.status is Status.FREE_BY_FALLBACK
    assert result.certificate.free
    assert not result.converged
    assert result.scaled_back
    assert all(0.0 <= part.scale < 1.0 for part in result.scaled_back)
    for part in result.scaled_back:
        assert len(part.vertices)
        assert not scene.pinned[part.vertices].any()


def test_scaled_back_vertices_stop_at_the_reported_share_of_their_path(rng):
    scene = two_sheets(rng, 8)
    result = izo_ref.resolve(scene, 1e-3, options=izo_ref.Options(max_iterations=0))
    assert min(part.scale for part in result.scaled_back) < 0.5  # more than one round
    for part in result.scaled_back:
        start, end = scene.positions_t0[part.vertices], scene.positions_t1[part.vertices]
        expected = start + part.scale * (end - start)
        np.testing.assert_allclose(result.positions[part.vertices], expected, rtol=0.0, atol=1e-15)
