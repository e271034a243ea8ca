"""Numbers that carry a bound of their rounding: what a formula can lose at most, step by step."""

import builtins
import math
from types import FunctionType

U = 2.0**-53


class Bounded:
    """A float of which a bound of the size is known, and a bound of the error.

    Each operation adds one rounding, of u times the size of its result, unless it is exact. A
    comparison with a positive float is true; it notes the error beside the float, because the
    formula takes the float for a bound of the error. Of two of these numbers, the one with the
    larger error is the larger and the smaller one, so that `min` and `max` keep the larger error.

    Attributes:
        size: Bound of the absolute value.
        error: Bound of the absolute error of the computed value.
        value: The exact value, if it is known, else None.
        notes: The pairs of an error and a bound that were compared; shared by all numbers.
    """

    def __init__(self, size, error, notes, value=None):
        """Make a number; a known value is its own size."""
        self.size, self.error, self.notes, self.value = size, error, notes, value

    def _other(self, other):
        if isinstance(other, Bounded):
            return other
        return Bounded(abs(other), 0.0, self.notes, other)

    def _rounded(self, size, error, value):
        size = size if value is None else abs(value)
        return Bounded(size, error + U * size, self.notes, value)

    def __add__(self, other):
        other = self._other(other)
        value = None if self.value is None or other.value is None else self.value + other.value
        return self._rounded(self.size + other.size, self.error + other.error, value)

    def __sub__(self, other):
        return self + -self._other(other)

    def __rsub__(self, other):
        return self._other(other) - self

    def __neg__(self):
        return Bounded(
            self.size, self.error, self.notes, None if self.value is None else -self.value
        )

    def __mul__(self, other):
        other = self._other(other)
        value = None if self.value is None or other.value is None else self.value * other.value
        error = self.error * other.size + other.error * self.size
        for one in (self, other):
            if one.value is not None and abs(math.frexp(one.value)[0]) == 0.5:  # a power of two
                return Bounded(self.size * other.size, error, self.notes, value)
        return self._rounded(self.size * other.size, error, value)

    def __truediv__(self, other):
        assert isinstance(other, float), "only quotients by constants have a bound"
        size = self.size / abs(other)
        return Bounded(size, self.error / abs(other) + U * size, self.notes)

    __radd__, __rmul__ = __add__, __mul__

    def __abs__(self):
        return self.size

    def _compare(self, other):
        if isinstance(other, Bounded):
            return self.error > other.error
        if other != 0.0:
            self.notes.append((self.error, abs(other)))
        return True

    __lt__ = __gt__ = __le__ = __ge__ = _compare


def pure(function, replaced=None):
    """Return a compiled function, and all that it calls, as functions of Python.

    Args:
        function: A function that `compiled` made, or one of Python.
        replaced: Functions that take the place of those with the same names.
    """
    python = getattr(function, "py_func", function)
    if not isinstance(python, FunctionType):
        return function
    own = python.__globals__ | (replaced or {})
    used = {name: own[name] for name in python.__code__.co_names if name in own}
    called = {
        name: pure(value, replaced)
        if callable(value) and value not in (replaced or {}).values()
        else value
        for name, value in used.items()
    }
    return FunctionType(
        python.__code__, {"__builtins__": builtins, **called}, python.__name__, python.__defaults__
    )
