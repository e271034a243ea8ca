"""Stage S1 by our own functions."""

from typing import Any

from tests.ports.own.numbers import DTYPES
from validation.ladders.stage_pairs import listed_pairs


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the pairs whose moving boxes meet; the type of floats is that of the boxes."""
    return dict(listed_pairs(inputs, DTYPES[dtype]))
