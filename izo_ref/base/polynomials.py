"""Polynomials with integer coefficients, in exact arithmetic.

A polynomial is a list of integers, the constant first, without zeros at the end; the zero
polynomial is the empty list. Positive factors do not matter here, because only signs and roots are
asked for, so common factors of the coefficients are taken out. Fractions would be several times
slower.

A number is given as number / unit, two integers with unit > 0.

Source: S. Basu, R. Pollack, M.-F. Roy, Algorithms in Real Algebraic Geometry (2006), 2.2 and 10.
"""

from itertools import pairwise
from math import comb, gcd, lcm
from typing import TypeAlias

Polynomial: TypeAlias = list[int]


def trimmed(poly: Polynomial) -> Polynomial:
    """Remove the zeros at the end of a list, and return it."""
    while poly and poly[-1] == 0:
        poly.pop()
    return poly


def add(a: Polynomial, b: Polynomial, sign: int = 1) -> Polynomial:
    """Return a + sign b."""
    n = max(len(a), len(b))
    a, b = a + [0] * (n - len(a)), b + [0] * (n - len(b))
    return trimmed([x + sign * y for x, y in zip(a, b, strict=True)])


def multiply(a: Polynomial, b: Polynomial) -> Polynomial:
    """Return the product of two polynomials."""
    product = [0] * max(len(a) + len(b) - 1, 0)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            product[i + j] += x * y
    return trimmed(product)


def cross(a: list[Polynomial], b: list[Polynomial]) -> list[Polynomial]:
    """Return the cross product of two vectors of three polynomials."""
    return [
        add(multiply(a[j], b[k]), multiply(a[k], b[j]), -1) for j, k in ((1, 2), (2, 0), (0, 1))
    ]


def value(poly: Polynomial, number: int, unit: int) -> int:
    """Return the value of a polynomial at number / unit, times a power of unit."""
    result, power = 0, 1
    for coefficient in reversed(poly):
        result = result * number + coefficient * power
        power *= unit
    return result


def sign_of(number: int) -> int:
    """Return the sign of a number: -1, 0 or 1."""
    return (number > 0) - (number < 0)


def primitive(poly: Polynomial) -> Polynomial:
    """Return a polynomial without the common factor of its coefficients."""
    divisor = gcd(*poly)
    return [c // divisor for c in poly] if divisor > 1 else poly


def remainder(a: Polynomial, b: Polynomial) -> Polynomial:
    """Return the remainder of a divided by b, times a positive factor."""
    rest, size, sign = list(a), abs(b[-1]), sign_of(b[-1])
    while len(rest) >= len(b):
        factor = sign * rest[-1]
        shift = len(rest) - len(b)
        rest = [size * c for c in rest]
        for i, c in enumerate(b):
            rest[shift + i] -= factor * c
        rest.pop()
    return primitive(trimmed(rest))


def quotient(a: Polynomial, b: Polynomial) -> Polynomial:
    """Return a divided by b, where b is a primitive divisor of a.

    The coefficients of the quotient are integers, by Gauss's lemma.
    """
    rest, result = list(a), []
    while len(rest) >= len(b):
        result.append(rest[-1] // b[-1])
        for i in range(1, len(b) + 1):
            rest[-i] -= result[-1] * b[-i]
        rest.pop()
    return result[::-1]


def common_divisor(a: Polynomial, b: Polynomial) -> Polynomial:
    """Return the greatest common divisor of two polynomials, up to a factor, in primitive form."""
    while b:
        a, b = b, remainder(a, b)
    return primitive(a)


def derivative(poly: Polynomial) -> Polynomial:
    """Return the derivative of a polynomial."""
    return [i * c for i, c in enumerate(poly)][1:]


def sturm_chain(square_free: Polynomial) -> list[Polynomial]:
    """Return the Sturm chain of a polynomial without multiple roots."""
    chain = [square_free, derivative(square_free)]
    while chain[-1]:
        chain.append([-c for c in remainder(chain[-2], chain[-1])])
    return chain[:-1]


def count_roots(chain: list[Polynomial], low: int, high: int, unit: int) -> int:
    """Return the number of roots in (low / unit, high / unit], by Sturm's theorem."""
    changes = []
    for number in (low, high):
        signs = [s for s in (sign_of(value(p, number, unit)) for p in chain) if s]
        changes.append(sum(a != b for a, b in pairwise(signs)))
    return changes[0] - changes[1]


def bernstein(poly: Polynomial, low: int, high: int, unit: int) -> list[int]:
    """Return the Bernstein coefficients on [low, high] / unit, times a positive factor."""
    degree, width = len(poly) - 1, high - low
    powers = [
        sum(
            poly[k] * comb(k, i) * low ** (k - i) * unit ** (degree - k)
            for k in range(i, degree + 1)
        )
        * width**i
        for i in range(degree + 1)
    ]
    binomials = [comb(degree, i) for i in range(degree + 1)]
    factor = lcm(*binomials)
    return [
        sum(comb(j, i) * powers[i] * (factor // binomials[i]) for i in range(j + 1))
        for j in range(degree + 1)
    ]
