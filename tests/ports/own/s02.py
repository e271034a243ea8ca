"""Stage S2 by our own functions."""

from typing import Any

from tests.ports.own.numbers import reply_of
from validation.ladders.stage_calls import time_of_impact


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return whether a pair meets, and when."""
    if dtype != "f8":
        raise NotImplementedError("only float64")
    found = time_of_impact(inputs)
    return {"meets": int(found.decision), **reply_of("S2", found)}
