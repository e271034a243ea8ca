"""The closest points of a pair at rest, in exact arithmetic.

Closer than rounding can tell, the vector between the closest points is noise in floats. Here all
coordinates are integers, by one power of two, and divisions give fractions.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any, TypeAlias

from izo_ref.base.arrays import Floats
from izo_ref.base.exact_vectors import (
    NOWHERE,
    Point,
    cross,
    dot,
    integer_points,
    minus,
    unit_vector,
)

# A vector times a positive integer: the coordinates, and that integer.
Scaled: TypeAlias = tuple[Point, int]


def exact_normal(is_edge_edge: bool, points: Any) -> Floats | None:
    """Return the unit vector from the closest point of the second side to that of the first, (3,).

    Args:
        is_edge_edge: True for two edges, False for a vertex and a face.
        points: (4, 3) f8, finite positions of the nodes, as for `first_meeting`.

    Returns:
        The unit vector, rounded to floats; None if the sides touch.
    """
    vector, _ = min(_candidates(is_edge_edge, *integer_points(points)), key=_length_sq)
    return None if vector == NOWHERE else unit_vector(vector)


def _candidates(is_edge_edge: bool, p: Point, q: Point, r: Point, s: Point) -> list[Scaled]:
    """Return vectors between points of the two sides; the shortest one is among them."""
    if is_edge_edge:
        ends = [_to_segment(p, r, s), _to_segment(q, r, s)]
        ends += [_back(_to_segment(r, p, q)), _back(_to_segment(s, p, q))]
        u, w, between = minus(q, p), minus(s, r), minus(r, p)
        normal = cross(u, w)
        whole = dot(normal, normal)
        along_u, along_w = dot(cross(between, w), normal), dot(cross(between, u), normal)
        if whole and 0 <= along_u <= whole and 0 <= along_w <= whole:
            ends.append(_along(normal, minus(p, r)))
        return ends
    ends = [_to_segment(p, q, r), _to_segment(p, r, s), _to_segment(p, s, q)]
    normal = cross(minus(r, q), minus(s, q))
    sides = [dot(normal, cross(minus(b, a), minus(p, a))) for a, b in ((q, r), (r, s), (s, q))]
    if normal != NOWHERE and min(sides) >= 0:
        ends.append(_along(normal, minus(p, q)))
    return ends


def _to_segment(p: Point, a: Point, b: Point) -> Scaled:
    """Return the vector from the closest point of segment a b to p."""
    edge, from_a = minus(b, a), minus(p, a)
    whole, part = dot(edge, edge), dot(from_a, edge)
    if part <= 0 or whole == 0:
        return from_a, 1
    if part >= whole:
        return minus(p, b), 1
    x, y, z = (whole * c - part * e for c, e in zip(from_a, edge, strict=True))
    return (x, y, z), whole


def _along(normal: Point, vector: Point) -> Scaled:
    """Return the part of a vector along a normal."""
    height = dot(normal, vector)
    return (height * normal[0], height * normal[1], height * normal[2]), dot(normal, normal)


def _back(scaled: Scaled) -> Scaled:
    (x, y, z), factor = scaled
    return (-x, -y, -z), factor


def _length_sq(scaled: Scaled) -> Fraction:
    vector, factor = scaled
    return Fraction(dot(vector, vector), factor * factor)
