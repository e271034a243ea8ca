"""Directions of descent, compared with dense algebra and with literal versions."""

import numpy as np
import pytest

from izo_ref.solvers.serial.descent import (
    CG,
    CHEBYSHEV,
    GRADIENT,
    JACOBI,
    LBFGS,
    NEWTON,
    choose_direction,
)
from izo_ref.solvers.serial.directions.cg import cg_direction
from izo_ref.solvers.serial.directions.chebyshev import accelerate, goes_uphill, next_omega
from izo_ref.solvers.serial.directions.lbfgs import PAIRS, lbfgs_direction, remember_pair
from izo_ref.solvers.serial.directions.newton import newton_direction
from izo_ref.solvers.serial.lagrangian import MU, evaluate
from tests.helpers.one_zone import one_zone, settings
from tests.helpers.shapes import random_problem

PENALTY = 30.0


@pytest.fixture
def zone(rng):
    """Return the arrays of a zone at a point, and its dense generalised Hessian there."""
    zone = random_problem(rng, 10)
    kappa = 0.5 + rng.random(len(zone.masses))
    x = 0.02 * rng.normal(size=zone.proposed.shape)
    arrays, rows = one_zone(zone, kappa, x, 0.1 * rng.random(10))
    evaluate(arrays, PENALTY)
    arrays.state[MU] = PENALTY
    active = rows[arrays.pushed > 0.0]
    assert 0 < len(active) < 10
    return arrays, np.diag(arrays.curvatures[:-3]) + PENALTY * active.T @ active


def test_newton_solves_with_the_generalised_hessian(zone):
    arrays, hessian = zone
    products = newton_direction(arrays, PENALTY, 1e-12, 200)
    expected = np.linalg.solve(hessian, -arrays.gradient[:-3])
    np.testing.assert_allclose(
        arrays.direction[:-3], expected, rtol=0.0, atol=1e-10 * abs(expected).max()
    )
    assert products <= 40
    np.testing.assert_array_equal(arrays.direction[-3:], 0.0)


def test_newton_stops_at_its_tolerance_and_its_limit(zone):
    arrays, hessian = zone
    w, g = arrays.curvatures[:-3], arrays.gradient[:-3]
    for tolerance in (0.3, 1e-2, 1e-4):
        newton_direction(arrays, PENALTY, tolerance, 200)
        rest = hessian @ arrays.direction[:-3] + g
        assert np.sum(rest**2 / w) <= 1.01 * tolerance**2 * np.sum(g**2 / w)
    assert newton_direction(arrays, PENALTY, 0.0, 3) == 3
    assert arrays.gradient @ arrays.direction < 0.0


def test_jacobi_divides_by_the_diagonal_and_gradient_does_not(zone):
    arrays, hessian = zone
    choose_direction(arrays, settings(direction=GRADIENT), True)
    np.testing.assert_array_equal(arrays.direction, -arrays.gradient)
    for direction in (JACOBI, CHEBYSHEV):
        choose_direction(arrays, settings(direction=direction, preconditioned=True), True)
        expected = -arrays.gradient[:-3] / np.diag(hessian)
        np.testing.assert_allclose(arrays.direction[:-3], expected, rtol=1e-12)


def two_loop(gradient, pairs):
    """Return the L-BFGS direction: Nocedal and Wright, algorithm 7.4, with eq. 7.20."""
    q, alphas = gradient.copy(), []
    for s, y in reversed(pairs):
        alphas.append((s @ q) / (y @ s))
        q -= alphas[-1] * y
    s, y = pairs[-1]
    r = (s @ y) / (y @ y) * q
    for (s, y), alpha in zip(pairs, reversed(alphas), strict=True):
        r += s * (alpha - (y @ r) / (y @ s))
    return -r


@pytest.mark.parametrize("n_pairs", [1, 3, PAIRS, PAIRS + 5])
def test_lbfgs_is_the_two_loop_recursion(rng, zone, n_pairs):
    arrays, hessian = zone
    full = np.eye(len(arrays.x))
    full[:-3, :-3] = hessian
    pairs, stored = [], 0
    for _ in range(n_pairs):
        s = rng.normal(size=len(arrays.x))
        pairs.append((s, full @ s))
        arrays.direction[:], arrays.previous[:] = pairs[-1]
        stored = remember_pair(arrays, stored, 1e-16)
    assert stored == n_pairs
    # A pair without curvature leaves the others unchanged, even if the next slot is in use.
    arrays.direction[:], arrays.previous[:] = 1.0, -1.0
    assert remember_pair(arrays, stored, 1e-16) == stored
    lbfgs_direction(arrays, stored)
    expected = two_loop(arrays.gradient, pairs[-PAIRS:])
    np.testing.assert_allclose(
        arrays.direction, expected, rtol=0.0, atol=1e-12 * abs(expected).max()
    )
    np.testing.assert_array_equal(arrays.previous, arrays.gradient)


