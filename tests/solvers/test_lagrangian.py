"""The augmented Lagrangian of the page and its derivatives, without the errors of the page."""

import numpy as np
import pytest

import izo_ref
from izo_ref.solvers.serial.lagrangian import (
    along_line,
    evaluate,
    hessian_diagonal,
    prepare_line,
    renew_constraints,
    update_multipliers,
)
from tests.helpers.one_zone import one_zone, value
from tests.helpers.shapes import one_impact_problem, random_problem

MU = 0.7


@pytest.fixture
def setting(rng):
    """Return a problem, its arrays, its dense constraints and L as a function of x."""
    zone = random_problem(rng, 6)
    kappa = 0.5 + rng.random(len(zone.masses))
    x = 0.01 * rng.normal(size=zone.proposed.shape)
    multipliers = 0.01 * rng.random(6) * (rng.random(6) < 0.6)
    arrays, rows = one_zone(zone, kappa, x, multipliers)
    return zone, arrays, rows, lambda x: value(zone, rows, kappa, MU, x, multipliers)


def test_the_gradient_is_the_derivative_of_the_value(setting):
    _, arrays, _, value_at = setting
    found = evaluate(arrays, MU)
    x, h = arrays.x[:-3], 1e-6
    assert found.value == pytest.approx(value_at(x), rel=1e-13)
    assert found.largest_gradient == np.abs(arrays.gradient).max()
    for i in range(len(x)):
        step = np.zeros_like(x)
        step[i] = h
        derivative = (value_at(x + step) - value_at(x - step)) / (2.0 * h)
        assert abs(derivative - arrays.gradient[i]) < 1e-7


def test_an_evaluation_measures_gap_objective_and_violation(setting):
    """Duality gap, objective and violation are those of the dense formulas."""
    _, arrays, rows, _ = setting
    found = evaluate(arrays, MU)
    x, w = arrays.x[:-3], arrays.curvatures[:-3]
    push = np.maximum(arrays.multipliers + MU * arrays.constraints, 0.0)
    assert found.objective == pytest.approx(0.5 * np.sum(w * x**2))
    assert found.error == pytest.approx(np.sum((w * x - rows.T @ push) ** 2 / w))
    assert found.products == pytest.approx(push @ np.abs(arrays.constraints))
    assert found.violation_m == max(arrays.constraints.max(), 0.0)
    shift = np.minimum(-arrays.constraints, arrays.multipliers / MU)
    assert found.shift_sq == pytest.approx(shift @ shift)
    assert found.largest_shift == pytest.approx(np.abs(shift).max())


def test_the_change_along_a_line_is_the_difference_of_values(setting):
    _, arrays, _, value_at = setting
    evaluate(arrays, MU)
    for p in (-arrays.gradient, np.sin(np.arange(len(arrays.x)))):
        arrays.direction[:-3] = p[:-3]  # the last three are the pinned vertex, which stays
        slope, curvature, _ = prepare_line(arrays, MU)
        here = value_at(arrays.x[:-3])
        for step in (1e-3, 0.1, 1.0, 5.0):
            change, rise, _ = along_line(arrays, MU, slope, curvature, step)
            ends = [value_at(arrays.x[:-3] + a * p[:-3]) for a in (step, step + 1e-6, step - 1e-6)]
            assert change == pytest.approx(ends[0] - here, abs=1e-13, rel=1e-12)
            assert rise == pytest.approx((ends[1] - ends[2]) / 2e-6, abs=1e-7, rel=1e-6)


def test_a_change_below_the_rounding_of_values_keeps_its_digits(setting):
    """Near the minimum, the difference of two values of L is nothing but rounding."""
    _, arrays, _, value_at = setting
    evaluate(arrays, MU)
    arrays.direction[:] = -1e-20 * arrays.gradient
    slope, curvature, _ = prepare_line(arrays, MU)
    change, _, _ = along_line(arrays, MU, slope, curvature, 1.0)
    assert abs(change) < 1e-17 * abs(value_at(arrays.x[:-3]))
    assert change == pytest.approx(slope, rel=1e-12)
    assert slope == pytest.approx(-1e-20 * np.sum(arrays.gradient**2), rel=1e-12)


def test_second_derivative_and_diagonal_are_those_of_the_hessian(setting):
    _, arrays, rows, _ = setting
    evaluate(arrays, MU)
    active = rows[arrays.pushed > 0.0]
    assert 0 < len(active) < len(rows)
    hessian = np.diag(arrays.curvatures[:-3]) + MU * active.T @ active
    hessian_diagonal(arrays, MU)
    np.testing.assert_allclose(arrays.diagonal[:-3], np.diag(hessian), rtol=1e-13)
    arrays.direction[:-3] = np.cos(np.arange(len(hessian)))
    _, curvature, second = prepare_line(arrays, MU)
    p = arrays.direction[:-3]
    assert second == pytest.approx(p @ hessian @ p)
    assert along_line(arrays, MU, -1.0, curvature, 1e-9)[2] == pytest.approx(second)


def test_constraints_are_recomputed_from_the_positions(setting):
    zone, arrays, rows, _ = setting
    arrays.constraints[:] = np.nan
    renew_constraints(arrays)
    expected = zone.thickness - rows @ (zone.proposed.ravel() + arrays.x[:-3])
    np.testing.assert_allclose(arrays.constraints, expected, rtol=0.0, atol=1e-16)


def test_multipliers_are_never_negative(rng):
    """Eq. 9 of the page does not clamp, and a satisfied constraint would pull."""
    zone = random_problem(rng, 6)
    x = np.zeros(zone.proposed.shape)
    arrays, _ = one_zone(zone, np.ones(len(zone.masses)), x, np.full(6, 1e-3))
    expected = np.maximum(1e-3 + MU * arrays.constraints, 0.0)
    update_multipliers(arrays, MU)
    np.testing.assert_array_equal(arrays.multipliers, expected)
    assert 0 < np.count_nonzero(expected) < 6
    for method in ("gradient", "newton"):
        found = izo_ref.solve_zone(random_problem(rng, 20), method=method)
        assert (found.multipliers >= 0.0).all()
        assert (found.multipliers == 0.0).any()


def test_the_effect_of_mu_depends_on_the_scale_of_the_objective():
    """One zone is solved twice with the same mu and steps, for eq. 1 and for 100 times eq. 1."""
    zone = one_impact_problem(masses=[1.0] * 4)
    ends = []
    for scale in (1.0, 100.0):
        x, multipliers = np.zeros((4, 3)), np.zeros(1)
        kappa = scale * zone.masses / zone.masses.sum()
        arrays, _ = one_zone(zone, kappa, x, multipliers)
        for _ in range(20):
            evaluate(arrays, MU)
            arrays.direction[:] = -arrays.gradient
            _, _, second = prepare_line(arrays, MU)
            step = np.sum(arrays.gradient**2) / second if second > 0.0 else 0.0
            arrays.x[:] -= step * arrays.gradient
            renew_constraints(arrays)
            update_multipliers(arrays, MU)
        ends.append(-arrays.constraints[0])
    # The first closes the gap of 1.5 to a millionth, the second only by a third.
    assert -1e-3 < ends[0] < 0.0
    assert ends[1] < -0.5
