"""Stage S10 by our own compiled loop, with the parameters of the case."""

from typing import Any

from izo_ref.solvers.serial.directions.lbfgs import PAIRS
from tests.ports.own.numbers import DTYPES, reply_of
from validation.ladders.stage_descent import iterations


def answer(inputs: dict[str, Any], dtype: str) -> dict[str, Any]:
    """Return the outputs of S10.

    Args:
        inputs: The fields of the stage, arrays as flat lists.
        dtype: `f8` or `f4`.
    """
    if inputs["pairs"] != PAIRS:
        raise NotImplementedError
    return reply_of("S10", iterations(inputs, DTYPES[dtype]))
