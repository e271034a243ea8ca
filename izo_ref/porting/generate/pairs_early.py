"""Pairs whose frame is taken a little before they meet, so that the sides do not touch yet.

A time of impact may be early by a quarter (`s02.EARLY`). The closest points can then be on a
border, at a corner or at an end, although the pair meets inside.
"""

from __future__ import annotations

from collections.abc import Sequence

from izo_ref.porting.generate.pairs import (
    EDGE,
    FACE,
    Named,
    edges,
    turned,
    vertex,
)
from izo_ref.porting.reference.contact import Pair, Point

SHARE = 7 / 8  # of the time of impact; what is left of the way is exact
_STEPS = 8  # before the meeting; so the frame is taken one step before it
_FLAGS = ("clamped-points",)
# Faces with an obtuse angle at their first, second and third corner.
_OBTUSE: list[Point] = [(0, 0, 0), (8, 0, 0), (-6, 2, 0)]
_SECOND: list[Point] = [_OBTUSE[2], _OBTUSE[0], _OBTUSE[1]]
_THIRD: list[Point] = [_OBTUSE[1], _OBTUSE[2], _OBTUSE[0]]
_TILTED: list[Point] = [(0, 0, -1), (4, 0, 1), (0, 4, 1)]


def _way(hit: Point, step: Point, after: int) -> list[Point]:
    """Return the ends of a path that is eight steps long before a point, and some after it."""
    return [
        (hit[0] + k * step[0], hit[1] + k * step[1], hit[2] + k * step[2]) for k in (_STEPS, -after)
    ]


def vertex_before(hit: Point, step: Point, face: Sequence[Point] = FACE, after: int = 8) -> Pair:
    """Return a vertex that is one step before a point of a face when the frame is taken."""
    start, end = _way(hit, step, after)
    return vertex(start, end, face)


def edges_before(
    hit: Point, step: Point, along: Point, ends: tuple[float, float], after: int = 8
) -> Pair:
    """Return EDGE, and an edge that is one step before a point of it when the frame is taken.

    Args:
        hit: The point.
        step: The step.
        along: Direction of the second edge.
        ends: Where its ends are, in lengths of that direction from the point.
        after: Number of steps after the meeting.
    """
    start, end = (
        [(p[0] + s * along[0], p[1] + s * along[1], p[2] + s * along[2]) for s in ends]
        for p in _way(hit, step, after)
    )
    return edges(EDGE, start, EDGE, end)


def _named(word: str, grade: str, pair: Pair, what: str) -> Named:
    return Named(word, _FLAGS, grade, pair, what, share=SHARE)


_SIDE = vertex_before((1, 1, 0), (-2, 0.5, 1))
_CORNER = vertex_before((1, 1, 0), (-2, -3, 1))
_BEHIND = (0.5, 0.75, 0), (1.5, -1.75, 1)
_AHEAD = (0.5, 0.75, 0), (-1, -1.25, 1)
_TILTING = vertex((1, 1, 4), (2, 1, -4), FACE, _TILTED)
# A vertex that is beside its face, or above it, just before they meet.
FACES: tuple[Named, ...] = (
    _named(
        "early-side",
        "easy",
        vertex_before((1, 1, 0), (-2, 0, 1)),
        "Just before they meet, the vertex is beside the face: its closest point is on a side.",
    ),
    _named(
        "early-side", "easy", vertex_before((1, 1, 0), (2, 1, 1), after=16), "Beside the long side."
    ),
    _named("early-side", "medium", turned(_SIDE), "Beside a side, in skew coordinates."),
    _named(
        "early-corner",
        "medium",
        _CORNER,
        "Just before they meet, the closest point of the face is a corner.",
    ),
    _named(
        "early-corner",
        "medium",
        turned(vertex_before((1, 1, 0), (6, -2, 1), after=4)),
        "The closest point is another corner, in skew coordinates.",
    ),
    _named(
        "early-obtuse",
        "hard",
        vertex_before(*_BEHIND, _OBTUSE),
        "Behind two sides at an obtuse angle: two coordinates are negative, and the closest point "
        "is on a side, not at their corner.",
    ),
    _named(
        "early-obtuse",
        "hard",
        turned(vertex_before(*_BEHIND, _SECOND)),
        "Behind two sides at an obtuse angle, at the second corner.",
    ),
    _named(
        "early-obtuse",
        "hard",
        vertex_before(*_AHEAD, _THIRD, 16),
        "Behind two sides at an obtuse angle, at the third corner; the other side is closest.",
    ),
    _named(
        "early-inside",
        "easy",
        vertex_before((1, 1, 0), (0.5, -0.5, 1)),
        "Just before they meet, the vertex is above the face: areas of triangles with the vertex "
        "are not those of the closest point.",
    ),
    _named("early-inside", "hard", turned(_TILTING), "The vertex is above a face that tilts."),
)

_OBLIQUE = edges_before((1, 0, 0), (-4, 0, 1), (1, 2, 0), (-1, 1))
_ONE_END = edges_before((1, 0, 0), (-4, 1, 1), (2, 1, 0), (-1, 2), 16)
_BOTH_ENDS = edges_before((1.5, 0, 0), (3, -1, 1), (2, 1, 0), (-0.5, 2))
_AGAIN = edges_before((0, 0, 0), (2, 2, 1), (1, 1, 0), (-1, 1))
_OUTSIDE = edges_before((0, 0, 0), (1, 2, 1), (4, 1, 0), (-0.5, 0.5), 4)
_TWICE = edges_before((-1, 0, 0), (1, -3, 1), (2, -1, 0), (-1, 1))
_WITHIN = edges_before((0, 0, 0), (0.5, 0.25, 1), (1, 1, 0), (-1, 1))
# Two edges whose lines are closest outside them, or inside, just before they meet.
EDGES: tuple[Named, ...] = (
    _named(
        "early-end",
        "easy",
        edges_before((1, 0, 0), (-4, 0, 1), (0, 1, 0), (-1, 1)),
        "Just before they meet, the closest point of the first edge is its end.",
    ),
    _named(
        "early-end",
        "medium",
        _OBLIQUE,
        "The first edge is closest with its end, and the second one not where its line is.",
    ),
    _named("early-end", "medium", turned(_ONE_END), "The same, in skew coordinates."),
    _named("early-ends", "medium", _BOTH_ENDS, "Just before they meet, two ends are closest."),
    _named(
        "early-end",
        "hard",
        turned(_AGAIN),
        "The end of the second edge is closest; so the point of the first edge changes, too.",
    ),
    _named(
        "early-end",
        "hard",
        _OUTSIDE,
        "The lines are closest outside both edges, and the edges inside the first one.",
    ),
    _named("early-end", "hard", turned(_TWICE), "The same, in skew coordinates."),
    _named("early-inside", "medium", turned(_WITHIN), "Two edges are closest inside both."),
)
