"""Pairs whose cubic is zero: motion within a plane, parallel edges, degenerate shapes."""

from __future__ import annotations

from izo_ref.porting.generate.pairs import (
    EDGE,
    FACE,
    Named,
    edges,
    flat,
    shifted,
    turned,
    vertex,
)
from izo_ref.porting.reference.contact import Pair, Point

POINT: list[Point] = [(1, 0, 0)] * 2
LINE: list[Point] = [(0, 0, 0), (4, 0, 0), (2, 0, 0)]


def _lifted(pair: Pair) -> Pair:
    """Return a pair in a plane that is not level, by a map that rounds nothing."""
    start, end = ([(x, y, x - y) for x, y, _ in points] for points in (pair.start, pair.end))
    return Pair(pair.is_edge_edge, start, end)


_SLIDING_FLAGS = ("coplanar-motion",)
_RAISED = vertex((-2, 1, 0), (2, 1, 3), FACE, shifted(FACE, 0, 0, 3))
_ENDS = flat([(1, 3), (1, 1)]), flat([(1, 1), (1, -1)])
_LINE = flat([(3, 0), (6, 0)]), flat([(1, 0), (4, 0)])
_SWING = edges(EDGE, flat([(3, -2), (3, 2)]), EDGE, flat([(0, -2), (2, 4)]))
# Pairs that stay in one plane and meet there.
SLIDING: tuple[Named, ...] = (
    Named(
        "in-plane",
        _SLIDING_FLAGS,
        "easy",
        vertex((-2, 1, 0), (2, 1, 0)),
        "The vertex slides in the plane of the face and meets a side of it.",
    ),
    Named(
        "in-plane",
        _SLIDING_FLAGS,
        "medium",
        turned(vertex((-1, -1, 0), (1, 1, 0))),
        "The vertex slides in the plane of the face and meets a corner.",
    ),
    Named(
        "in-plane",
        _SLIDING_FLAGS,
        "medium",
        turned(_RAISED),
        "The vertex and the face move in one plane, which moves itself.",
    ),
    Named(
        "in-plane",
        _SLIDING_FLAGS,
        "easy",
        edges(EDGE, _ENDS[0], EDGE, _ENDS[1]),
        "One edge slides end first into the other, in their plane.",
    ),
    Named(
        "in-plane",
        _SLIDING_FLAGS,
        "hard",
        turned(_lifted(_SWING)),
        "One edge turns in the plane of both until its end meets the other.",
    ),
    Named(
        "in-line",
        _SLIDING_FLAGS,
        "hard",
        turned(edges(EDGE, _LINE[0], EDGE, _LINE[1])),
        "Two edges on one line move toward each other.",
    ),
    Named(
        "in-plane",
        _SLIDING_FLAGS,
        "hard",
        turned(edges(EDGE, flat([(1, 1), (2, 3)]), EDGE, flat([(1, -2), (2, 2)]))),
        "One edge meets the other with its end at 1/3.",
    ),
)


_STAYING_FLAGS = ("coplanar-motion",)
_PAST = edges(EDGE, flat([(3, 1), (3, -1)]), EDGE, flat([(3, -1), (3, -3)]))
_STAYING_LINE = edges(EDGE, flat([(3, 0), (6, 0)]), shifted(EDGE, 1, 0, 0), flat([(4, 0), (6, 0)]))
_FAST = vertex((-4, 1, 0), (-5, 1, 0))
# Pairs that stay in one plane and do not meet, or that never part.
STAYING: tuple[Named, ...] = (
    Named(
        "in-plane-apart",
        _STAYING_FLAGS,
        "easy",
        vertex((-2, -1, 0), (4, -1, 0)),
        "The vertex slides past the face, in its plane.",
    ),
    Named(
        "in-plane-apart",
        _STAYING_FLAGS,
        "easy",
        turned(_PAST),
        "One edge passes the end of the other.",
    ),
    Named(
        "in-line-apart",
        _STAYING_FLAGS,
        "medium",
        turned(_STAYING_LINE),
        "Two edges stay on one line and stay apart.",
    ),
    Named(
        "in-plane-apart",
        _STAYING_FLAGS,
        "medium",
        turned(_FAST),
        "The vertex goes away from the face, in its plane.",
    ),
    Named(
        "in-plane-apart",
        _STAYING_FLAGS,
        "hard",
        vertex((4, -1, 0), (6, 1, 0)),
        "The vertex passes the corner of the face at 0.7 m, diagonally, in its plane.",
    ),
    Named(
        "in-plane-inside",
        ("stays-coplanar", "starts-in-contact"),
        "easy",
        turned(vertex((1, 1, 0), (2, 1, 0))),
        "The vertex slides inside the face: they touch from t = 0 on.",
    ),
    Named(
        "in-line-inside",
        ("stays-coplanar", "starts-in-contact"),
        "hard",
        edges(EDGE, flat([(1, 0), (5, 0)]), EDGE, flat([(0, 0), (4, 0)])),
        "Two edges lie on one line and overlap from t = 0 on.",
    ),
)


