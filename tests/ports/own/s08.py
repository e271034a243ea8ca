"""Stage S8 of our own port: the line searches."""

from typing import Any

import numpy as np

from izo_ref.base.options import Options
from izo_ref.solvers.presets import LINE_SEARCHES, choose_settings
from izo_ref.solvers.serial.lagrangian import evaluate, prepare_line
from izo_ref.solvers.serial.line_search import search_line
from tests.ports.own.zones import DTYPES, own_problem, own_zone, rounded


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the outputs of stage S8."""
    names = "first", "armijo", "wolfe", "shrink", "smallest_step", "penalty"
    numbers = {name: float(rounded(inputs[name], dtype)) for name in names}
    first, mu = numbers.pop("first"), numbers.pop("penalty")
    settings = choose_settings(Options(method="gradient"), 1e-3)._replace(
        line_search=LINE_SEARCHES[inputs["search"]],
        rounding=float(np.finfo(DTYPES[dtype]).eps) / 2.0,
        **numbers,
    )
    own = own_zone(own_problem(inputs, dtype), inputs, dtype)
    own.zone.direction[:] = own.gather(rounded(inputs["direction"], dtype))
    evaluate(own.zone, mu)
    slope, curvature, _ = prepare_line(own.zone, mu)
    step, change = search_line(own.zone, mu, slope, curvature, first, settings)
    return {"step": step, "change": change}
