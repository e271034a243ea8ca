"""Stage S10 by our own compiled loop, with the parameters of the case."""

from typing import Any

import numpy as np

from izo_ref.base.options import Options
from izo_ref.solvers.augmented_lagrangian import run_on_cpu
from izo_ref.solvers.presets import LINE_SEARCHES, METHOD_PARAMETERS, PRESETS, choose_settings
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial.descent import LAST, MODEL, UNIT
from izo_ref.solvers.serial.directions.lbfgs import PAIRS
from izo_ref.solvers.serial.records import Results
from izo_ref.solvers.serial.settings import Settings
from izo_ref.solvers.variables import choose_variables, lay_out, make_inputs
from izo_ref.zones.system import problem_system
from tests.ports.own.zones import own_problem

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


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the outputs of S10.

    Args:
        inputs: The fields of the stage, arrays as flat lists.
        dtype: `f8` or `f4`.
    """
    if inputs["pairs"] != PAIRS:
        raise NotImplementedError
    precision = {"f8": "float64", "f4": "float32"}[dtype]
    options = Options(method=inputs["direction_name"], precision=precision)
    settings = _settings(inputs, options)
    system, places = problem_system([own_problem(inputs, dtype)])
    constraints = scale_constraints(system)
    variables = choose_variables(system, constraints, SCALINGS[inputs["scaling"]])
    layout = lay_out(system, constraints, settings.direction)
    own = make_inputs(system, options, constraints, variables, layout)
    penalty, first = np.array([inputs["penalty"]]), np.array([inputs["first_step"]])
    own = own._replace(mus=penalty, mu_caps=penalty, first_steps=first)
    results = Results(
        np.zeros(layout.unknown_offsets[-1], precision),
        np.zeros(len(layout.nodes), precision),
        np.zeros(1, np.int32),
        np.zeros(1),
        np.zeros(1),
        np.zeros((1, settings.max_steps, 2)),
    )
    run_on_cpu(own, settings, results)
    positions = system.proposed.copy()
    positions[: len(layout.place)] += variables.lengths[:, None] * results.x[layout.place]
    trace = results.trace[0, : results.steps[0]]
    return {
        "objectives": trace[:, 0].tolist(),
        "violations": trace[:, 1].tolist(),
        "positions": positions[places].ravel().tolist(),
    }


def _settings(inputs: dict[str, Any], options: Options) -> Settings:
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
