"""Stage S4 by our own compiled functions."""

from typing import Any

from validation.ladders.stage_calls import selection


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return which impacts are selected."""
    if dtype != "f8":
        raise NotImplementedError("times of impact are float64")
    return {"selected": list(selection(inputs).decision)}
