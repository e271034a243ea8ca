"""Stage S9 of our own port: the update of the multipliers."""

from typing import Any

import numpy as np

from izo_ref.solvers.serial.lagrangian import update_multipliers
from izo_ref.zones.problem import ZoneProblem
from tests.ports.own.zones import own_zone, rounded


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the outputs of stage S9."""
    count = len(inputs["multipliers"])
    nodes = np.tile(np.arange(4), (count, 1))
    points = np.zeros((4, 3))
    problem = ZoneProblem(
        nodes, np.zeros((count, 4)), np.zeros((count, 3)), points, np.ones(4), 1.0
    )
    own = own_zone(problem, {**inputs, "positions": points}, dtype)
    own.zone.constraints[:] = rounded(inputs["constraints"], dtype)
    update_multipliers(own.zone, float(rounded(inputs["penalty"], dtype)))
    return {"multipliers": own.zone.multipliers.tolist()}