def test_lbfgs_forgets_pairs_without_curvature(zone):
    arrays, _ = zone
    arrays.direction[:], arrays.previous[:] = 1.0, -1.0
    assert remember_pair(arrays, 0, 1e-16) == 0
    lbfgs_direction(arrays, 0)
    np.testing.assert_array_equal(arrays.direction, -arrays.gradient)


def test_cg_is_conjugate_where_l_is_quadratic(zone):
    """With exact steps each beta is that of Fletcher and Reeves.

    With n active constraints, it then takes at most n + 1 steps.
    """
    arrays, hessian = zone
    g = arrays.gradient[:-3].copy()
    reference, p = g.copy(), -g
    cg_direction(arrays, True)
    np.testing.assert_array_equal(arrays.direction, -arrays.gradient)
    for _ in range(4):
        alpha = -(p @ reference) / (p @ hessian @ p)
        after = reference + alpha * hessian @ p
        p = -after + (after @ after) / (reference @ reference) * p
        arrays.direction[:] *= alpha
        arrays.gradient[:-3] = after
        arrays.previous[:] = arrays.gradient - arrays.previous
        cg_direction(arrays, False)
        np.testing.assert_allclose(arrays.direction[:-3], p, rtol=0.0, atol=1e-9 * abs(p).max())
        reference = after


def test_cg_takes_the_smaller_beta_and_none_below_zero(zone):
    arrays, _ = zone
    g = arrays.gradient.copy()
    for y in (2.0 * g, 0.5 * g, -g):
        arrays.previous[:] = y
        arrays.direction[:] = p = np.sign(y)
        expected = max(0.0, min(g @ y, g @ g)) / (p @ y) * p - g
        cg_direction(arrays, False)
        np.testing.assert_allclose(arrays.direction, expected, rtol=1e-12)


def test_an_uphill_direction_is_replaced_by_the_gradient(zone):
    """The stored pair makes the approximate inverse Hessian negative, as rounding can."""
    arrays, _ = zone
    n = len(arrays.x)
    arrays.memory[:n] = arrays.gradient
    arrays.memory[PAIRS * n : (PAIRS + 1) * n] = -arrays.gradient
    arrays.memory[2 * PAIRS * n] = -1.0 / np.sum(arrays.gradient**2)
    arrays.state[2] = 1.0
    slope, _, _ = choose_direction(arrays, settings(direction=LBFGS), False)
    np.testing.assert_array_equal(arrays.direction, -arrays.gradient)
    assert slope == pytest.approx(-np.sum(arrays.gradient**2))
    assert arrays.state[2] == 0.0
    for direction in (CG, NEWTON):
        assert choose_direction(arrays, settings(direction=direction), True)[0] < 0.0


def test_omega_is_the_sequence_of_the_papers():
    rho, omega, found = 0.9992, 1.0, []
    for k in range(13):
        omega = next_omega(omega, k, 10, rho)
        found.append(omega)
    assert found[:10] == [1.0] * 10
    tenth = 2.0 / (2.0 - rho**2)
    eleventh = 4.0 / (4.0 - rho**2 * tenth)
    assert found[10:] == [tenth, eleventh, 4.0 / (4.0 - rho**2 * eleventh)]


def test_acceleration_extrapolates_from_the_point_before_the_last(rng, zone):
    arrays, _ = zone
    before, start = rng.normal(size=(2, len(arrays.x)))
    step = rng.normal(size=len(arrays.x))
    arrays.previous[:], arrays.direction[:], arrays.x[:] = before, step, start + step
    accelerate(arrays, 1.7)
    np.testing.assert_allclose(
        arrays.x, 1.7 * (start + step - before) + before, rtol=0.0, atol=1e-14
    )
    np.testing.assert_allclose(arrays.previous, start, rtol=0.0, atol=1e-15)
    arrays.gradient[:] = arrays.x - start
    assert goes_uphill(arrays)
    arrays.gradient[:] *= -1.0
    assert not goes_uphill(arrays)
