"""Builds cases: numbers them, and writes what the judge needs from numbers with an error."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import Any

from izo_ref.porting.cases import DTYPES, VALID, Case, Value
from izo_ref.porting.reference.rounded import EPS, Decisions, Rounded

# A running error bound has every rounding at its largest. What is left is the order of sums, fused
# operations, and forms of a formula with two or three operations more.
MULTIPLE = 4
USEFUL = 1e-2  # a tolerance larger than this, relative to the largest number, judges nothing


class CaseList(list[Case]):
    """The cases of a stage, in order."""

    def __init__(self, stage: str) -> None:
        """Begin with no cases."""
        super().__init__()
        self.stage = stage
        self.numbers: Counter[str] = Counter()

    def add(
        self,
        word: str,
        flags: str,
        grade: str,
        what: str,
        inputs: Mapping[str, Value],
        expected: Mapping[str, Mapping[str, Any]],
        dtypes: Sequence[str] = DTYPES,
    ) -> None:
        """Add a valid case; types of floats that it could not judge are left out.

        Args:
            word: The word in its id.
            flags: Names of the mistakes that it catches, with spaces between them.
            grade: `easy`, `medium` or `hard`.
            what: A sentence that says what is special about it.
            inputs: The inputs of the stage.
            expected: What the judge needs, for each output.
            dtypes: Types of floats that decide as the reference does.
        """
        self.numbers[word] += 1
        name = f"{self.stage}-{word}-{self.numbers[word]:02d}"
        useful = tuple(dtype for dtype in dtypes if _is_useful(expected, dtype))
        case = Case(
            name, self.stage, tuple(flags.split()), VALID, grade, useful, what, inputs, expected
        )
        self.append(case)


def values(
    numbers: Sequence[Rounded], multiple: int = MULTIPLE, least: float = 0.0
) -> dict[str, Any]:
    """Return the parameters of the judge `values`.

    Args:
        numbers: The expected values, with their errors.
        multiple: Tolerance in units of eps times the error.
        least: Least scale, for numbers that a port may flush to zero.
    """
    return {
        "judge": "values",
        "values": [float(number) for number in numbers],
        "scale": [max(scale_of(number), least) for number in numbers],
        "multiple": multiple,
    }


def between(low: Rounded, high: Rounded, multiple: int = MULTIPLE) -> dict[str, Any]:
    """Return the parameters of the judge `range`."""
    return {
        "judge": "range",
        "low": float(low),
        "high": float(high),
        "scale": max(scale_of(low), scale_of(high)),
        "multiple": multiple,
    }


def exact_inputs(value: Any) -> Any:
    """Return inputs whose floats are numbers without an error, for ports that read float64."""
    if isinstance(value, Mapping):
        return {name: exact_inputs(item) for name, item in value.items()}
    if isinstance(value, list):
        return [exact_inputs(item) for item in value]
    return Rounded(Decimal(value)) if isinstance(value, float) else value


def scale_of(number: Rounded) -> float:
    """Return the error of a number, at least half a unit of it, rounded up to eight bits."""
    error = max(float(number.error), abs(0.5 * float(number)))
    fraction, exponent = math.frexp(error)
    return math.ldexp(math.ceil(256.0 * fraction), exponent - 8)


def decided(decisions: Decisions) -> list[str]:
    """Return the types of floats that decide as the reference did."""
    return decisions.dtypes(2.0 * MULTIPLE)


def _is_useful(expected: Mapping[str, Mapping[str, Any]], dtype: str) -> bool:
    """Return whether the tolerances of a type of floats are small enough."""
    for parameters in expected.values():
        if parameters["judge"] == "values":
            largest = max(map(abs, parameters["values"]), default=0.0)
            scale = max(parameters["scale"], default=0.0)
        elif parameters["judge"] == "range":
            largest, scale = parameters["high"] - parameters["low"], parameters["scale"]
        else:
            continue
        if largest > 0.0 and parameters["multiple"] * EPS[dtype] * scale > USEFUL * largest:
            return False
    return True
