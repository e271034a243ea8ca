"""The augmented-Lagrangian loop: every combination converges or reports that it has not."""

import numpy as np
import pytest

import izo_ref
from izo_ref.base.options import CHOICES, LAGRANGIAN, Options
from izo_ref.solvers.augmented_lagrangian import descend
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.zones.system import ZoneSystem
from tests.helpers.shapes import one_impact_problem, opposed_problem, random_problem
from validation.scenes.zones import random_zone

SEARCHES, UPDATES = CHOICES["line_search"], CHOICES["multiplier_update"]


@pytest.mark.parametrize("penalty", CHOICES["penalty"])
@pytest.mark.parametrize("update", UPDATES)
@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("method", LAGRANGIAN)
def test_every_combination_converges(rng, method, search, update, penalty):
    for n in (1, 4, 16, 64):
        for mass_ratio in (1.0, 1e6):
            zone = random_problem(rng, n, mass_ratio)
            found = izo_ref.solve_zone(
                zone, method, search, multiplier_update=update, penalty=penalty
            )
            assert found.residuals.solved(1e-9, 1e-9), (n, mass_ratio, found.residuals)
            assert found.residuals.dual_violation == 0.0
            exact = izo_ref.solve_zone(zone)
            scale = np.abs(exact.displacements).max()
            assert np.abs(found.positions - exact.positions).max() <= 1e-3 * scale
            assert found.method == method


@pytest.mark.parametrize("update", UPDATES)
@pytest.mark.parametrize("method", LAGRANGIAN)
def test_nearly_parallel_constraints_are_solved_or_reported_unsolved(rng, method, update):
    for n in (4, 16, 64):
        zone = random_zone(rng, n, 1e3)
        found = izo_ref.solve_zone(zone, method, multiplier_update=update, max_steps=5000)
        assert np.isfinite(found.positions).all()
        assert found.iterations <= 5000
        assert np.isfinite(found.residuals.gap)
        if found.residuals.solved(1e-9, 1e-9):
            exact = izo_ref.solve_zone(zone)
            scale = np.abs(exact.displacements).max()
            assert np.abs(found.positions - exact.positions).max() <= 1e-3 * scale


def test_newton_with_a_growing_penalty_solves_nearly_parallel_constraints(rng):
    """With mu fixed, the updates grow with 1 / (mu lambda), lambda the least eigenvalue of K."""
    solved = {"fixed": 0, "grown": 0}
    for _ in range(10):
        zone = random_zone(rng, 16, 1e3)
        for penalty in solved:
            found = izo_ref.solve_zone(
                zone, "newton", multiplier_update="inner-solve", penalty=penalty
            )
            solved[penalty] += found.residuals.solved(1e-9, 1e-9)
    assert solved["grown"] >= 9
    assert solved["grown"] > solved["fixed"]


@pytest.mark.parametrize("update", UPDATES)
@pytest.mark.parametrize("method", LAGRANGIAN)
def test_an_infeasible_zone_ends_within_the_step_limit(method, update):
    found = izo_ref.solve_zone(opposed_problem(0.1), method, multiplier_update=update)
    assert found.iterations < 100_000
    assert not found.residuals.solved(1e-9, 1e-9)


@pytest.mark.parametrize("update", UPDATES)
@pytest.mark.parametrize("method", LAGRANGIAN)
def test_float32_stops_at_its_own_accuracy(rng, method, update):
    for n in (4, 32):
        zone = random_problem(rng, n, 100.0)
        found = izo_ref.solve_zone(zone, method, multiplier_update=update, precision="float32")
        assert found.iterations < 20_000
        assert found.residuals.gap <= 2e-5
        assert found.residuals.violation <= 1e-3
        loose = izo_ref.solve_zone(
            zone, method, tolerance=1e-4, multiplier_update=update, precision="float32"
        )
        assert loose.residuals.solved(1e-3, 1e-3)
        assert loose.iterations <= found.iterations


def test_float32_differs_from_float64_by_its_rounding(rng):
    zone = random_problem(rng, 16)
    found = izo_ref.solve_zone(zone, "lbfgs", precision="float32")
    scale = np.sqrt(zone.masses)[:, None] * found.displacements
    ratio = scale / np.abs(scale).max()
    assert not found.residuals.solved(1e-9, 1e-9)
    double = izo_ref.solve_zone(zone, "lbfgs")
    assert np.abs(found.positions - double.positions).max() > 1e-9
    assert np.abs(found.positions - double.positions).max() < 1e-4 * np.abs(ratio).max()


