"""Stage S13 by our own code: `Scene` and `resolve` raise an `IzoError` for what they refuse."""

from typing import Any

from tests.ports.own.s12 import resolved


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Resolve a step, or raise an error that says what is wrong with it."""
    resolved(inputs, dtype)
    return {}
