"""Stages S8 and S10 by our own functions: a line search, and the first steps of the loop."""

import math
from typing import Any

import numpy as np

from izo_ref.base.options import Options
from izo_ref.solvers.augmented_lagrangian import run_on_cpu
from izo_ref.solvers.presets import LINE_SEARCHES, METHOD_PARAMETERS, PRESETS, choose_settings
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial.descent import LAST, MODEL, UNIT
from izo_ref.solvers.serial.lagrangian import evaluate, prepare_line
from izo_ref.solvers.serial.line_search import search_line
from izo_ref.solvers.serial.records import Results
from izo_ref.solvers.serial.settings import Settings
from izo_ref.solvers.variables import choose_variables, lay_out, make_inputs
from izo_ref.zones.system import problem_system
from validation.ladders.stage_answer import Answer, Inputs
from validation.ladders.zone_arrays import problem_of, rounded, zone_arrays

BEGINS = {"last": LAST, "unit": UNIT, "model": MODEL}
SCALINGS = {
    "total-mass": PRESETS["icloth"],
    "mean-inverse-mass": PRESETS["xrtailor"],
    "scaled": None,
}
NEVER = 1e-30  # a tolerance that is not reached, and that a float32 holds
TAKEN = (
    "preconditioned",
    "armijo",
    "wolfe",
    "shrink",
    "grow",
    "smallest_step",
    "inner_steps",
    "inner_accuracy",
    "eps_x",
    "eps_f",
    "eps_g",
    "delay",
    "rho",
    "linear_tolerance",
)


def line_search(inputs: Inputs, kind: type[Any] = np.float64) -> Answer:
    """Stage S8, with arrays of a type of floats; the decision is that of `outcome_of_search`."""
    names = "first", "armijo", "wolfe", "shrink", "smallest_step", "penalty"
    numbers = {name: float(rounded(inputs[name], kind)) for name in names}
    first, mu = numbers.pop("first"), numbers.pop("penalty")
    settings = choose_settings(Options(method="gradient"), 1e-3)._replace(
        line_search=LINE_SEARCHES[inputs["search"]],
        rounding=float(np.finfo(kind).eps) / 2.0,
        **numbers,
    )
    arrays = zone_arrays(problem_of(inputs, kind), inputs, kind)
    arrays.zone.direction[:] = arrays.rows_of(rounded(inputs["direction"], kind))
    evaluate(arrays.zone, mu)
    slope, curvature, _ = prepare_line(arrays.zone, mu)
    step, change = search_line(arrays.zone, mu, slope, curvature, first, settings)
    found = {"step": np.array([step]), "change": np.array([change])}
    return Answer(found, outcome_of_search(inputs, step))


def outcome_of_search(inputs: Inputs, step: float) -> str:
    """Return whether a step was accepted, and how often backtracking made it shorter before."""
    if not step > 0.0:
        return "no step"
    if inputs["search"] != "backtracking":
        return "a step"
    shorter = math.log(step / inputs["first"]) / math.log(inputs["shrink"])
    return f"shorter {round(shorter)} times"


def iterations(inputs: Inputs, kind: type[Any] = np.float64) -> Answer:
    """Stage S10, with arrays of a type of floats; the decision is how many steps it takes."""
    options = Options(method=inputs["direction_name"], precision=np.dtype(kind).name)
    settings = _settings(inputs, options)
    system, places = problem_system([problem_of(inputs, kind)])
    constraints = scale_constraints(system)
    variables = choose_variables(system, constraints, SCALINGS[inputs["scaling"]])
    layout = lay_out(system, constraints, settings.direction)
    own = make_inputs(system, options, constraints, variables, layout)
    penalty, first = np.array([inputs["penalty"]]), np.array([inputs["first_step"]])
    own = own._replace(mus=penalty, mu_caps=penalty, first_steps=first)
    results = Results(
        np.zeros(layout.unknown_offsets[-1], kind),
        np.zeros(len(layout.nodes), kind),
        np.zeros(1, np.int32),
        np.zeros(1),
        np.zeros(1),
        np.zeros((1, settings.max_steps, 2)),
    )
    run_on_cpu(own, settings, results)
    positions = system.proposed.copy()
    positions[: len(layout.place)] += variables.lengths[:, None] * results.x[layout.place]
    trace = results.trace[0, : results.steps[0]]
    found = {
        "objectives": trace[:, 0].copy(),
        "violations": trace[:, 1].copy(),
        "positions": positions[places].ravel(),
    }
    return Answer(found, int(results.steps[0]))


def _settings(inputs: Inputs, options: Options) -> Settings:
    """Return the settings of the loop, without the end that a solved zone has."""
    return choose_settings(options, 1.0)._replace(
        direction=METHOD_PARAMETERS[inputs["direction_name"]].direction,
        line_search=LINE_SEARCHES[inputs["search"]],
        begin=BEGINS[inputs["begin"]],
        every_step=bool(inputs["every_step"]),
        faithful=bool(inputs["faithful"]),
        max_steps=inputs["steps"],
        gap_tolerance=NEVER,
        violation_m=NEVER,
        penalty_growth=1.0,
        **{name: inputs[name] for name in TAKEN},
    )
