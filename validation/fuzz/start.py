"""Whether a mesh intersects itself at the start, by all pairs, in rational numbers."""

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np

from validation.oracles import path as path_oracle


def start_meets(positions: Any, faces: Sequence[Sequence[int]]) -> bool:
    """Return whether a mesh intersects or touches itself, by all pairs, in exact arithmetic."""
    points = np.array(positions, float)
    edges = sorted({edge for face in faces for edge in combinations(sorted(face), 2)})
    pairs = [(False, (v, *f)) for v in range(len(points)) for f in faces if v not in f]
    pairs += [(True, (*a, *b)) for a, b in combinations(edges, 2) if not set(a) & set(b)]
    for is_edge_edge, nodes in pairs:
        corners = points[list(nodes)]
        if path_oracle.meets(is_edge_edge, corners, corners):
            return True
    through = [(e, f) for e in edges for f in faces if not set(e) & set(f)]
    exact = [[Fraction(float(x)) for x in point] for point in points]
    return any(_goes_through([exact[v] for v in e], [exact[v] for v in f]) for e, f in through)


def _goes_through(edge: list[list[Fraction]], face: list[list[Fraction]]) -> bool:
    """Return whether the ends of an edge are on two sides of a face that it goes through."""
    (p, q), (a, b, c) = edge, face
    if _side(a, b, c, p) * _side(a, b, c, q) >= 0:
        return False
    sides = [_side(p, q, a, b), _side(p, q, b, c), _side(p, q, c, a)]
    return all(s >= 0 for s in sides) or all(s <= 0 for s in sides)


def _side(a: list[Fraction], b: list[Fraction], c: list[Fraction], d: list[Fraction]) -> Fraction:
    """Return six times the signed volume of a tetrahedron."""
    u, v, w = ([x - y for x, y in zip(p, a, strict=True)] for p in (b, c, d))
    return (
        u[0] * (v[1] * w[2] - v[2] * w[1])
        - u[1] * (v[0] * w[2] - v[2] * w[0])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
    )
