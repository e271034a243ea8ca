"""Tell on which side of each other the two sides of a touching pair are, exactly.

A pair that touches at the start may leave its contact on either side, unless the mesh tells which
one: the faces around the contact are then on the two sides of a plane through it.

**Features.** The contact of a pair is a point of one feature of each side: a vertex, the inside of
an edge, or the inside of a face. Two edges on one line may share more than a point; their features
are then the whole edges.

**Stars.** The star of a feature are the faces around it: those that contain all of its vertices.
Near the contact, the surface of a side is its star.

**Planes.** Let n be orthogonal to both features. The plane through the contact with this normal
separates the stars if the corners of the first one have n . x >= 0, and those of the second one
n . x <= 0, relative to the contact. It tells a side if not all of these numbers are zero. The
normals that separate form a cone, whose extreme rays are orthogonal to two of these corners, or to
a corner and a feature. So the candidates are the cross products of all of them. If everything is in
one plane, they are the directions in it that are orthogonal to a corner. Where several candidates
tell a side, so does the sum of their unit vectors, which is farther from both stars: two faces of a
ball that touch along an edge are pushed apart within the surface.

**Crossing.** If the features alone determine the plane, which is so for a vertex inside a face and
for two edges that are not parallel, and the plane does not separate the stars, then the surfaces go
through each other at the contact.

All coordinates are integers, by one power of two for the mesh, so nothing below is rounded.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum
from fractions import Fraction
from itertools import combinations, product
from typing import NamedTuple, TypeAlias

import numpy as np

from izo_ref.base.arrays import Faces, Floats, Nodes, Positions
from izo_ref.base.exact_vectors import (
    NOWHERE,
    Point,
    cross,
    dot,
    integer_points,
    minus,
    unit_vector,
)
from izo_ref.base.polynomials import sign_of

Feature: TypeAlias = tuple[int, ...]  # vertices: one, the two of an edge, or the three of a face


class Side(IntEnum):
    """What the mesh tells about a pair that touches."""

    TOLD = 0  # the first side is on the side of `normal`
    UNTOLD = 1
    CROSSING = 2  # the surfaces go through each other


class Contact(NamedTuple):
    """Where the two sides of a pair touch.

    Attributes:
        first: The feature of the first side that holds the point of contact.
        second: The feature of the second side.
        weights: Four weights of the point, positive on the first side, negative on the second.
    """

    first: Feature
    second: Feature
    weights: list[Fraction]


class Sides:
    """Tells the sides of pairs of a mesh that touch at rest.

    Args:
        positions: (n_vertices, 3) f8, finite.
        faces: (n_faces, 3) i4.
        nodes: (n, 4) i4, the nodes of all pairs that will be asked about.
    """

    def __init__(self, positions: Positions, faces: Faces, nodes: Nodes) -> None:
        """Collect the faces around the nodes."""
        touched = np.zeros(len(positions), bool)
        touched[nodes] = True
        self._faces_at: dict[int, list[Feature]] = {}
        for row in faces[touched[faces].any(axis=1)].tolist():
            for vertex in row:
                self._faces_at.setdefault(vertex, []).append(tuple(row))
        used = sorted({*self._faces_at, *np.unique(nodes).tolist()})
        self._points = dict(zip(used, integer_points(positions[used]), strict=True))
        self._answers: dict[tuple[Feature, Feature], tuple[Side, Floats]] = {}

    def contact(self, is_edge_edge: bool, nodes: list[int]) -> Contact | None:
        """Return where a pair touches, or None if a side is degenerate.

        Args:
            is_edge_edge: True for two edges, False for a vertex and a face.
            nodes: The four nodes of a pair that touches.
        """
        points = [self._points[node] for node in nodes]
        weights = (_edge_edge_weights if is_edge_edge else _vertex_face_weights)(*points)
        if weights is None:
            return None
        split = 2 if is_edge_edge else 1
        used = [node for node, weight in zip(nodes, weights, strict=True) if weight]
        first = tuple(node for node in used if node in nodes[:split])
        return Contact(first, tuple(node for node in used if node in nodes[split:]), weights)

    def side(self, contact: Contact) -> tuple[Side, Floats]:
        """Return what the mesh tells about a contact, and the normal, (3,) f8.

        The normal is a unit vector from the second side to the first one if a side is told, else
        zero.
        """
        features = contact.first, contact.second
        if features not in self._answers:
            self._answers[features] = self._decide(*features)
        return self._answers[features]

    def _decide(self, first: Feature, second: Feature) -> tuple[Side, Floats]:
        """Return what the stars of two features tell, and the unit normal."""
        star, other = self._star(first), self._star(second)
        own = self._own_normal(first, second)
        candidates = self._normals(first, second, star, other) if own is None else [own]
        told, all_flat = np.zeros(3), True
        for normal in candidates:
            signs = [sign_of(dot(normal, v)) for v in star]
            others = [sign_of(dot(normal, v)) for v in other]
            if not (any(signs) or any(others)):
                continue
            all_flat = False
            if min(signs, default=0) >= 0 >= max(others, default=0):
                told += unit_vector(normal)
            elif max(signs, default=0) <= 0 <= min(others, default=0):
                told -= unit_vector(normal)
        if told.any():
            return Side.TOLD, told / np.linalg.norm(told)
        crossing = own is not None and not all_flat
        return Side.CROSSING if crossing else Side.UNTOLD, told

    def _star(self, feature: Feature) -> list[Point]:
        """Return the other corners of the faces around a feature, relative to its first vertex."""
        corners = {corner for face in self._faces_around(feature) for corner in face}
        return [self._edge(feature[0], corner) for corner in sorted(corners - set(feature))]

    def _own_normal(self, first: Feature, second: Feature) -> Point | None:
        """Return the normal that the features determine; None if they leave more than one."""
        if len(second) == 3:
            return cross(self._edge(second[0], second[1]), self._edge(second[0], second[2]))
        if len(first) == len(second) == 2:
            normal = cross(self._edge(*first), self._edge(*second))
            return None if normal == NOWHERE else normal
        return None

    def _normals(
        self, first: Feature, second: Feature, star: list[Point], other: list[Point]
    ) -> Iterator[Point]:
        """Yield the directions that are orthogonal to both features and may separate the stars."""
        edges = [self._edge(*feature) for feature in (first, second) if len(feature) == 2]
        corners = star + other
        # every normal is orthogonal to a feature that is an edge
        pairs = product(edges[:1], corners) if edges else combinations(corners, 2)
        normals = [normal for normal in (cross(u, v) for u, v in pairs) if normal != NOWHERE]
        if not normals:
            return
        plane = normals[0]
        if not any(dot(plane, v) for v in edges + corners):
            normals = [cross(plane, v) for v in (edges or corners)]
        for normal in normals:
            if not any(dot(normal, edge) for edge in edges):
                yield normal

    def _faces_around(self, feature: Feature) -> list[Feature]:
        around = self._faces_at.get(feature[0], [])
        return [face for face in around if set(feature) <= set(face)]

    def _edge(self, a: int, b: int) -> Point:
        return minus(self._points[b], self._points[a])


def _vertex_face_weights(v: Point, a: Point, b: Point, c: Point) -> list[Fraction] | None:
    """Return the weights of a vertex that is in its face; None if the face has no area."""
    normal = cross(minus(b, a), minus(c, a))
    if normal == NOWHERE:
        return None
    whole = dot(normal, normal)
    to_a, to_b, to_c = minus(a, v), minus(b, v), minus(c, v)
    areas = (dot(normal, cross(x, y)) for x, y in ((to_b, to_c), (to_c, to_a), (to_a, to_b)))
    return [Fraction(1), *(Fraction(-area, whole) for area in areas)]


def _edge_edge_weights(p: Point, q: Point, r: Point, s: Point) -> list[Fraction] | None:
    """Return the weights of a point that two edges share; None if an edge has no length.

    If the edges have a line in common, it is the middle of the part that they share.
    """
    u, w = minus(q, p), minus(s, r)
    if NOWHERE in (u, w):
        return None
    normal = cross(u, w)
    if normal != NOWHERE:
        whole, between = dot(normal, normal), minus(r, p)
        along_u = Fraction(dot(cross(between, w), normal), whole)
        along_w = Fraction(dot(cross(between, u), normal), whole)
    else:
        length_sq = dot(u, u)
        ends = [Fraction(dot(minus(x, p), u), length_sq) for x in (r, s)]
        low, high = max(Fraction(0), min(ends)), min(Fraction(1), max(ends))
        along_u = (low + high) / 2
        along_w = (along_u - ends[0]) / (ends[1] - ends[0])
    return [1 - along_u, along_u, along_w - 1, -along_w]
