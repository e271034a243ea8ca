"""Numbers that remember how they were computed, for loops that contract errors.

The error of a `Rounded` number grows with every operation. That is right for a formula, and far too
much for an iteration, in which most errors shrink again: after ten steps it says nothing. A
`Tracked` number is a node of a tape, which holds the derivatives of each operation. One pass
backwards over the tape gives the derivative of a result with respect to each operation, and so the
largest error of the result to first order, with all cancellations:

    error of z = sum over all operations of |dz / d operation| times the rounding of the operation

This is reverse-mode differentiation. Comparisons are noted on the tape too.

Source: A. Griewank, A. Walther, Evaluating Derivatives (2008), sections 3.2 and 3.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from izo_ref.porting.reference.rounded import CONTEXT, EPS, HALF, ZERO, Decisions, Plain, Rounded

NEAR = Decimal(4 * EPS["f4"])


class Tape:
    """The operations of a computation, in their order.

    Attributes:
        parents: For each operation, its tracked operands and the derivatives by them.
        roundings: For each operation, what it rounds, over eps.
        compared: The differences of numbers that were compared.
    """

    def __init__(self) -> None:
        """Start with no operations."""
        self.parents: list[tuple[tuple[int, float], ...]] = []
        self.roundings: list[float] = []
        self.compared: list[Tracked] = []

    def node(
        self, value: Decimal, parents: tuple[tuple[int, float], ...], rounding: Decimal
    ) -> Tracked:
        """Append an operation, and return its result."""
        self.parents.append(parents)
        self.roundings.append(float(rounding))
        return Tracked(value, self, len(self.parents) - 1)

    def leaf(self, number: Plain) -> Rounded:
        """Return a number that is the start of a computation."""
        number = Rounded.of(number)
        return self.node(number.value, (), number.error)

    def error(self, number: Rounded) -> Decimal:
        """Return the largest error of a result, over eps."""
        if not isinstance(number, Tracked):
            return number.error
        slopes = [0.0] * number.number + [1.0]
        error = 0.0
        for i in range(number.number, -1, -1):
            slope = slopes[i]
            if slope != 0.0:
                error += abs(slope) * self.roundings[i]
                for parent, derivative in self.parents[i]:
                    slopes[parent] += slope * derivative
        return Decimal(error)

    def rounded(self, number: Rounded) -> Rounded:
        """Return a result as a number with its error."""
        return Rounded(number.value, self.error(number))

    def note_decisions(self) -> None:
        """Tell the `Decisions` that are entered how close each comparison was."""
        for difference in self.compared:
            Decisions.note(self.rounded(difference), Rounded(ZERO))


class Tracked(Rounded):
    """A number that remembers how it was computed.

    Its `error` is 0: the tape knows the error. An operand that is not tracked is a constant with an
    error of its own.

    Attributes:
        tape: Where the operations are.
        number: Place on the tape.
    """

    __slots__ = ("number", "tape")

    def __init__(self, value: Decimal, tape: Tape, number: int) -> None:
        """Keep a value and its place."""
        super().__init__(value)
        self.tape, self.number = tape, number

    def _join(self, value: Decimal, by_self: Decimal, b: Rounded, by_b: Decimal) -> Tracked:
        """Return the result of an operation from its derivatives by both operands."""
        rounding = CONTEXT.multiply(HALF, abs(value))
        parents = ((self.number, float(by_self)),)
        if isinstance(b, Tracked):
            parents = (*parents, (b.number, float(by_b)))
        else:
            rounding = CONTEXT.fma(abs(by_b), b.error, rounding)
        return self.tape.node(value, parents, rounding)

    def more(self, error: Decimal) -> Tracked:
        """Return the number with an additional error of its own."""
        return self.tape.node(self.value, ((self.number, 1.0),), error)

    def __add__(self, other: Plain) -> Rounded:
        b = Rounded.of(other)
        if b.value == 0 and b.error == 0 and not isinstance(b, Tracked):
            return self
        value = CONTEXT.add(self.value, b.value)
        return self._join(value, Decimal(1), b, Decimal(1))

    __radd__ = __add__

    def __neg__(self) -> Rounded:
        return self.tape.node(self.value.copy_negate(), ((self.number, -1.0),), ZERO)

    def __sub__(self, other: Plain) -> Rounded:
        return self + -Rounded.of(other)

    def __rsub__(self, other: Plain) -> Rounded:
        return -self + other

    def __mul__(self, other: Plain) -> Rounded:
        b = Rounded.of(other)
        return self._join(CONTEXT.multiply(self.value, b.value), b.value, b, self.value)

    __rmul__ = __mul__

    def __truediv__(self, other: Plain) -> Rounded:
        b = Rounded.of(other)
        value = CONTEXT.divide(self.value, b.value)
        by_b = CONTEXT.divide(-value, b.value)
        return self._join(value, CONTEXT.divide(Decimal(1), b.value), b, by_b)

    def __rtruediv__(self, other: Plain) -> Rounded:
        a = Rounded.of(other)
        value = CONTEXT.divide(a.value, self.value)
        by_self = CONTEXT.divide(-value, self.value)
        return self._join(value, by_self, a, CONTEXT.divide(Decimal(1), self.value))

    def sqrt(self) -> Rounded:
        """Return the square root."""
        value = CONTEXT.sqrt(self.value)
        by_self = CONTEXT.divide(HALF, value)
        parents = ((self.number, float(by_self)),)
        return self.tape.node(value, parents, CONTEXT.multiply(HALF, value))

    def __abs__(self) -> Rounded:
        return -self if self.value < 0 else self

    def _compare(self, other: Plain) -> None:
        b = Rounded.of(other)
        parents, error = ((self.number, 1.0),), b.error
        if isinstance(b, Tracked):
            parents = (*parents, (b.number, -1.0))
        difference = self.tape.node(CONTEXT.subtract(self.value, b.value), parents, error)
        self.tape.compared.append(difference)

    def __lt__(self, other: Plain) -> bool:
        self._compare(other)
        return self.value < Rounded.of(other).value

    def __gt__(self, other: Plain) -> bool:
        self._compare(other)
        return self.value > Rounded.of(other).value


def norm(vector: Sequence[Rounded]) -> Rounded:
    """Return the Euclidean norm, whose derivatives are at most 1, also where it vanishes."""
    value = CONTEXT.sqrt(sum((CONTEXT.multiply(v.value, v.value) for v in vector), ZERO))
    tracked = [v for v in vector if isinstance(v, Tracked)]
    even = float(CONTEXT.sqrt(CONTEXT.divide(Decimal(1), Decimal(len(vector)))))
    parents = tuple(
        (v.number, even if value == 0 else float(CONTEXT.divide(v.value, value))) for v in tracked
    )
    rounding = CONTEXT.multiply(Decimal(len(vector)), value)
    if not tracked:
        return Rounded(value, rounding)
    return tracked[0].tape.node(value, parents, rounding)


def smaller(a: Rounded, b: Rounded) -> Rounded:
    """Return min(a, b); this is continuous, so no decision is noted.

    Near a tie a port may return the other number, with an error that is larger by that of a - b.
    """
    least, difference = (a if a.value <= b.value else b), a - b
    if not isinstance(least, Tracked) or not isinstance(difference, Tracked):
        return least
    error = least.tape.error(difference)
    near = abs(difference.value) <= CONTEXT.multiply(error, NEAR)
    return least.more(error) if near else least
