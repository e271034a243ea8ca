"""Stage S11 by our own compiled functions."""

from typing import Any

import numpy as np

import izo_ref


def problem_of(inputs: dict[str, Any]) -> izo_ref.ZoneProblem:
    """Return the zone problem of the inputs of stage S11."""
    pinned = np.array(inputs["pinned"], bool)
    return izo_ref.ZoneProblem(
        np.array(inputs["nodes"], np.int32).reshape(-1, 4),
        np.array(inputs["weights"]).reshape(-1, 4),
        np.array(inputs["normals"]).reshape(-1, 3),
        np.array(inputs["proposed"]).reshape(-1, 3),
        np.where(pinned, np.inf, inputs["masses"]),
        inputs["thickness"],
    )


def reply_of(found: izo_ref.ZoneSolution, feasible: bool) -> dict[str, Any]:
    """Return the outputs of stage S11."""
    if not feasible:
        return {"feasible": 0}
    return {
        "feasible": 1,
        "positions": found.positions.ravel().tolist(),
        "multipliers": found.multipliers.tolist(),
    }


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the optimum of a zone."""
    if dtype != "f8":
        raise NotImplementedError("zones are solved to the end in float64")
    found = izo_ref.solve_zone(problem_of(inputs))
    return reply_of(found, found.feasible)
