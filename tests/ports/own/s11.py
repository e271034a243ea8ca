"""Stage S11 by our own compiled functions."""

from typing import Any

import izo_ref
from validation.ladders.zone_arrays import problem_of


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
