"""The problem of one zone, and the residuals that judge an answer to it."""

import math

import numpy as np
import pytest

import izo_ref
from izo_ref.base import errors
from izo_ref.zones.residuals import residuals_of_zones
from izo_ref.zones.system import ZoneSystem, zone_system
from tests.helpers.shapes import ONE_IMPACT, one_impact_problem, random_problem, two_sheets
from tests.naive.qp import dense_rows


@pytest.mark.parametrize(
    ("changes", "error", "word"),
    [
        ({"nodes": [[0, 1, 2, 4]]}, errors.IndexRangeError, "row 0"),
        ({"nodes": [[0, 1, 2]]}, errors.ShapeError, "nodes"),
        ({"weights": [[1.0, -1.0, 0.0]]}, errors.ShapeError, "weights"),
        ({"normals": [[0.0, 0.0, np.nan]]}, errors.NonFiniteError, "normals"),
        ({"proposed": np.zeros((4, 2))}, errors.ShapeError, "proposed"),
        ({"masses": [1, 1, 1, 0]}, errors.MassError, "vertex 3"),
        ({"masses": [1, 1, np.nan, 1]}, errors.MassError, "vertex 2"),
        ({"thickness": 0.0}, errors.ThicknessError, "0.0"),
        ({"thickness": "thin"}, errors.ThicknessError, "thin"),
        ({"thickness": math.inf}, errors.ThicknessError, "inf"),
    ],
)
def test_bad_input_is_refused_and_named(changes, error, word):
    with pytest.raises(error, match=word):
        one_impact_problem(**changes)


def test_residuals_are_those_worked_out_by_hand():
    """For this impact, r = d - gap = 1.5 and K = sum a^2 / m = 1 + 1/4 + 1/32 + 1/64."""
    one = one_impact_problem()
    k = 1.0 + 0.25 + 0.0625 / 2 + 0.0625 / 4
    multiplier = 1.5 / k
    x = one.proposed.copy()
    x[:, 2] += multiplier * one.weights[0] / one.masses
    found = izo_ref.residuals(one, x, np.array([multiplier]))
    assert max(found[:6]) < 1e-14

    short = izo_ref.residuals(one, one.proposed, np.array([0.0]))
    assert short.violation_m == 1.5
    assert short.violation == 3.0
    assert short.gap == 0.0  # nothing moves and nothing pushes, so only the violation shows it

    half = izo_ref.residuals(one, one.proposed, np.array([multiplier]))
    assert half.gap == math.inf

    negative = izo_ref.residuals(one, x, np.array([-multiplier]))
    assert negative.dual_violation == 1.0
    assert negative.stationarity == pytest.approx(1.0)


def test_the_gap_is_primal_less_dual(rng):
    for _ in range(20):
        zone = random_problem(rng, 5)
        rows = dense_rows(zone.nodes, zone.weights, zone.normals, len(zone.proposed))
        inverse = np.repeat(1.0 / zone.masses, 3)
        # Any feasible point and any multipliers have this gap.
        x = zone.proposed.ravel() + 0.1 * rng.normal(size=rows.shape[1])
        lift = np.linalg.lstsq(rows, np.maximum(zone.thickness - rows @ x, 0.0) + 0.01, rcond=None)
        x = x + lift[0]
        if (rows @ x < zone.thickness).any():
            continue
        multipliers = rng.random(5)
        offset = x - zone.proposed.ravel()
        primal = 0.5 * np.sum(offset**2 / inverse)
        reach = zone.thickness - rows @ zone.proposed.ravel()
        dual = multipliers @ reach - 0.5 * np.sum(inverse * (rows.T @ multipliers) ** 2)
        found = izo_ref.residuals(zone, x.reshape(-1, 3), multipliers)
        assert found.gap == pytest.approx((primal - dual) / primal, rel=1e-9)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_positions_that_are_not_finite_have_infinite_residuals(bad):
    x = np.array(ONE_IMPACT["proposed"])
    x[0, 0] = bad
    found = izo_ref.residuals(one_impact_problem(), x, np.zeros(1))
    assert set(found[:6]) == {math.inf}
    assert not found.solved(1e-9, 1e-9)


def test_pinned_vertices_are_no_unknowns():
    one = one_impact_problem(masses=[1.0, np.inf, np.inf, np.inf])
    x = one.proposed.copy()
    x[0, 2] = 0.5
    found = izo_ref.residuals(one, x, np.array([1.5]))
    assert max(found[:6]) < 1e-14


def test_a_violation_does_not_hide_a_gap():
    """Of two constraints, one is violated by 1/2 and one open by 1/2; signed products cancel."""
    zone = izo_ref.ZoneProblem(
        [[0, 1, 2, 3], [4, 1, 2, 3]],
        [[1.0, -0.5, -0.25, -0.25]] * 2,
        [[0.0, 0.0, 1.0]] * 2,
        [[0, 0, 0.0], [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.0]],
        [1.0, np.inf, np.inf, np.inf, 1.0],
        1.0,
    )
    positions = zone.proposed.copy()
    positions[[0, 4], 2] = 0.5, 1.5
    found = izo_ref.residuals(zone, positions, np.array([1.0, 1.0]))
    primal = 0.5 * (0.5**2 + 1.5**2)
    assert found.complementarity == pytest.approx((0.5 + 0.5) / primal)
    # The moves are 1/2 and 3/2 where the multipliers ask for 1 each: 1/2 (1/4 + 1/4) more.
    assert found.gap == pytest.approx((0.25 + 0.5 + 0.5) / primal)


def test_zones_side_by_side_are_judged_as_on_their_own(rng):
    """One zone has no numbers; the zones share pinned vertices, which come last."""
    scene = two_sheets(rng, 10, pinned_below=True)
    impacts = izo_ref.find_impacts(scene)
    impacts = impacts.take(rng.permutation(len(impacts.toi))[:20])
    zones = izo_ref.build_zones(scene, impacts)
    system = zone_system(scene, impacts, zones, 1e-3)
    positions = system.proposed + 1e-3 * rng.normal(size=system.proposed.shape)
    positions[np.isinf(system.masses)] = system.proposed[np.isinf(system.masses)]
    positions[system.vertex_offsets[1]] = np.nan  # of the second zone
    multipliers = rng.normal(size=len(system.nodes))
    judged = residuals_of_zones(system, positions, multipliers)
    assert len(judged) == len(zones) > 2
    for zone, found in enumerate(judged):
        own = slice(*system.impact_offsets[zone : zone + 2])
        problem = izo_ref.zone_problem(scene, impacts, zones, zone, 1e-3)
        x = np.empty_like(problem.proposed)
        x[problem.nodes] = positions[system.nodes[own]]
        expected = izo_ref.residuals(problem, x, multipliers[own])
        # the vertices come in another order, so sums of n positive terms differ by n roundings
        np.testing.assert_allclose(found, expected, rtol=2.0**-52 * 3 * len(x))
    assert judged[1].gap == math.inf
    assert judged[0].gap < math.inf


def test_zones_are_judged_where_there_are_none():
    nowhere, start = np.empty((0, 3)), np.zeros(1, int)
    nothing = np.empty((0, 4), np.int32), np.empty((0, 4)), nowhere, nowhere, np.empty(0)
    none = ZoneSystem(start, start, *nothing, 1.0)
    assert residuals_of_zones(none, nowhere, np.empty(0)) == []
