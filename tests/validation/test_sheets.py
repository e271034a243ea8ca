"""Sheets of any size that meet in a small part of their vertices."""

import numpy as np
import pytest

from izo_ref import resolve
from validation.scenes.sheets import CELL_M, MEETING, meeting_sheets


@pytest.mark.parametrize("n_triangles", [1_000, 10_000, 100_000])
def test_sheets_meet_in_a_hundredth_of_their_vertices(rng, n_triangles):
    scene = meeting_sheets(rng, n_triangles)
    assert abs(len(scene.faces) / n_triangles - 1.0) < 0.05
    half = len(scene.pinned) // 2
    low = scene.positions_t1[half:, 2] < scene.positions_t1[:half, 2].mean()
    assert 0.4 * MEETING < low.mean() / 2.0 < 1.6 * MEETING
    lengths = np.ptp(scene.positions_t0[:half], axis=0)[:2]
    assert np.allclose(lengths, CELL_M * (np.sqrt(half) - 1.0), rtol=0.1)


def test_sheets_are_the_same_for_a_seed():
    one, two = (meeting_sheets(np.random.default_rng(7), 2_000) for _ in range(2))
    assert np.array_equal(one.positions_t1, two.positions_t1)
    assert np.array_equal(one.positions_t0, two.positions_t0)


def test_meeting_sheets_are_resolved_free(rng):
    result = resolve(meeting_sheets(rng, 1_000), 1e-4)
    assert result.status.name == "FREE"
    assert len(result.impacts.toi) > 0