_PARALLEL_FLAGS = ("parallel-edges",)
_OVER: list[Point] = [(-1, 0, 1), (3, 0, 1)]
_UNDER: list[Point] = [(-1, 0, -1), (3, 0, -1)]
_BEYOND = edges(EDGE, shifted(_OVER, 4, 0, 0), EDGE, shifted(_UNDER, 4, 0, 0))
_LATE = edges(EDGE, [(-1, -1, 1), (1, 1, 1)], EDGE, [(-1, 1, -1), (1, -1, -1)])
_THIN = 2.0**-10
_NEARLY = edges(EDGE, [(-1, -_THIN, 1), (1, _THIN, 1)], EDGE, [(-1, -_THIN, -1), (1, _THIN, -1)])
_SIDE = edges(EDGE, [(-1, 1, 2), (3, 1, 2)], EDGE, [(-1, 0, -2), (3, 0, -2)])
# Edges that are parallel all the time, when they meet, or nearly.
PARALLEL: tuple[Named, ...] = (
    Named(
        "parallel",
        _PARALLEL_FLAGS,
        "easy",
        edges(EDGE, _OVER, EDGE, _UNDER),
        "Parallel edges that meet along a part of them.",
    ),
    Named(
        "parallel",
        _PARALLEL_FLAGS,
        "medium",
        turned(_BEYOND),
        "Parallel edges, one beyond the other.",
    ),
    Named(
        "parallel",
        _PARALLEL_FLAGS,
        "hard",
        turned(_LATE),
        "The edges are parallel only when they meet, at 1/2.",
    ),
    Named(
        "parallel", _PARALLEL_FLAGS, "hard", turned(_NEARLY), "The edges meet at an angle of 2^-10."
    ),
    Named(
        "parallel",
        _PARALLEL_FLAGS,
        "medium",
        turned(_SIDE),
        "Parallel edges that pass each other at a distance.",
    ),
)


_DEGENERATE_FLAGS = ("degenerate-elements",)
_POLE = edges(POINT, [(0, -1, 1), (2, 1, 1)], POINT, [(0, -1, -1), (2, 1, -1)])
_POINTS = edges(POINT, shifted(POINT, 0, 0, 1), POINT, shifted(POINT, 0, 0, -1))
_FALL = [(1, 0, 1), (1, 0, -1)]
_CORNER = [(1.0, 1.0, 1.0)] * 3
_CORNERS: list[Point] = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
_SHRINKING = vertex((0, 0, 0), (0, 0, 0), _CORNERS, shifted(_CORNERS, -1, -1, -1))
# Edges without length and faces without area.
DEGENERATE: tuple[Named, ...] = (
    Named("point", _DEGENERATE_FLAGS, "easy", _POLE, "An edge without length meets an edge."),
    Named("point", _DEGENERATE_FLAGS, "medium", turned(_POINTS), "Two edges without length meet."),
    Named(
        "point",
        _DEGENERATE_FLAGS,
        "medium",
        turned(edges(POINT, shifted(POINT, 1, 0, 1), POINT, shifted(POINT, 1, 0, -1))),
        "Two edges without length pass each other.",
    ),
    Named(
        "line",
        _DEGENERATE_FLAGS,
        "easy",
        vertex(_FALL[0], _FALL[1], LINE),
        "A face without area is met.",
    ),
    Named(
        "line",
        _DEGENERATE_FLAGS,
        "medium",
        turned(vertex((5, 0, 1), (5, 0, -1), LINE)),
        "The vertex passes the end of a face without area.",
    ),
    Named(
        "line",
        _DEGENERATE_FLAGS,
        "hard",
        turned(vertex((1, -1, 1), (1, 1, -1), LINE)),
        "A face without area is met, in skew coordinates.",
    ),
    Named(
        "line",
        _DEGENERATE_FLAGS,
        "medium",
        vertex((1, 1, 1), (1, 1, -1), LINE),
        "The vertex passes beside a face without area.",
    ),
    Named(
        "dot",
        _DEGENERATE_FLAGS,
        "hard",
        vertex((0, 0, 0), (2, 2, 2), _CORNER),
        "The corners of the face are in one point, which the vertex meets.",
    ),
    Named(
        "shrinking",
        _DEGENERATE_FLAGS,
        "hard",
        _SHRINKING,
        "The face moves over the vertex, which meets it at 1/3.",
    ),
)
