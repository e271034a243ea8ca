"""Stage S6 of our own port: objective, gradient and constraints."""

from typing import Any

import numpy as np

from izo_ref.solvers.serial.lagrangian import evaluate
from tests.ports.own.zones import own_problem, own_zone, rounded


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the outputs of stage S6."""
    problem = own_problem(inputs, dtype)
    own = own_zone(problem, inputs, dtype)
    constraints = own.zone.constraints.tolist()
    if dtype == "f8":
        positions = rounded(inputs["positions"], dtype).reshape(-1, 3)
        constraints = (-problem.gaps(positions)).tolist()
    # no impact is active, so L is g
    own.zone.constraints[:] = -np.inf
    measures = evaluate(own.zone, 1.0)
    return {
        "objective": measures.objective,
        "gradient": own.spread(own.zone.gradient),
        "constraints": constraints,
    }
