"""Algebraic times: roots of polynomials in [0, 1], and exact signs of polynomials there.

**Algebraic times.** An algebraic time is a polynomial without multiple roots, and an interval
(low, high] that holds exactly one of its roots, by Sturm's theorem.

**Signs at an algebraic time.** The Bernstein coefficients of a polynomial on the interval enclose
its values there. Once they have one strict sign, this is the sign at the time. Until then the
interval is halved. If the polynomial is zero at the time, this never ends. So `sign_at` tests for
that case once the interval is narrow: the polynomial is zero at the time if and only if its
greatest common divisor with the polynomial of the time has a root in the interval.

Source: S. Basu, R. Pollack, M.-F. Roy, Algorithms in Real Algebraic Geometry (2006), 2.2 and 10.
"""

from fractions import Fraction
from math import nextafter

from izo_ref.base.polynomials import (
    Polynomial,
    bernstein,
    common_divisor,
    count_roots,
    derivative,
    primitive,
    quotient,
    sign_of,
    sturm_chain,
    value,
)

# The time of a meeting is enclosed in an interval of width 2^-54, half the spacing of floats just
# below 1.
TIME_BITS = 54
# A sign that is not certain on an interval of width 2^-40 is tested for zero.
ZERO_BITS = 40


class AlgebraicTime:
    """A root of a polynomial without multiple roots, enclosed in an interval.

    The root is the only one in (low / unit, high / unit]; if low = high, it is that number. Whoever
    needs a narrower interval calls `halve`.

    Args:
        polynomial: A polynomial without multiple roots.
        low: Numerator of the lower end of the interval.
        high: Numerator of the upper end.
        unit: Denominator of both, a power of two.

    Attributes:
        polynomial: As passed in.
        low: Numerator of the lower end of the interval, so far.
        high: Numerator of the upper end.
        unit: Denominator of both.
    """

    def __init__(self, polynomial: Polynomial, low: int, high: int, unit: int) -> None:
        """Take a polynomial and an interval with one of its roots."""
        self.polynomial = polynomial
        self.low, self.high, self.unit = low, high, unit
        self._settle()

    def _settle(self) -> None:
        """Shrink the interval to its upper end if the root is there."""
        if value(self.polynomial, self.high, self.unit) == 0:
            self.low = self.high

    def is_narrower(self, bits: int) -> bool:
        """Return whether the interval is not wider than 2^-bits."""
        return (self.high - self.low) << bits <= self.unit

    def halve(self) -> None:
        """Keep the half of the interval that has the root."""
        middle = self.low + self.high
        self.low, self.high, self.unit = 2 * self.low, 2 * self.high, 2 * self.unit
        # The root is simple, so the polynomial changes its sign there, and nowhere else inside the
        # interval.
        at_middle = sign_of(value(self.polynomial, middle, self.unit))
        if at_middle in (0, sign_of(value(self.polynomial, self.high, self.unit))):
            self.high = middle
            self._settle()
        else:
            self.low = middle


def roots_in_unit_interval(poly: Polynomial) -> list[AlgebraicTime]:
    """Return the different roots in [0, 1] of a polynomial that is not zero, in ascending order."""
    poly = primitive(poly)
    if len(poly) > 2:
        poly = quotient(poly, common_divisor(poly, derivative(poly)))
    chain = sturm_chain(poly)
    found = []
    if poly[0] == 0:
        found.append(AlgebraicTime(poly, 0, 0, 1))
    parts = [(0, 1, 1)]
    while parts:
        low, high, unit = parts.pop()
        count = count_roots(chain, low, high, unit)
        if count == 1:
            found.append(AlgebraicTime(poly, low, high, unit))
        elif count > 1:
            middle = low + high
            parts += [(middle, 2 * high, 2 * unit), (2 * low, middle, 2 * unit)]
    return found


def sign_at(poly: Polynomial, time: AlgebraicTime) -> int:
    """Return the sign of a polynomial at an algebraic time: -1, 0 or 1."""
    if not poly:
        return 0
    may_be_zero = True
    while time.low != time.high:
        coefficients = bernstein(poly, time.low, time.high, time.unit)
        if min(coefficients) > 0 or max(coefficients) < 0:
            return sign_of(coefficients[0])
        if may_be_zero and time.is_narrower(ZERO_BITS):
            common = common_divisor(time.polynomial, poly)
            if len(common) > 1:
                # it divides a polynomial without multiple roots, so it has none either
                chain = sturm_chain(common)
                if count_roots(chain, time.low, time.high, time.unit):
                    return 0
            may_be_zero = False
        time.halve()
    return sign_of(value(poly, time.high, time.unit))


def float_below(time: AlgebraicTime) -> float:
    """Return a float that is not after the time, and at most 2^-52 before it."""
    while not time.is_narrower(TIME_BITS):
        time.halve()
    number = Fraction(time.low, time.unit)
    result = float(number)
    return result if result <= number else nextafter(result, 0.0)
