"""Scaling back: the fallback for pairs that still meet when the loop ends."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Options, Status
from izo_ref.loop.scale_back import _lower_scales
from tests.helpers.shapes import pinched_sheet, two_sheets


@pytest.mark.parametrize("room", [0.01, 1e-4, 1e-9])
def test_a_sheet_without_room_for_the_thickness_keeps_less_of_it(room):
    """The sheet is to go through the upper pinned sheet, and the room is below the thickness."""
    scene = pinched_sheet(room, bump=0.2)
    result = izo_ref.resolve(scene, thickness=0.02)
    assert result.status is Status.FREE_BY_FALLBACK
    assert result.certificate.free
    assert not result.converged
    np.testing.assert_array_equal(result.positions[scene.pinned], scene.positions_t1[scene.pinned])
    between = result.positions[~scene.pinned, 2]
    assert (np.abs(between) < 0.5 * room).all()


def test_what_has_room_keeps_the_thickness_where_other_vertices_have_none():
    """Two sheets far from a pinched one end where they end without it."""
    pinched, beside = pinched_sheet(0.01, bump=0.2), two_sheets(np.random.default_rng(3), 6)
    n = len(pinched.pinned)
    scene = izo_ref.Scene(
        np.concatenate((pinched.positions_t0, beside.positions_t0 + (50.0, 0.0, 0.0))),
        np.concatenate((pinched.positions_t1, beside.positions_t1 + (50.0, 0.0, 0.0))),
        np.concatenate((pinched.faces, beside.faces + n)),
        pinned=np.concatenate((pinched.pinned, beside.pinned)),
    )
    result = izo_ref.resolve(scene, 0.02)
    assert result.status is Status.FREE_BY_FALLBACK
    statuses = {
        status: {bool(v >= n) for zone in own for v in result.zones.vertices_of(zone)}
        for status, own in _by_status(result).items()
    }
    assert statuses == {Status.FREE_BY_FALLBACK: {False}, Status.FREE: {True}}


def _by_status(result):
    zones = {}
    for zone, status in enumerate(result.zone_statuses):
        zones.setdefault(status, []).append(zone)
    return zones


def test_a_sheet_without_any_room_is_blocked():
    result = izo_ref.resolve(pinched_sheet(0.0, bump=0.2), 0.02)
    assert result.status is Status.BLOCKED


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


class Groups(list):
    """Groups of vertices, as zones have them."""

    def vertices_of(self, group):
        return self[group]


def test_groups_in_trouble_halve_their_scale_six_times_and_then_stay_at_the_start():
    groups = Groups([np.array([0, 2]), np.array([1]), np.array([3, 4])])
    scale = np.array([1.0, 1.0, 0.5, 0.0, 0.0])  # the vertices of the first group come together
    trouble = np.array([True, False, False, True, False])
    for expected in (0.25, 0.125, 1 / 16, 1 / 32, 1 / 64, 0.0):
        assert _lower_scales(groups, trouble, scale, True)
        np.testing.assert_array_equal(scale, [expected, 1.0, expected, 0.0, 0.0])
    assert not _lower_scales(groups, trouble, scale, True)
    scale = np.array([1.0, 1.0, 0.0, 1.0, 0.0])
    assert _lower_scales(groups, trouble, scale, True)
    np.testing.assert_array_equal(scale, [0.0, 1.0, 0.0, 0.0, 0.0])
    assert not _lower_scales(groups, np.zeros(5, bool), np.ones(5), True)
