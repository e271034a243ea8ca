"""Degenerate pairs on a path, each with an answer that is known by construction.

Every case is drawn on a few integers, where one can see whether the pair meets. Exact
transformations then make many queries of it: an invertible linear map with integer entries, a
shift, a common velocity, a power of two as the scale, another order of corners and edges, and the
reversal of time. None of them changes whether the pair meets, and no float is rounded. So the
answers are right without an oracle, and oracles can be tested with them.
"""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from izo_ref.base.arrays import Flags, Floats

Point: TypeAlias = tuple[float, float, float]
Points: TypeAlias = Sequence[Point]
Pair: TypeAlias = tuple[bool, Points, Points]  # is edge-edge; the four nodes at the start, the end
Case: TypeAlias = tuple[bool, Points, Points, bool]  # a pair, and whether it meets

FACE = [(0, 0, 0), (8, 0, 0), (0, 8, 0)]
LINE = [(0, 0, 0), (4, 0, 0), (8, 0, 0)]  # a face without area
EDGE = [(-4, 0, 0), (4, 0, 0)]
TURNING = ([(-4, 0, 4), (0, -4, 4)], [(4, 0, 4), (0, 4, 4)])  # both at (0, 0, 4) at t = 1/2
MARGINS = (2.0**-10, 2.0**-20, 2.0**-30, 2.0**-40)  # by which a pair just misses or just meets
# A shift makes coordinates large, so that the smallest margin would be rounded away.
SHIFTED_MARGIN = 2.0**-30
LARGEST_SHIFT = 2**10


class Queries(NamedTuple):
    """Pairs on their path, in the format of the file of published queries."""

    vertices: Floats  # (q, 8, 3) f8, the four nodes at t = 0, then at t = 1
    is_edge_edge: Flags  # (q,) b1
    truth: Flags  # (q,) b1, whether the pair meets
    names: list[str]  # name of the case of each query


def degenerate_queries(rng: np.random.Generator, n_each: int) -> Queries:
    """Draw queries of each case.

    Args:
        rng: Draws the margins and the transformations.
        n_each: Number of queries of each case.

    Returns:
        The queries with their true answers.
    """
    vertices, kinds, truth, names = [], [], [], []
    for _ in range(n_each):
        margin = MARGINS[rng.integers(len(MARGINS))]
        for name, (is_edge_edge, start, end, meets) in _cases(margin).items():
            both = np.array([start, end], float)
            vertices.append(_transformed(rng, both, is_edge_edge, margin).reshape(8, 3))
            kinds.append(is_edge_edge)
            truth.append(meets)
            names.append(name)
    return Queries(np.array(vertices), np.array(kinds), np.array(truth), names)


def _cases(e: float) -> dict[str, Case]:
    """Return `{name: case}`; `e` is a small margin."""
    return _vertex_face_cases(e) | _edge_edge_cases(e)


def _vertex_face_cases(e: float) -> dict[str, Case]:
    def moves(first: Point, last: Point, face: Points = FACE) -> Pair:
        return False, [first, *face], [last, *face]

    def falls(x: float, y: float, face: Points = FACE) -> Pair:
        return moves((x, y, 4), (x, y, -4), face)

    point = [(0, 0, 0)] * 3
    return {
        "through the inside": (*falls(2, 2), True),
        "through a side": (*falls(4, 4), True),
        "just inside a side": (*falls(4 - e, 4), True),
        "just beside a side": (*falls(4 + e, 4), False),
        "through a corner": (*falls(8, 0), True),
        "just beside a corner": (*falls(8 + e, 0), False),
        "lands at the end": (*moves((2, 2, 4), (2, 2, 0)), True),
        "stops just above": (*moves((2, 2, 4), (2, 2, e)), False),
        "slides in the plane into a side": (*moves((-4, 2, 0), (2, 2, 0)), True),
        "slides in the plane onto a corner": (*moves((-4, 0, 0), (0, 0, 0)), True),
        "slides in the plane just past a corner": (*moves((-4, -e, 0), (9, -e, 0)), False),
        "rests in the plane beside": (*moves((5, 5, 0), (5, 5, 0)), False),
        "rests just above": (*moves((2, 2, e), (2, 2, e)), False),
        "hits a face without area": (*falls(3, 0, LINE), True),
        "just misses a face without area": (*falls(3, e, LINE), False),
        "hits a face that is a point": (*falls(0, 0, point), True),
        "just misses a face that is a point": (*falls(e, 0, point), False),
        "corners turn through the vertex": (*_turns_vertex(-4), True),
        "corners turn beside the vertex": (*_turns_vertex(4), False),
    }


