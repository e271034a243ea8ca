"""Presets against literal versions, and the parameters in the table of docs/method section 4."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Options
from izo_ref.base import errors
from izo_ref.base.options import LAGRANGIAN, PRESET_METHODS
from izo_ref.solvers.presets import METHOD_PARAMETERS, PRESETS, choose_settings
from tests.helpers.shapes import one_impact_problem, random_problem
from tests.naive import presets
from tests.naive.qp import dense_rows


def by_hand(name, zone, steps):
    """Return the positions after some steps of the literal loop."""
    rows = dense_rows(zone.nodes, zone.weights, zone.normals, len(zone.masses))
    loop = getattr(presets, name)
    y = zone.proposed.ravel()
    return loop(y, zone.masses, rows, zone.thickness, steps).reshape(-1, 3)


@pytest.mark.parametrize(("steps", "atol"), [(1, 1e-14), (2, 1e-14), (5, 1e-9), (13, 1e-6)])
@pytest.mark.parametrize("name", PRESETS)
def test_presets_take_the_steps_of_those_systems(rng, name, steps, atol):
    """13 steps include the multipliers of a second inner solve, and a change of Chebyshev's omega.

    mu = 1e3 makes L stiff, so conjugate gradients amplify rounding a thousandfold in each step.
    Over 60 other draws of these zones, icloth and xrtailor are always within `atol`. arcsim
    needs an `rtol` of at most 1.1e-11 after one and two steps; after 5 steps, 4 of the 60 draws
    are off by up to 7e-6, and after 13 steps one is off by 5e-6.
    """
    moved = 0
    for n in (1, 4, 20):
        for mass_ratio in (1.0, 30.0):
            zone = random_problem(rng, n, mass_ratio)
            found = izo_ref.solve_zone(zone, preset=name, max_steps=steps)
            expected = by_hand(name, zone, steps)
            moved += found.iterations == steps
            np.testing.assert_allclose(found.positions, expected, rtol=1e-10, atol=atol)
    assert moved >= 2


@pytest.mark.parametrize("name", PRESETS)
def test_presets_report_that_they_have_not_converged(name):
    """100 steps end far from the optimum, and the independent residuals show it.

    Masses are those of a garment and the gap is of millimetres, as these systems meet them.
    """
    zone = one_impact_problem(masses=[1e-5] * 4, thickness=1e-4)
    found = izo_ref.solve_zone(zone, preset=name)
    assert found.iterations <= 100
    assert found.method == PRESET_METHODS[name]
    assert not found.residuals.solved(1e-9, 1e-9)
    assert izo_ref.solve_zone(zone).residuals.solved(1e-9, 1e-9)


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_overrides_the_options_that_it_fixes(rng, name):
    zone = random_problem(rng, 8)
    own = izo_ref.solve_zone(zone, preset=name, max_steps=20)
    same = izo_ref.solve_zone(
        zone,
        PRESET_METHODS[name],
        "exact",
        preset=name,
        max_steps=20,
        multiplier_update="inner-solve",
        penalty="grown",
    )
    np.testing.assert_array_equal(own.positions, same.positions)
    other = "lbfgs" if name != "lbfgs" else "cg"
    with pytest.raises(errors.OptionError, match=f"preset: '{name}'"):
        izo_ref.solve_zone(zone, other, preset=name)


def test_parameters_are_those_of_the_table():
    xrtailor = choose_settings(Options(preset="xrtailor"), 1e-4)
    assert (xrtailor.armijo, xrtailor.shrink, xrtailor.grow) == (0.5, 0.7, 1.0)
    icloth = choose_settings(Options(preset="icloth"), 1e-4)
    assert (icloth.delay, icloth.rho, icloth.smallest_step) == (10, 0.9992, 1e-12)
    arcsim = choose_settings(Options(preset="arcsim"), 1e-4)
    assert (arcsim.eps_x, arcsim.eps_f, arcsim.eps_g) == (1e-6, 1e-12, 1e-6)
    assert (arcsim.inner_steps, arcsim.every_step) == (10, False)
    for found in (xrtailor, icloth, arcsim):
        assert found.max_steps == 100
    assert {preset.mu for preset in PRESETS.values()} == {1e3}


def test_every_method_and_preset_has_parameters():
    assert tuple(METHOD_PARAMETERS) == LAGRANGIAN
    assert {name: preset.method for name, preset in PRESETS.items()} == PRESET_METHODS
