"""Vectors of integers of Python, which have no largest value, so nothing is rounded."""

from __future__ import annotations

from math import hypot
from typing import Any, TypeAlias

import numpy as np

from izo_ref.base.arrays import Floats

Point: TypeAlias = tuple[int, int, int]

NOWHERE: Point = (0, 0, 0)  # the zero vector

# Bits of the largest coordinate of a vector that are kept when it becomes a unit vector. Its length
# then neither overflows nor underflows.
KEPT_BITS = 64


def integer_points(points: Any) -> list[Point]:
    """Return points times one power of two that makes all their coordinates integers.

    Args:
        points: (n, 3) f8, finite.
    """
    ratios = [[float(x).as_integer_ratio() for x in point] for point in points]
    unit = max((denominator for row in ratios for _, denominator in row), default=1)
    rows = ([n * (unit // d) for n, d in row] for row in ratios)
    return [(x, y, z) for x, y, z in rows]


def minus(a: Point, b: Point) -> Point:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def dot(a: Point, b: Point) -> int:
    """Return the scalar product of a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Point, b: Point) -> Point:
    """Return the cross product of a and b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def unit_vector(normal: Point) -> Floats:
    """Return the unit vector of a vector of integers that is not zero, however large they are."""
    excess = max(0, max(map(abs, normal)).bit_length() - KEPT_BITS)
    x, y, z = (float(c >> excess) for c in normal)
    return np.array((x, y, z)) / hypot(x, y, z)