def _turns_vertex(z: float) -> Pair:
    """Let two corners change sides of a vertex; the volume has a double root at t = 1/2."""
    start, end = TURNING
    return False, [(0, 0, 0), *start, (0, 0, z)], [(0, 0, 0), *end, (0, 0, z)]


def _edge_edge_cases(e: float) -> dict[str, Case]:
    def moves(first: Points, last: Points) -> Pair:
        return True, [*EDGE, *first], [*EDGE, *last]

    def falls(*ends: tuple[float, float]) -> Pair:
        return moves([(x, y, 4) for x, y in ends], [(x, y, -4) for x, y in ends])

    def slides(low: float, high: float, by: float) -> Pair:
        return moves([(low, 0, 0), (high, 0, 0)], [(low + by, 0, 0), (high + by, 0, 0)])

    level = [(0, -4, 4), (0, 4, 4)]
    return {
        "edges cross": (*falls((0, -4), (0, 4)), True),
        "edge crosses an end": (*falls((4, -4), (4, 4)), True),
        "edge just misses an end": (*falls((4 + e, -4), (4 + e, 4)), False),
        "end lands on an end": (*falls((4, 0), (4, 4)), True),
        "end just misses an edge": (*falls((1, e), (2, 4)), False),
        "edge lands at the end": (*moves(level, [(0, -4, 0), (0, 4, 0)]), True),
        "edge stops just above": (*moves(level, [(0, -4, e), (0, 4, e)]), False),
        "parallel edges meet": (*falls((0, 0), (8, 0)), True),
        "parallel edges meet at their ends": (*falls((4, 0), (9, 0)), True),
        "parallel edges just pass beyond an end": (*falls((4 + e, 0), (9, 0)), False),
        "parallel edges just pass beside": (*falls((-4, e), (4, e)), False),
        "collinear edges run together": (*slides(8, 16, -5), True),
        "collinear edges touch at the end": (*slides(8, 16, -4), True),
        "collinear edges stop just apart": (*slides(8 + e, 16, -4), False),
        "edge without length hits": (*falls((1, 0), (1, 0)), True),
        "edge without length just misses": (*falls((1, e), (1, e)), False),
        "edge turns through the other": (*_turns_edge(2), True),
        "edge turns beside the other": (*_turns_edge(5), False),
    }


def _turns_edge(z: float) -> Pair:
    """Turn an edge over as it passes the line of the other one: a double root at t = 1/2."""
    start, end = TURNING
    other = [(0, 0, z), (0, 0, z + 3)]
    return True, [*other, *start], [*other, *end]


def _transformed(
    rng: np.random.Generator, both: Floats, is_edge_edge: bool, margin: float
) -> Floats:
    """Transform (2, 4, 3) positions without rounding and without changing the answer."""
    if is_edge_edge:
        ends = [rng.permutation(2), 2 + rng.permutation(2)]
        order = np.concatenate(ends[:: 1 - 2 * int(rng.integers(2))])
    else:
        order = np.append(0, 1 + rng.permutation(3))
    both = both[:: 1 - 2 * int(rng.integers(2))][:, order]
    linear = np.zeros((3, 3))
    while abs(np.linalg.det(linear)) < 0.5:  # of integers, so it is an integer
        linear = rng.integers(-3, 4, (3, 3)).astype(float)
    both = both @ linear.T
    if margin >= SHIFTED_MARGIN:
        shifts = rng.integers(-LARGEST_SHIFT, LARGEST_SHIFT + 1, (2, 3))
        both = both + shifts[:, None, :]
    return both * 2.0 ** int(rng.integers(-30, 31))
