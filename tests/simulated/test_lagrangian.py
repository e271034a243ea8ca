"""The augmented-Lagrangian methods on the device, against those of the processor."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Options
from izo_ref.errors import DeviceUnavailable
from izo_ref.methods import METHODS, PRESETS
from izo_ref.solve import solve_system
from izo_ref.zones import problem_system
from tests.shapes import random_problem

# compiled, x / 0 is inf without a word
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_zones_side_by_side_are_those_of_the_processor(rng, method, precision):
    problems = [random_problem(rng, n, mass_ratio=1e3) for n in (1, 2, 4)]
    options = Options(method=method, precision=precision, max_steps=30)
    system, _ = problem_system(problems)
    found = solve_system(system, options, device="cuda")
    expected = solve_system(system, options)
    assert expected.iterations.max() > 2
    for own, other in zip(found[:-1], expected[:-1], strict=True):
        assert np.array_equal(own, other)


@pytest.mark.parametrize("preset", PRESETS)
def test_presets_step_by_step(rng, preset):
    problem = random_problem(rng, 3)
    found = izo_ref.solve_zone(problem, preset=preset, max_steps=5, trace=True, device="cuda")
    expected = izo_ref.solve_zone(problem, preset=preset, max_steps=5, trace=True)
    assert len(expected.trace) > 0
    assert np.array_equal(found.trace, expected.trace)


def test_methods_of_the_processor_are_named(rng):
    with pytest.raises(DeviceUnavailable, match="'auto' is of the processor"):
        izo_ref.solve_zone(random_problem(rng, 2), device="cuda")
