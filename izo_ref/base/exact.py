"""Decide exactly which pairs of points, edges and faces meet, for many pairs at once.

Floats are rational numbers. Multiplied by one power of two, all coordinates of a pair are integers.
Python's integers have no largest value, and numpy applies their operations to whole arrays of
objects. So nothing below is rounded.

`_volume_signs`, `_coplanar_meet` and `_collinear_meet` are the ways in which four points can lie:
not in one plane, in one plane, or on one line.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from izo_ref.base.arrays import Flags, Floats
from izo_ref.base.deadline import UNLIMITED, Deadline

# (n, 3), or (n,) for one coordinate: integers of Python
Integers: TypeAlias = NDArray[np.object_]
Signs: TypeAlias = NDArray[np.int8]

# Pairs that are decided at once. A pair takes some 2 kB of integers.
CHUNK = 8192


def sides_meet(first: Floats, second: Floats, deadline: Deadline = UNLIMITED) -> Flags:
    """Return which pairs of sides have a point in common, exactly; a side may be degenerate.

    Sides that have a vertex at the same place meet. Comparing coordinates settles almost every
    pair of meshes that coincide, at seams or in whole layers. Integers decide the other pairs.

    Args:
        first: (n, k, 3) f8, finite positions of the k vertices of each first side.
        second: (n, l, 3) f8, of each second side. The sides are a vertex and a face (k = 1,
            l = 3), two edges (k = l = 2), or an edge and a face (k = 2, l = 3).
        deadline: When the decisions have to end.

    Returns:
        (n,) b1.
    """
    meet = _share_place(first, second)
    left, split = np.flatnonzero(~meet), first.shape[1]
    decide = _edge_face_meet if split + second.shape[1] == 5 else _four_meet
    for begin in deadline.checked(range(0, len(left), CHUNK)):
        own = left[begin : begin + CHUNK]
        points = _integers_of(np.concatenate((first[own], second[own]), axis=1))
        meet[own] = decide(split == 2, points)
    return meet


def volume_signs(points: Floats, deadline: Deadline = UNLIMITED) -> Signs:
    """Return the sign of det(b - a, c - a, d - a) for each row of four points, exactly, (n,) i1.

    Args:
        points: (n, 4, 3) f8, finite.
        deadline: When the decisions have to end.
    """
    signs = [
        _volume_signs(*_integers_of(points[begin : begin + CHUNK]))
        for begin in deadline.checked(range(0, len(points), CHUNK))
    ]
    return np.concatenate(signs) if signs else np.empty(0, np.int8)


def _share_place(first: Floats, second: Floats) -> Flags:
    """Return which pairs have a vertex of the first side exactly at a vertex of the second."""
    shared = np.zeros(len(first), bool)
    for k in range(first.shape[1]):
        for m in range(second.shape[1]):
            a, b = first[:, k], second[:, m]
            shared |= (a[:, 0] == b[:, 0]) & (a[:, 1] == b[:, 1]) & (a[:, 2] == b[:, 2])
    return shared


def _integers_of(points: Floats) -> list[Integers]:
    """Return the coordinates as integers, (n, 3) for each vertex.

    Each row of `points` is multiplied by a power of two of its own, which changes no answer.

    Args:
        points: (n, k, 3) f8, finite.
    """
    mantissas, exponents = np.frexp(points)
    mantissas = np.ldexp(mantissas, 53).astype(np.int64).astype(object)
    exponents = np.where(points == 0.0, np.int32(2000), exponents)  # zero has any exponent
    lowest = exponents.min(axis=(1, 2), keepdims=True)
    shifts = np.where(points == 0.0, 0, exponents - lowest).astype(object)
    return list((mantissas << shifts).transpose(1, 0, 2))


def _signs_of(numbers: Integers) -> Signs:
    return (numbers > 0).astype(np.int8) - (numbers < 0).astype(np.int8)


def _turns(u: Integers, v: Integers, axis: int) -> Integers:
    """Return one coordinate of the cross product of each u and v, (n,)."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    return u[:, i] * v[:, j] - u[:, j] * v[:, i]


def _volume_signs(p: Integers, a: Integers, b: Integers, c: Integers) -> Signs:
    """Return the sign of det(a - p, b - p, c - p) for each row, (n,)."""
    u, v, w = a - p, b - p, c - p
    x, y, z = (u[:, axis] * _turns(v, w, axis) for axis in range(3))
    return _signs_of(x + y + z)


