"""Numbers with 60 digits that know how much rounding a port may have in their place.

Each number carries its value and, to first order, how large the error of a float is that was
computed by the same operations: `error` times eps, where eps is that of the port (2^-52 for
float64, 2^-23 for float32). Each operation rounds once, which adds at most eps/2 times the size of
its result, and passes on the errors of its operands by their derivatives. This is running error
analysis. So a stage that is written once in these numbers gives the right value and the scale of
its tolerance; another order of summation, or fused operations, stay within a small multiple of it.

Comparisons decide by the value. `Decisions` notes how close the closest one was: if it is within
the error, a port may decide otherwise, and what follows differs although nothing is wrong.

Source: N. Higham, Accuracy and Stability of Numerical Algorithms (2002), section 3.3.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from decimal import Context, Decimal
from types import TracebackType
from typing import ClassVar, TypeAlias

CONTEXT = Context(prec=60, Emin=-99999, Emax=99999)
EPS = {"f8": 2.0**-52, "f4": 2.0**-23}
HALF = Decimal("0.5")
ZERO = Decimal(0)

Plain: TypeAlias = "Rounded | float"


class Decisions:
    """Notes how close comparisons were, while it is entered as a context.

    Attributes:
        closest: The least distance of two numbers that were compared, over the sum of their
            errors. A port with machine epsilon eps decides in the same way if this is well above
            eps. Infinite if nothing was compared.
    """

    _entered: ClassVar[list[Decisions]] = []  # those that note now, innermost last

    def __init__(self) -> None:
        """Start with nothing compared."""
        self.closest = float("inf")

    def __enter__(self) -> Decisions:
        """Begin to note comparisons."""
        self._entered.append(self)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """Stop noting comparisons."""
        self._entered.remove(self)

    def dtypes(self, margin: float = 8.0) -> list[str]:
        """Return the types of floats that decide in the same way, with a margin."""
        return [name for name, eps in EPS.items() if self.closest > margin * eps]

    @classmethod
    def note(cls, a: Rounded, b: Rounded) -> None:
        """Note a comparison of two numbers."""
        error = a.error + b.error
        distance = abs(CONTEXT.subtract(a.value, b.value))
        closeness = float("inf") if error == 0 else float(CONTEXT.divide(distance, error))
        for decisions in cls._entered:
            decisions.closest = min(decisions.closest, closeness)


def to_float32(number: float) -> float:
    """Return the nearest float32, as a float; infinite if it is too large for one."""
    try:
        return struct.unpack("<f", struct.pack("<f", number))[0]
    except OverflowError:
        return math.copysign(math.inf, number)


def is_float32(number: float) -> bool:
    """Return whether a number is a float32 as it stands."""
    return to_float32(number) == number


class Rounded:
    """A number of 60 digits, with the size of the error that a float in its place may have.

    Attributes:
        value: The value.
        error: Error of a float in its place, over eps.
    """

    __slots__ = ("error", "value")

    def __init__(self, value: Decimal, error: Decimal = ZERO) -> None:
        """Keep a value and its error."""
        self.value, self.error = value, error

    @classmethod
    def of(cls, number: Plain) -> Rounded:
        """Return an input: exact, unless a float32 cannot hold it."""
        if isinstance(number, Rounded):
            return number
        value = Decimal(number)
        return cls(value, ZERO if is_float32(number) else HALF * abs(value))

    def _result(self, value: Decimal, error: Decimal) -> Rounded:
        return Rounded(value, CONTEXT.fma(HALF, abs(value), error))

    def __add__(self, other: Plain) -> Rounded:
        b = Rounded.of(other)
        value = CONTEXT.add(self.value, b.value)
        if self.value == 0 or b.value == 0:  # nothing is rounded
            return Rounded(value, CONTEXT.add(self.error, b.error))
        return self._result(value, CONTEXT.add(self.error, b.error))

    __radd__ = __add__

    def __neg__(self) -> Rounded:
        return Rounded(self.value.copy_negate(), self.error)

    def __sub__(self, other: Plain) -> Rounded:
        return self + -Rounded.of(other)

    def __rsub__(self, other: Plain) -> Rounded:
        return Rounded.of(other) + -self

    def __mul__(self, other: Plain) -> Rounded:
        b = Rounded.of(other)
        error = CONTEXT.multiply(abs(self.value), b.error)
        error = CONTEXT.fma(abs(b.value), self.error, error)
        return self._result(CONTEXT.multiply(self.value, b.value), error)

    __rmul__ = __mul__

    def __truediv__(self, other: Plain) -> Rounded:
        b = Rounded.of(other)
        value = CONTEXT.divide(self.value, b.value)
        error = CONTEXT.fma(abs(value), b.error, self.error)
        return self._result(value, CONTEXT.divide(error, abs(b.value)))

    def __rtruediv__(self, other: Plain) -> Rounded:
        return Rounded.of(other) / self

    def sqrt(self) -> Rounded:
        """Return the square root."""
        value = CONTEXT.sqrt(self.value)
        if value == 0:
            return Rounded(value, CONTEXT.sqrt(self.error))
        return self._result(value, CONTEXT.divide(self.error, 2 * value))

    def __abs__(self) -> Rounded:
        return Rounded(self.value.copy_abs(), self.error)

    def __lt__(self, other: Plain) -> bool:
        b = Rounded.of(other)
        Decisions.note(self, b)
        return self.value < b.value

    def __gt__(self, other: Plain) -> bool:
        return Rounded.of(other) < self

    def __le__(self, other: Plain) -> bool:
        return not self > other

    def __ge__(self, other: Plain) -> bool:
        return not self < other

    def __float__(self) -> float:
        """Return the nearest float64."""
        return float(self.value)

    def __repr__(self) -> str:
        """Return the value to 17 digits and the error."""
        return f"{float(self.value)!r} +- {float(self.error):.2g} eps"


def clamped(number: Plain) -> Rounded:
    """Return max(number, 0); this is continuous, so no decision is noted."""
    number = Rounded.of(number)
    if number.value > 0:
        return number
    # a port may find a number above 0 if this one is within its error below 0
    near = -number.value <= number.error * Decimal(4 * EPS["f4"])
    return Rounded(ZERO, number.error if near else ZERO)


def total(numbers: Iterable[Plain]) -> Rounded:
    """Return the sum, from the first number on."""
    result = Rounded(ZERO)
    for number in numbers:
        result = result + number
    return result


def largest(numbers: Iterable[Plain]) -> Rounded:
    """Return the largest number; this is continuous, so no decision is noted."""
    return max((Rounded.of(number) for number in numbers), key=lambda number: number.value)