@pytest.mark.parametrize("method", LAGRANGIAN)
def test_steps_are_limited_and_counted(rng, method):
    zone = random_problem(rng, 32)
    for steps in (0, 1, 7):
        found = izo_ref.solve_zone(zone, method, max_steps=steps)
        assert found.iterations == steps
        assert np.isfinite(found.residuals.violation)
    np.testing.assert_array_equal(
        izo_ref.solve_zone(zone, method, max_steps=0).positions, zone.proposed
    )


@pytest.mark.parametrize("update", UPDATES)
@pytest.mark.parametrize("method", LAGRANGIAN)
def test_the_trace_holds_objective_and_violation_after_each_step(rng, method, update):
    zone = random_problem(rng, 8, 100.0)
    found = izo_ref.solve_zone(zone, method, multiplier_update=update, trace=True)
    assert found.trace.shape == (found.iterations, 2)
    for k in (1, 2, found.iterations):
        part = izo_ref.solve_zone(zone, method, multiplier_update=update, max_steps=k, trace=True)
        np.testing.assert_array_equal(part.trace, found.trace[:k])
        objective = 0.5 * np.sum(zone.masses[:, None] * part.displacements**2)
        violation = max(0.0, -zone.gaps(part.positions).min())
        assert part.trace[-1, 0] == pytest.approx(objective, rel=1e-10)
        assert part.trace[-1, 1] == pytest.approx(violation, rel=1e-9, abs=1e-15)


def test_the_trace_of_a_preset_is_in_the_same_units(rng):
    zone = random_problem(rng, 8, 100.0)
    for preset in ("arcsim", "icloth", "xrtailor"):
        found = izo_ref.solve_zone(zone, preset=preset, trace=True)
        objective = 0.5 * np.sum(zone.masses[:, None] * found.displacements**2)
        assert found.trace[-1, 0] == pytest.approx(objective, rel=1e-10)
        violation = max(0.0, -zone.gaps(found.positions).min())
        assert found.trace[-1, 1] == pytest.approx(violation, rel=1e-9, abs=1e-15)


def test_multipliers_of_a_preset_are_in_kg(rng):
    """A preset scales its objective, but stationarity needs multipliers in these units."""
    for preset in ("arcsim", "xrtailor"):
        for masses in (1.0, 7.0):
            zone = one_impact_problem(masses=[masses] * 4, thickness=1e-3)
            found = izo_ref.solve_zone(zone, preset=preset)
            exact = izo_ref.solve_zone(zone)
            np.testing.assert_allclose(found.multipliers, exact.multipliers, rtol=1e-3)


def test_no_trace_unless_asked_for(rng):
    zone = random_problem(rng, 8)
    assert izo_ref.solve_zone(zone, "cg").trace is None
    assert izo_ref.solve_zone(zone, trace=True).trace is None


@pytest.mark.parametrize("method", LAGRANGIAN)
def test_zones_in_one_call_get_the_bits_of_single_calls(rng, method):
    """Each zone has its own arrays, multipliers and memory, so the bits are the same."""
    zones = [random_problem(rng, n, 10.0) for n in (3, 1, 9, 5)]
    vertices = np.cumsum([0] + [len(zone.masses) for zone in zones])
    system = ZoneSystem(
        np.cumsum([0] + [len(zone.nodes) for zone in zones]),
        vertices,
        np.concatenate([zone.nodes + at for zone, at in zip(zones, vertices, strict=False)]),
        np.concatenate([zone.weights for zone in zones]),
        np.concatenate([zone.normals for zone in zones]),
        np.concatenate([zone.proposed for zone in zones]),
        np.concatenate([zone.masses for zone in zones]),
        zones[0].thickness,
    )
    together = descend(system, Options(method=method), scale_constraints(system))
    for i, zone in enumerate(zones):
        alone = izo_ref.solve_zone(zone, method)
        own = slice(vertices[i], vertices[i + 1])
        np.testing.assert_array_equal(together.positions[own], alone.positions)
        assert together.iterations[i] == alone.iterations