def _edge_face_meet(_: bool, points: list[Integers]) -> Flags:
    """Return which edges p q meet their face a b c.

    * The ends are strictly on the same side of the plane of the face: apart.
    * The ends are strictly on different sides: the line of the edge crosses the plane in one point.
      It is in the face if it is strictly outside none of its sides. On which side of the line a b
      it is, the sign of the volume of p, q, a, b says.
    * An end is in the plane, or the face has no area: the pair meets if an end is in the face, or
      if the edge meets a side of the face.
    """
    p, q, a, b, c = points
    sides = _volume_signs(p, a, b, c) * _volume_signs(q, a, b, c)
    meet = np.zeros(len(p), bool)

    across = np.flatnonzero(sides < 0)
    p1, q1, *corners = (point[across] for point in points)
    turns = [_volume_signs(p1, q1, corners[k], corners[(k + 1) % 3]) for k in range(3)]
    meet[across] = (np.minimum.reduce(turns) >= 0) | (np.maximum.reduce(turns) <= 0)

    for is_edge_edge, nodes in (
        (False, (0, 2, 3, 4)),
        (False, (1, 2, 3, 4)),
        (True, (0, 1, 2, 3)),
        (True, (0, 1, 3, 4)),
        (True, (0, 1, 4, 2)),
    ):
        left = np.flatnonzero((sides == 0) & ~meet)
        meet[left] = _four_meet(is_edge_edge, [points[node][left] for node in nodes])
    return meet


def _four_meet(is_edge_edge: bool, points: list[Integers]) -> Flags:
    """Return which vertices meet their face, or which edges meet their other edge."""
    meet = _volume_signs(*points) == 0
    flat = np.flatnonzero(meet)
    origin, *others = (point[flat] for point in points)
    meet[flat] = _coplanar_meet(is_edge_edge, *(point - origin for point in others))
    return meet


def _coplanar_meet(is_edge_edge: bool, e1: Integers, e2: Integers, e3: Integers) -> Flags:
    """Return which pairs meet, whose four nodes are in one plane.

    The arguments are nodes 1 to 3 relative to node 0. The signs are those of the areas of the
    nodes 0 1 2, 0 2 3, 0 3 1 and 1 2 3, seen along an axis along which one of the first three is
    not zero. Along it the plane is not edge-on, so a sign says on which side of a line a node is.
    """
    meet = np.zeros(len(e1), bool)
    left = np.arange(len(e1))
    for axis in range(3):
        areas = [_turns(u[left], v[left], axis) for u, v in ((e1, e2), (e2, e3), (e3, e1))]
        s012, s023, s031 = (_signs_of(area) for area in areas)
        s123 = _signs_of(areas[0] + areas[1] + areas[2])
        if is_edge_edge:  # the ends of neither edge are strictly on one side of the other edge
            meet[left] = (s012 * s031 >= 0) & (s023 * s123 <= 0)
        else:  # the face has an area, and the vertex is strictly outside none of its edges
            inside = np.minimum.reduce((s012 * s123, s023 * s123, s031 * s123)) >= 0
            meet[left] = (s123 != 0) & inside
        left = left[(s012 == 0) & (s023 == 0) & (s031 == 0)]
    meet[left] = _collinear_meet(is_edge_edge, e1[left], e2[left], e3[left])
    return meet


def _collinear_meet(is_edge_edge: bool, e1: Integers, e2: Integers, e3: Integers) -> Flags:
    """Return which pairs meet, whose four nodes are on one line; node 0 is the origin.

    Along an axis along which the nodes differ, the sides are intervals. They meet unless one ends
    before the other begins. Nodes that differ along no axis are in one point.
    """
    meet = np.ones(len(e1), bool)
    for axis in range(3):
        x1, x2, x3 = e1[:, axis], e2[:, axis], e3[:, axis]
        first, second = ([0 * x1, x1], [x2, x3]) if is_edge_edge else ([0 * x1], [x1, x2, x3])
        ends = [_range_of(side) for side in (first, second)]
        meet &= (ends[0][0] <= ends[1][1]) & (ends[1][0] <= ends[0][1])
    return meet


def _range_of(coordinates: list[Any]) -> tuple[Integers, Integers]:
    """Return the lowest and the highest coordinates of each row."""
    return np.minimum.reduce(coordinates), np.maximum.reduce(coordinates)
