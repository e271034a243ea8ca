"""Each line search against a dense scan of L, and the conditions that it promises."""

import numpy as np
import pytest

from izo_ref.solvers.serial.lagrangian import evaluate, prepare_line
from izo_ref.solvers.serial.line_search import BACKTRACKING, EXACT, WOLFE, search_line
from tests.helpers.one_zone import one_zone, settings, value
from tests.helpers.shapes import random_problem

MU = 50.0  # constraints outweigh masses, so L has many pieces along each line


def line(rng, n=12):
    """Draw a zone, a point and a downhill direction.

    Returns:
        The arrays, (slope, curvature), the step to the minimum of the local quadratic, and
        the function (value of L, slope) of the step in dense algebra.
    """
    zone = random_problem(rng, n)
    kappa = 0.5 + rng.random(len(zone.masses))
    multipliers = 0.1 * rng.random(n)
    x = 0.02 * rng.normal(size=zone.proposed.shape)
    arrays, rows = one_zone(zone, kappa, x, multipliers)
    evaluate(arrays, MU)
    arrays.direction[:] = -arrays.gradient * np.exp(rng.normal(size=len(arrays.x)))
    slope, curvature, second = prepare_line(arrays, MU)
    assert slope < 0.0

    def along(step):
        """Return L and its slope at x + step p, with the gradient at that very point."""
        here = arrays.x[:-3] + step * arrays.direction[:-3]
        push = np.maximum(
            multipliers + MU * (zone.thickness - rows @ (zone.proposed.ravel() + here)), 0.0
        )
        gradient = arrays.curvatures[:-3] * here - rows.T @ push
        return value(zone, rows, kappa, MU, here, multipliers), gradient @ arrays.direction[:-3]

    return arrays, (slope, curvature), -slope / second, along


@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e3])
def test_exact_search_finds_the_minimum_of_a_dense_scan(rng, factor):
    for _ in range(10):
        arrays, terms, model, along = line(rng)
        exact = settings(line_search=EXACT)
        step, change = search_line(arrays, MU, *terms, factor * model, exact)
        scan = np.linspace(0.0, 4.0 * step, 801)
        values = [along(a)[0] for a in scan]
        assert abs(scan[np.argmin(values)] - step) <= 1.5 * scan[1]
        assert along(step)[0] <= min(values) + 1e-14
        assert abs(along(step)[1]) <= 1e-9 * abs(terms[0])
        assert change == pytest.approx(along(step)[0] - along(0.0)[0], abs=1e-12)


@pytest.mark.parametrize("factor", [1e-4, 1.0, 1e4])
@pytest.mark.parametrize("curvature", [0.1, 0.9])
def test_wolfe_conditions_hold_at_the_step_returned(rng, factor, curvature):
    """Page eq. 21, but with the gradient at x + step p; the page takes it in between."""
    for _ in range(30):
        arrays, terms, model, along = line(rng)
        wolfe = settings(line_search=WOLFE, armijo=1e-4, wolfe=curvature)
        step, _ = search_line(arrays, MU, *terms, factor * model, wolfe)
        ends, slope = along(step)
        assert step > 0.0
        assert ends <= along(0.0)[0] + 1e-4 * step * terms[0] + 1e-14
        assert abs(slope) <= curvature * abs(terms[0]) * (1.0 + 1e-9)


@pytest.mark.parametrize("armijo", [1e-4, 0.5])
def test_backtracking_takes_the_first_step_that_decreases_enough(rng, armijo):
    shortened = 0
    for _ in range(30):
        arrays, terms, model, along = line(rng)
        search = settings(line_search=BACKTRACKING, armijo=armijo, shrink=0.7)
        first = 4.0 * model
        step, _ = search_line(arrays, MU, *terms, first, search)
        tries = first * 0.7 ** np.arange(80)
        enough = [along(a)[0] - along(0.0)[0] < armijo * a * terms[0] for a in tries]
        assert step == pytest.approx(tries[np.argmax(enough)], rel=1e-12)
        shortened += step < first
    assert shortened > 5


@pytest.mark.parametrize("search", [EXACT, BACKTRACKING, WOLFE])
def test_an_uphill_direction_gets_no_step(rng, search):
    arrays, _, _, _ = line(rng)
    arrays.direction[:] = arrays.gradient
    slope, curvature, _ = prepare_line(arrays, MU)
    found = settings(line_search=search)
    assert search_line(arrays, MU, slope, curvature, 1.0, found) == (0.0, 0.0)
