"""Vectors of three numbers as plain tuples, which are registers on every target."""

import math

from izo_ref.base.arrays import Vec3
from izo_ref.base.compile import compiled


@compiled
def sub3(a: Vec3, b: Vec3) -> Vec3:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@compiled
def scale3(s: float, a: Vec3) -> Vec3:
    """Return s a."""
    return (s * a[0], s * a[1], s * a[2])


@compiled
def dot3(a: Vec3, b: Vec3) -> float:
    """Return the scalar product a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross3(a: Vec3, b: Vec3) -> Vec3:
    """Return the cross product a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@compiled
def det3(a: Vec3, b: Vec3, c: Vec3) -> float:
    """Return the determinant of three vectors, a . (b x c)."""
    return dot3(a, cross3(b, c))


@compiled
def lerp3(a: Vec3, b: Vec3, t: float) -> Vec3:
    """Return (1 - t) a + t b: exactly a at t = 0 and exactly b at t = 1."""
    s = 1.0 - t
    return (s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2])


@compiled
def max_abs3(a: Vec3) -> float:
    """Return the largest absolute coordinate."""
    return max(abs(a[0]), max(abs(a[1]), abs(a[2])))


@compiled
def sum_abs3(a: Vec3) -> float:
    """Return the sum of the absolute coordinates."""
    return abs(a[0]) + abs(a[1]) + abs(a[2])


@compiled
def power_of_two_for(size: float) -> float:
    """Return the power of two, at most 2^1000, that scales a positive size into [1/2, 1).

    Multiplying by it is exact.
    """
    return math.ldexp(1.0, min(-math.frexp(size)[1], 1000))


@compiled
def unit3(a: Vec3) -> Vec3:
    """Return a / |a|, without overflow or underflow; the zero vector stays zero."""
    largest = max_abs3(a)
    if largest == 0.0:
        return a
    b = (a[0] / largest, a[1] / largest, a[2] / largest)
    return scale3(1.0 / math.sqrt(dot3(b, b)), b)
