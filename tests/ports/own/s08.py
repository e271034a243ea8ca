"""Stage S8 of our own port: the line searches."""

from typing import Any

from tests.ports.own.numbers import DTYPES, reply_of
from validation.ladders.stage_descent import line_search


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the outputs of stage S8."""
    return reply_of("S8", line_search(inputs, DTYPES[dtype]))
