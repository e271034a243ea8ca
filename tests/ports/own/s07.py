"""Stage S7 of our own port: the augmented Lagrangian."""

from typing import Any

from izo_ref.solvers.serial.lagrangian import evaluate
from tests.ports.own.zones import own_problem, own_zone, rounded


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the outputs of stage S7."""
    own = own_zone(own_problem(inputs, dtype), inputs, dtype)
    measures = evaluate(own.zone, float(rounded(inputs["penalty"], dtype)))
    return {"value": measures.value, "gradient": own.spread(own.zone.gradient)}
