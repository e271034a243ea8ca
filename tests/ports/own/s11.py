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


def answer(inputs: dict[str, Any], dtype: str, **options: Any) -> dict[str, Any]:
    """Return the optimum of a zone; `options` are those of `solve_zone`."""
    if dtype != "f8":
        raise NotImplementedError("zones are solved to the end in float64")
    found = izo_ref.solve_zone(problem_of(inputs), **options)
    if not found.feasible:
        return {"feasible": 0}
    return {
        "feasible": 1,
        "positions": found.positions.ravel().tolist(),
        "multipliers": found.multipliers.tolist(),
    }
