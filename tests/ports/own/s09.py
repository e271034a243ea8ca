"""Stage S9 of our own port: the update of the multipliers."""

from typing import Any

from tests.ports.own.numbers import DTYPES, reply_of
from validation.ladders.stage_calls import multipliers


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the outputs of stage S9."""
    return reply_of("S9", multipliers(inputs, DTYPES[dtype]))
