"""Projected Gauss-Seidel sweeps: compared with the literal method, and with the optimum."""

import numpy as np
import pytest

import izo_ref
from izo_ref.base.options import SWEEPS
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial.sweeps import sweeps
from izo_ref.zones.system import problem_system
from tests.helpers.shapes import random_problem
from tests.naive.qp import dense_rows
from validation.scenes.zones import random_zone


def swept_by_hand(zone, count, accelerated, start=0.0):
    """Return displacements and multipliers after some sweeps from a start, in dense algebra."""
    n = len(zone.masses)
    rows = dense_rows(zone.nodes, zone.weights, zone.normals, n)
    inverse = np.repeat(1.0 / zone.masses, 3)
    right = zone.thickness - rows @ zone.proposed.ravel()
    multipliers = start + np.zeros(len(rows))
    before = multipliers
    momentum, lowest = 1.0, np.inf
    for _ in range(count):
        if accelerated:
            following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
            beyond = multipliers + (momentum - 1.0) / following * (multipliers - before)
            multipliers, before = np.maximum(beyond, 0.0), multipliers
            momentum = following
        multipliers = multipliers.copy()
        for j, row in enumerate(rows):
            moved = inverse * (rows.T @ multipliers)
            step = (right[j] - row @ moved) / (row @ (inverse * row))
            multipliers[j] = max(multipliers[j] + step, 0.0)
        pulled = rows.T @ multipliers
        dual = 0.5 * pulled @ (inverse * pulled) - right @ multipliers
        if dual > lowest:
            momentum = 1.0
        lowest = dual
    return (inverse * (rows.T @ multipliers)).reshape(n, 3), multipliers


@pytest.mark.parametrize("method", SWEEPS)
@pytest.mark.parametrize("count", [1, 2, 7, 30])
def test_sweeps_are_those_of_the_literal_method(rng, method, count):
    # Accelerated sweeps restart when the dual objective rises. When it hardly changes any more,
    # rounding decides that, which moves the answer by what a sweep still changes.
    rounding = 1e-10 if method == "apgs" else 1e-12
    for n in (1, 5, 30):
        zone = random_problem(rng, n)
        found = izo_ref.solve_zone(zone, method, max_steps=count, tolerance=0.0)
        moves, multipliers = swept_by_hand(zone, count, method == "apgs")
        np.testing.assert_allclose(
            found.displacements, moves, rtol=0.0, atol=rounding * np.abs(moves).max()
        )
        np.testing.assert_allclose(
            found.multipliers, multipliers, rtol=0.0, atol=10 * rounding * np.abs(multipliers).max()
        )


@pytest.mark.parametrize("method", SWEEPS)
def test_sweeps_go_on_from_the_multipliers_that_they_are_given(rng, method):
    zone = random_problem(rng, 12)
    start = np.abs(rng.normal(size=12)) * (np.arange(12) % 3 > 0)
    system, places = problem_system([zone])
    rows, never = scale_constraints(system), np.zeros(1, bool)
    n = int(system.vertex_offsets[1])
    u, z = start * rows.lengths, np.full((n, 3), np.nan)
    own = rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths
    more = method == "apgs", 3, 0.0, 0.0, never, u, z.ravel(), np.empty((0, 2))
    assert sweeps(0, 12, 0, n, *own, *more) == 3
    moves, multipliers = swept_by_hand(zone, 3, method == "apgs", start)
    found = z / np.sqrt(system.masses[:n, None])
    np.testing.assert_allclose(found, moves[np.argsort(places)][:n], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(u / rows.lengths, multipliers, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("method", SWEEPS)
@pytest.mark.parametrize("n", [1, 4, 16, 64])
def test_sweeps_converge_to_the_optimum(rng, method, n):
    for ratio in (1.0, 1e6):
        zone = random_problem(rng, n, ratio)
        found = izo_ref.solve_zone(zone, method)
        assert found.residuals.solved(1e-9, 1e-9)
        assert found.method == method
        exact = izo_ref.solve_zone(zone)
        scale = np.abs(exact.displacements).max()
        # A gap of 1e-9 of the objective allows a distance of its square root.
        assert np.abs(found.displacements - exact.displacements).max() <= 1e-3 * scale


def test_acceleration_saves_sweeps_on_a_large_zone(rng):
    zone, steps = random_zone(rng, 200, 1e3), {}
    for method in SWEEPS:
        steps[method] = izo_ref.solve_zone(zone, method, tolerance=1e-4).iterations
    assert steps["apgs"] < 0.7 * steps["pgs"]  # at most 0.25 in 12 draws


@pytest.mark.parametrize("method", SWEEPS)
def test_a_solve_that_has_not_converged_is_reported(rng, method):
    zone = random_zone(rng, 64, 1e3)
    found = izo_ref.solve_zone(zone, method, max_steps=3)
    assert found.iterations == 3
    assert not found.residuals.solved(1e-9, 1e-9)
    assert np.isfinite(found.residuals.gap)


@pytest.mark.parametrize("method", SWEEPS)
def test_the_trace_ends_at_the_returned_objective_and_violation(rng, method):
    zone = random_problem(rng, 40)
    found = izo_ref.solve_zone(zone, method, trace=True, max_steps=500)
    assert found.trace.shape == (found.iterations, 2)
    objective = 0.5 * np.sum(zone.masses[:, None] * found.displacements**2)
    assert found.trace[-1, 0] == pytest.approx(objective, rel=1e-12)
    assert found.trace[-1, 1] == pytest.approx(found.residuals.violation_m, abs=1e-13)
    assert found.trace[0, 1] > found.trace[-1, 1]


@pytest.mark.parametrize("method", SWEEPS)
def test_float32_ends_near_the_optimum(rng, method):
    zone = random_problem(rng, 20, 1e6)
    found = izo_ref.solve_zone(zone, method, precision="float32", max_steps=2000, tolerance=1e-5)
    exact = izo_ref.solve_zone(zone)
    scale = np.abs(exact.displacements).max()
    assert 1e-12 * scale < np.abs(found.displacements - exact.displacements).max() <= 1e-3 * scale
