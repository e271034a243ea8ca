"""The vectors of stage S10: the first iterations of presets and directions."""

import numpy as np
import pytest

from izo_ref.base.options import Options
from izo_ref.porting.files import load_cases
from izo_ref.porting.generate import iterations
from izo_ref.porting.reference import steps
from izo_ref.porting.reference.rounded import EPS
from izo_ref.porting.reference.tracked import Tape
from izo_ref.solvers.presets import PRESETS, choose_settings
from tests.helpers.zone_vectors import failures
from tests.naive import presets
from tests.naive.qp import dense_rows
from tests.ports.own import s10 as own
from validation.ladders.stage_descent import BEGINS

FLAGS = (
    "multiplier-order",
    "preset-scaling",
    "chebyshev-omega",
    "cg-beta",
    "lbfgs-order",
    "newton-active-set",
    "inner-solve",
    "penalty-scaling",
    "mass-weighting",
    "armijo",
    "kink",
)
OUTPUTS = ("objectives", "violations", "positions", "step_sizes")
CASES = load_cases(stages=["S10"])


def test_the_cases_are_complete():
    assert len({case.id for case in CASES}) == len(CASES) >= 40
    for flag in FLAGS:
        grades = [case.grade for case in CASES if flag in case.flags]
        assert len(grades) >= 3, flag
        assert {"easy", "hard"} <= set(grades), flag
    words = [case.id.split("-")[1] for case in CASES]
    assert all(words.count(name) >= 4 for name in PRESETS)
    names = ("gradient", "jacobi", "chebyshev", "cg", "lbfgs", "newton")
    assert all(words.count(name) >= 3 for name in names)
    for name in names:
        assert any("f4" in case.dtypes and case.id.startswith(f"S10-{name}") for case in CASES)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_the_tolerance_of_a_case_is_useful(case):
    assert "f8" in case.dtypes
    for name in OUTPUTS:
        wanted = case.expected[name]
        assert wanted["values"], name
        assert 4 * EPS["f8"] * max(wanted["scale"]) <= 1e-7 * max(np.abs(wanted["values"])), name
    objectives = case.expected["objectives"]["values"]
    assert min(objectives) > 1e-2 * max(objectives)


@pytest.mark.parametrize("dtype", ["f8", "f4"])
def test_our_own_loop_passes(dtype):
    chosen = [case._replace(dtypes=(dtype,)) for case in CASES if dtype in case.dtypes]
    assert len(chosen) >= 30
    assert failures(chosen, own.answer) == []


def test_our_own_loop_refuses_another_number_of_pairs():
    with pytest.raises(NotImplementedError):
        own.answer({**CASES[0].inputs, "pairs": 5}, "f8")


@pytest.mark.parametrize("name", PRESETS)
def test_parameters_are_those_of_the_presets(name):
    preset, settings = PRESETS[name], choose_settings(Options(preset=name), 1e-4)
    inputs = getattr(iterations, name.upper())
    assert inputs["penalty"] == preset.mu
    assert inputs["direction_name"] == preset.method
    assert (inputs["scaling"] == "total-mass") == preset.by_total_mass
    assert BEGINS[inputs["begin"]] == settings.begin
    for field in ("armijo", "wolfe", "shrink", "grow", "smallest_step", "faithful", "every_step"):
        if (field, inputs["search"]) not in {("wolfe", "backtracking"), ("shrink", "wolfe")}:
            assert inputs[field] == getattr(settings, field), field
    if name == "arcsim":
        for field in ("inner_steps", "eps_x", "eps_f", "eps_g"):
            assert inputs[field] == getattr(settings, field), field
    if name == "icloth":
        assert (inputs["delay"], inputs["rho"]) == (settings.delay, settings.rho)
    zone = iterations.zone(0, 3, 7, pinned=(2, 3))
    first = iterations.xrtailor(zone)["first_step"] if name == "xrtailor" else inputs["first_step"]
    assert first == preset.step + preset.step_per_vertex * 5


def by_hand(name, inputs, count):
    """Return the positions after some steps of the literal loop in numpy."""
    nodes = np.array(inputs["nodes"]).reshape(-1, 4)
    weights = np.array(inputs["weights"]).reshape(-1, 4)
    normals = np.array(inputs["normals"]).reshape(-1, 3)
    masses, y = np.array(inputs["masses"]), np.array(inputs["proposed"])
    rows = dense_rows(nodes, weights, normals, len(masses))
    return getattr(presets, name)(y, masses, rows, inputs["thickness"], count)


@pytest.mark.parametrize("name", PRESETS)
def test_the_reference_agrees_with_the_literal_presets(name):
    """For cases, and for other random zones; `presets` is another text in floats."""
    standard = [c for c in CASES if name in c.id and c.inputs["penalty"] == 1e3]
    standard = [c for c in standard if c.inputs["smallest_step"] == 1e-12]
    problems = [c.inputs for c in standard if 1 not in c.inputs["pinned"]]
    assert len(problems) >= 4
    for seed in range(20, 26):
        zone = iterations.zone(seed, 1 + seed % 4, 9, masses=(1.0, 0.25, 2.0))
        preset = getattr(iterations, name.upper())
        parameters = iterations.xrtailor(zone) if name == "xrtailor" else preset
        problems.append({**zone, **parameters, "steps": 4})
    for inputs in problems:
        found = [float(x) for x in steps.iterate(inputs, Tape()).positions]
        expected = by_hand(name, inputs, inputs["steps"])
        moved = np.abs(expected - inputs["proposed"]).max()
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * moved)
