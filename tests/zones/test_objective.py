"""The objective of a step."""

import sys
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

import izo_ref
from izo_ref.zones.objective import objective
from tests.helpers.shapes import vertex_over_face


def test_the_objective_is_divided_by_the_mass_of_unpinned_vertices():
    scene = vertex_over_face(masses=(7.0, 8.0, 9.0, 0.5), pinned=(True, True, True, False))
    result = izo_ref.resolve(scene, thickness=0.125)
    # The unpinned masses are 0.5, 1 and 1, and the first moves by 1.125.
    assert result.objective == pytest.approx(0.5 * 1.125**2 / 2.5)


def step(proposed, masses, pinned):
    """Return what the objective needs of a scene."""
    return SimpleNamespace(positions_t1=proposed, masses=masses, pinned=pinned)


def test_an_unmoved_step_has_the_objective_zero(rng):
    proposed = rng.normal(size=(5, 3))
    masses, nothing = np.ones(5), np.zeros(5, bool)
    assert objective(step(proposed, masses, nothing), proposed) == 0.0
    moved = proposed + 1.0
    assert objective(step(proposed, masses, ~nothing), moved) == 0.0
    assert objective(step(proposed, masses, nothing), moved) == pytest.approx(3.0)


@pytest.mark.parametrize("length", [0, 500, -500, 1022, -1000])
@pytest.mark.parametrize("mass", [0, 600, -600, 1000, -1000])
def test_the_objective_is_that_of_fractions_at_any_size(rng, length, mass):
    """It is infinite or zero where no float can hold it."""
    proposed, positions = np.ldexp(rng.uniform(-1.0, 1.0, (2, 4, 3)), length)
    masses, pinned = np.ldexp(rng.uniform(0.5, 1.0, 4), mass), np.array([False, True, False, False])
    squares = total = Fraction(0)
    for i in np.flatnonzero(~pinned):
        for x, y in zip(positions[i].tolist(), proposed[i].tolist(), strict=True):
            squares += Fraction(masses[i]) * (Fraction(x) - Fraction(y)) ** 2
        total += Fraction(masses[i])
    exact = squares / total
    found = objective(step(proposed, masses, pinned), positions)
    if exact > Fraction(sys.float_info.max):
        assert found == np.inf
    elif exact < Fraction(2) ** -1030:
        assert found <= 2.0**-1029
    else:
        assert abs(Fraction(found) - exact) <= exact * Fraction(1, 2**48)
