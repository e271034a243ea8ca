"""Stage S6 of our own port: objective, gradient and constraints."""

from typing import Any

from tests.ports.own.numbers import DTYPES, reply_of
from validation.ladders.stage_calls import objective


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the outputs of stage S6."""
    return reply_of("S6", objective(inputs, DTYPES[dtype]))
