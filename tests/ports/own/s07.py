"""Stage S7 of our own port: the augmented Lagrangian."""

from typing import Any

from tests.ports.own.numbers import DTYPES, reply_of
from validation.ladders.stage_calls import lagrangian


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the outputs of stage S7."""
    return reply_of("S7", lagrangian(inputs, DTYPES[dtype]))
