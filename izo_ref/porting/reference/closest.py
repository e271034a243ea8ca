"""Closest points of a pair, and the frame of an impact, without rounding and with its bound.

The closest points are found in fractions, by trying every pair of features (corners, edges, the
face, or both lines). The formula of the features that win is then computed once more in `Rounded`,
for the scale of the tolerance.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations
from typing import Any, NamedTuple, TypeAlias

from izo_ref.porting.reference.contact import Pair, decimal_of, exact_input, input_dtypes
from izo_ref.porting.reference.rounded import CONTEXT, Decisions, Rounded, is_float32

Vector: TypeAlias = list[Any]  # three Fractions, or Rounded
# Two numbers for the first side, for vertex-face one, and those of the other: which nodes span the
# features on which the closest points lie.
Features: TypeAlias = tuple[tuple[int, ...], tuple[int, ...]]

# A weight is computed from others that are up to 1, so it is rounded by up to half a unit of 1.
LEAST_SCALE = 0.5


class Frame(NamedTuple):
    """Weights and normal of an impact.

    Attributes:
        weights: (4,), exact; one choice of several if they are not unique.
        weights_scale: Scale of their tolerance.
        weights_are_unique: Whether no other closest points exist.
        distance: Distance of the closest points [m].
        normal: (3,), or None if the frozen gap along it is zero at the start, or if it does not
            exist.
        normal_scale: Scale of its tolerance.
        reach: Length of sum_k a_k x_k(0) [m], which no gap at the start exceeds.
        size: Largest coordinate relative to the first node, on the whole path [m].
        dtypes: Types of floats that find the same side.
    """

    weights: tuple[float, ...]
    weights_scale: float
    weights_are_unique: bool
    distance: float
    normal: tuple[float, ...] | None
    normal_scale: float
    reach: float
    size: float
    dtypes: tuple[str, ...]


def frame(pair: Pair, toi: float) -> Frame:
    """Return the weights and the normal of a pair at a time."""
    at = _positions(pair, Fraction(toi), Fraction)
    best = closest(pair.is_edge_edge, at)
    weights, features, vector, unique = best
    errors = [_weights_error(pair, toi, f) for f in {features, _interior(pair.is_edge_edge)}]
    start = _positions(pair, Fraction(0), Fraction)
    reach = _combined(weights, start)
    side = _dot(plane_normal(pair.is_edge_edge, at), reach)
    decisions = Decisions()
    normal, scale = None, LEAST_SCALE
    if side:
        normal, scale, decisions = _rounded_normal(pair, toi, features, side > 0)
    largest = max(abs(x) for t in (0, 1) for p in _positions(pair, t, Fraction) for x in p)
    held = input_dtypes(pair) if is_float32(toi) else ("f8",)
    return Frame(
        tuple(map(float, weights)),
        max(LEAST_SCALE, *errors),
        unique,
        float(decimal_of(_dot(vector, vector)).sqrt(CONTEXT)),
        normal,
        scale,
        float(decimal_of(_dot(reach, reach)).sqrt(CONTEXT)),
        float(largest),
        tuple(name for name in decisions.dtypes() if name in held),
    )


def closest(
    is_edge_edge: bool, nodes: list[Vector]
) -> tuple[tuple[Fraction, ...], Features, Vector, bool]:
    """Return the closest points of a pair at rest.

    Args:
        is_edge_edge: Kind of the pair.
        nodes: (4, 3) Fractions.

    Returns:
        The weights, the features that gave them, the vector from the second point to the first,
        and whether no other weights give points as close.
    """
    found = []
    for features in _features(is_edge_edge):
        weights = _weights(features, nodes)
        if weights is not None and max(weights[2:]) <= 0 and _first_side(is_edge_edge, weights):
            vector = _combined(weights, nodes)
            found.append((_dot(vector, vector), weights, features, vector))
    least = min(entry[0] for entry in found)
    best = [entry for entry in found if entry[0] == least]
    _, weights, features, vector = best[0]
    return tuple(weights), features, vector, all(entry[1] == weights for entry in best)


def plane_normal(is_edge_edge: bool, nodes: list[Vector]) -> Vector:
    """Return the cross product of the two edges, or of two sides of the face."""
    a, b, c, d = nodes
    if is_edge_edge:
        return _cross(_minus(b, a), _minus(d, c))
    return _cross(_minus(c, b), _minus(d, b))


def _first_side(is_edge_edge: bool, weights: list[Fraction]) -> bool:
    """Return whether the first two weights have the right signs; the others were looked at."""
    return min(weights[:2]) >= 0 if is_edge_edge else weights[1] <= 0


def _features(is_edge_edge: bool) -> Iterator[Features]:
    """Yield all pairs of features, those with the fewest nodes first."""
    first = [(0,), (1,), (0, 1)] if is_edge_edge else [(0,)]
    nodes = (2, 3) if is_edge_edge else (1, 2, 3)
    second = [some for k in range(1, len(nodes) + 1) for some in combinations(nodes, k)]
    pairs = [(a, b) for a in first for b in second]
    yield from sorted(pairs, key=lambda pair: len(pair[0]) + len(pair[1]))


def _interior(is_edge_edge: bool) -> Features:
    return ((0, 1), (2, 3)) if is_edge_edge else ((0,), (1, 2, 3))


def _weights(features: Features, nodes: list[Vector]) -> list[Any] | None:
    """Return the weights of the closest points of two features without ends, by Cramer's rule.

    None if they are not unique: the edge has no length, the face no area, or the lines are
    parallel. With the base points p and q of the features, and the directions u along them, the
    conditions are that p - q + sum_i s_i u_i is orthogonal to each u.
    """
    (i, *_), (j, *_) = features
    along = [(k, i, 1) for k in features[0][1:]] + [(k, j, -1) for k in features[1][1:]]
    edges = [_minus(nodes[k], nodes[base]) for k, base, _ in along]
    between = _minus(nodes[i], nodes[j])
    weights: list[Any] = [0, 0, 0, 0]
    weights[i], weights[j] = 1, -1
    signs = [sign for _, _, sign in along]
    steps = _solved(edges, signs, between)
    if steps is None:
        return None
    for (k, base, sign), step in zip(along, steps, strict=True):
        weights[k] = step if sign > 0 else -step
        weights[base] = weights[base] - weights[k]
    return weights


def _solved(edges: list[Vector], signs: list[int], between: Vector) -> list[Any] | None:
    """Return the steps s along at most two edges that make between + sum s sign edge shortest."""
    if not edges:
        return []
    right = [-s * _dot(edge, between) for edge, s in zip(edges, signs, strict=True)]
    whole = _dot(edges[0], edges[0])
    if len(edges) == 1:
        return None if _is_zero(whole) else [right[0] / whole]
    other, mixed = _dot(edges[1], edges[1]), signs[0] * signs[1] * _dot(edges[0], edges[1])
    area = whole * other - mixed * mixed
    if _is_zero(area):
        return None
    first = (right[0] * other - right[1] * mixed) / area
    return [first, (right[1] * whole - right[0] * mixed) / area]


def _is_zero(number: Any) -> bool:
    return (number.value if isinstance(number, Rounded) else number) == 0


def _weights_error(pair: Pair, toi: float, features: Features) -> float:
    """Return the error of the weights of some features, over eps; 0 if they do not exist."""
    exact = _weights(features, _positions(pair, Fraction(toi), Fraction))
    if exact is None:
        return 0.0
    rounded = _weights(features, _positions(pair, exact_input(toi), exact_input))
    if rounded is None:
        raise AssertionError("60 digits decide as fractions do")
    return max(float(Rounded.of(weight).error) for weight in rounded)


def _rounded_normal(
    pair: Pair, toi: float, features: Features, positive: bool
) -> tuple[tuple[float, ...], float, Decisions]:
    """Return the unit normal, its scale, and how near its side is to a tie."""
    at = _positions(pair, exact_input(toi), exact_input)
    normal = plane_normal(pair.is_edge_edge, at)
    length = _dot(normal, normal).sqrt()
    unit = [x / length if positive else -x / length for x in normal]
    weights = _weights(features, at)
    if weights is None:
        raise AssertionError("the features of the closest points exist")
    gap = _dot(unit, _combined(weights, _positions(pair, exact_input(0.0), exact_input)))
    with Decisions() as decisions:
        if not gap > 0:
            raise AssertionError("60 digits decide as fractions do")
    scale = max(LEAST_SCALE, *(float(x.error) for x in unit))
    return tuple(map(float, unit)), scale, decisions


def _positions(pair: Pair, time: Any, number: Any) -> list[Vector]:
    """Return the nodes at a time, relative to the first one: differences come before products."""
    ends = []
    for points in (pair.start, pair.end):
        origin, *others = [[number(float(x)) for x in point] for point in points]
        ends.append([_minus(point, origin) for point in others])
    moved = [
        [(1 - time) * a + time * b for a, b in zip(p, q, strict=True)]
        for p, q in zip(*ends, strict=True)
    ]
    return [[number(0.0)] * 3, *moved]


def _combined(weights: Any, nodes: list[Vector]) -> Vector:
    """Return sum_k a_k x_k."""
    a, b, c, d = weights
    return [a * w + b * x + c * y + d * z for w, x, y, z in zip(*nodes, strict=True)]


def _minus(a: Vector, b: Vector) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def _dot(a: Vector, b: Vector) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return [a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))]
