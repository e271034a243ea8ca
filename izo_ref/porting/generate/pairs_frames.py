"""Pairs whose weights and normal say more than their time: sides, orders, turning normals."""

from __future__ import annotations

from izo_ref.porting.generate.pairs import (
    EDGE,
    FACE,
    Named,
    edges,
    moved_to,
    scaled,
    shifted,
    turned,
    vertex,
)
from izo_ref.porting.generate.pairs_moving import CROSS, DOWN, EDGES_DOWN
from izo_ref.porting.reference.contact import Pair, Point

_SIGN, _TIME, _ORDER = ("normal-sign",), ("frame-time",), ("weights-order",)
_OVER: list[Point] = [(1, -2, 1), (1, 6, 1)]  # crosses EDGE at 3/4 of it and 1/4 of its own
_UNDER: list[Point] = [(1, -2, -1), (1, 6, -1)]
_TURNED_BACK = Pair(
    False,
    [(0, -3, 3), (2, 1, 0), (3, 3, -3), (-1, -3, 0)],
    [(-1, 1, -1), (3, -3, 0), (-3, -2, 3), (-3, 0, -3)],
)
_OTHER_SIDE = Pair(
    False,
    [(1, -3, 1), (1, -2, 2), (3, 0, -1), (-3, -1, -2)],
    [(1, 2, 0), (3, 3, 0), (1, -3, 0), (2, 3, 2)],
)
_EDGES_BACK = Pair(
    True,
    [(-2, -3, 3), (-3, 0, 2), (3, -3, 0), (-2, 3, 3)],
    [(-3, -1, -3), (0, -2, 3), (-2, -2, 2), (3, 1, 1)],
)


def reversed_face(pair: Pair) -> Pair:
    """Return a vertex and a face whose corners go round the other way."""
    start, end = ([p[0], p[1], p[3], p[2]] for p in (pair.start, pair.end))
    return Pair(False, start, end)


def swapped(pair: Pair) -> Pair:
    """Return two edges in the other order."""
    return Pair(True, [*pair.start[2:], *pair.start[:2]], [*pair.end[2:], *pair.end[:2]])


def reversed_edge(pair: Pair) -> Pair:
    """Return two edges, the first of which has its ends in the other order."""
    start, end = ([p[1], p[0], p[2], p[3]] for p in (pair.start, pair.end))
    return Pair(True, start, end)


_UP = vertex((1, 0.5, -1), (1, 0.5, 2))
_RISING = vertex((1, 1, 4), (1, 1, 5), FACE, shifted(FACE, 0, 0, 8))
_LEVER = edges(EDGE, _OVER, EDGE, _UNDER)
# Pairs that come from one side or the other, and whose normal turns on the way.
SIDES: tuple[Named, ...] = (
    Named("above", _SIGN, "easy", vertex((1, 1, 1), (1, 1, -2)), "The vertex comes from above."),
    Named("below", _SIGN, "easy", _UP, "The vertex comes from below."),
    Named("below", _SIGN, "medium", turned(reversed_face(_UP)), "The same face, other way round."),
    Named("rising", _SIGN, "medium", _RISING, "Both rise, and the face is faster."),
    Named("edge-above", _SIGN, "easy", swapped(_LEVER), "The first edge comes from above."),
    Named("edge-below", _SIGN, "easy", _LEVER, "The second edge comes down on the first."),
    Named(
        "edge-below",
        _SIGN,
        "medium",
        turned(reversed_edge(_LEVER)),
        "The first edge goes the other way: the cross product points to the other side.",
    ),
    Named(
        "turned-back",
        _SIGN,
        "hard",
        _TURNED_BACK,
        "The face turns over on the way: its side at t = 0 gives the wrong sign.",
    ),
    Named(
        "other-side",
        _SIGN,
        "hard",
        _OTHER_SIDE,
        "The closest points at t = 0 are others, and give the wrong sign.",
    ),
    Named(
        "turned-back",
        _SIGN,
        "hard",
        _EDGES_BACK,
        "The edges turn on the way: their normal at t = 0 gives the wrong sign.",
    ),
)

_TILTING: list[Point] = [(0, 0, 0), (4, 0, 2), (0, 4, 0)]
_TURNING = edges(EDGE, CROSS, EDGE, [(0, -1, -1), (1, 2, -3)])
# Pairs whose normal and weights depend on the time at which they are taken.
TURNING: tuple[Named, ...] = (
    Named(
        "oblique",
        _TIME,
        "easy",
        vertex((0, 1, 1), (2, 1, -1)),
        "The vertex moves along the face too: its weights change.",
    ),
    Named(
        "tilting",
        _TIME,
        "medium",
        turned(vertex((1, 1, 1), (1, 2, -1), FACE, _TILTING)),
        "The face tilts: its normal changes.",
    ),
    Named("tilting", _TIME, "medium", turned(_TURNING), "One edge turns: the normal changes."),
)

_SKEW = edges([(0, 0, 0), (8, 0, 0)], [(2, -2, 1), (2, 6, 1)], (), [(2, -2, -1), (2, 6, -1)])
_END = edges(EDGE, [(1, 0, 1), (1, 3, 1)], EDGE, [(1, 0, -1), (1, 3, -1)])
# Pairs with four different weights, and with weights that are zero.
ORDERS: tuple[Named, ...] = (
    Named(
        "corners",
        _ORDER,
        "easy",
        vertex((1, 0.5, 1), (1, 0.5, -1)),
        "The weights of the corners are 5/8, 1/4 and 1/8.",
    ),
    Named("ends", _ORDER, "easy", _SKEW, "The weights are 3/4, 1/4, -3/4 and -1/4."),
    Named("ends", _ORDER, "medium", turned(_LEVER), "The weights are 1/4, 3/4, -3/4 and -1/4."),
    Named("corner", _ORDER, "hard", vertex((4, 0, 1), (4, 0, -1)), "One corner has all weight."),
    Named("side", _ORDER, "medium", turned(vertex((1, 3, 1), (1, 3, -1))), "One weight is zero."),
    Named("end", _ORDER, "hard", turned(_END), "The end of one edge meets the other inside."),
)

_SIZE = ("degenerate-elements",)
# Small and large pairs, which are not degenerate, and pairs far from the origin.
SIZES: tuple[Named, ...] = (
    Named(
        "size",
        _SIZE,
        "easy",
        scaled(turned(DOWN), -20),
        "A face of 1e-11 m^2 is small, and not degenerate.",
    ),
    Named(
        "size",
        _SIZE,
        "medium",
        scaled(turned(EDGES_DOWN), -20),
        "Edges of 1e-6 m are short, and not degenerate.",
    ),
    Named("size", _SIZE, "medium", scaled(turned(DOWN), 20), "A face of 1e13 m^2."),
    Named(
        "far",
        ("float32-coordinates",),
        "easy",
        moved_to(scaled(turned(_LEVER), -4), -2048, 8192, 4096),
        "Edges far from the origin: differences come before products.",
    ),
)
