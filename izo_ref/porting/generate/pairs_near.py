"""Pairs at boundaries: of the face, of the step, of rest, and of what floats can hold."""

from __future__ import annotations

from izo_ref.porting.generate.pairs import (
    BOTH,
    DOUBLE,
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
from izo_ref.porting.generate.pairs_moving import CROSS, DOWN, EDGES_DOWN, THIN
from izo_ref.porting.reference.contact import Point


def boundaries() -> list[Named]:
    """Return pairs that pass just beside the face or the edges, just inside, or exactly there."""
    flags = ("beside-the-face",)
    rows = []
    for d, grade, dtypes in (
        (1.0, "easy", BOTH),
        (2.0**-8, "medium", BOTH),
        (2.0**-30, "hard", DOUBLE),
    ):
        for sign, word in ((1, "beside"), (-1, "inside")):
            x = 2 + sign * d
            pair = turned(vertex((x, x, 1), (x, x, -1)))
            what = f"The vertex passes {d:g} m {word} the long side of the face."
            rows.append(Named(word, flags, grade, pair, what, dtypes))
    for d in (-(2.0**-8), 2.0**-8):
        second = [(0, d, 1), (1, 3, 1)], [(0, d, -1), (1, 3, -1)]
        word = "inside" if d < 0 else "beside"
        what = f"The end of one edge passes {abs(d):g} m {word} the other edge."
        pair = turned(edges(EDGE, second[0], EDGE, second[1]))
        rows.append(Named(word, flags, "medium", pair, what))
    corner = [(4, 0, 1), (4, -(2.0**-30), 1)]
    for (x, y, z), word, dtypes in zip(corner, ("corner", "beside"), (BOTH, DOUBLE), strict=True):
        what = "The vertex goes through a corner of the face, exactly."
        if y:
            what = "The vertex passes 2^-30 m beside a corner of the face."
        pair = vertex((x, y, z), (x, y, -z))
        rows.append(Named(word, flags, "hard", pair, what, dtypes))
    side = turned(vertex((1, 3, 1), (3, 1, -1)))
    rows.append(Named("side", flags, "hard", side, "The vertex goes through a side, exactly."))
    ends = edges(EDGE, [(2, 0, 1), (2, 1, 1)], EDGE, [(2, 0, -1), (2, 1, -1)])
    what = "The end of one edge meets the end of the other, exactly."
    rows.append(Named("end-to-end", flags, "hard", turned(ends), what))
    for d, grade, dtypes in ((1.0, "easy", BOTH), (2.0**-30, "hard", DOUBLE)):
        pair = turned(edges(EDGE, [(0, d, 1), (1, 3, 1)], EDGE, [(0, d, -1), (1, 3, -1)]))
        what = f"The end of one edge passes {d:g} m beside the other edge."
        rows.append(Named("beside", flags, grade, pair, what, dtypes))
    return rows


def scales() -> list[Named]:
    """Return pairs of other sizes than one metre, and pairs that come close without meeting."""
    flags = ("absolute-tolerance",)
    beside = turned(vertex((3, 3, 1), (3, 3, -1)))
    above = edges(EDGE, CROSS, EDGE, shifted(CROSS, 0, 0, -1 + THIN))
    rows = []
    grades = {-20: "easy", -66: "hard", 20: "medium", 66: "hard", -24: "medium"}
    for exponent, grade in grades.items():
        dtypes = DOUBLE if abs(exponent) == 66 else BOTH
        for pair, name in ((turned(DOWN), "A pair"), (turned(EDGES_DOWN), "Two edges")):
            what = f"{name} of a size of 2^{exponent} m that meet."
            rows.append(Named("size", flags, grade, scaled(pair, exponent), what, dtypes))
        what = f"A pair of a size of 2^{exponent} m that does not meet."
        rows.append(Named("size", flags, grade, scaled(beside, exponent), what, dtypes))
    what = "The vertex comes to 2^-20 m of the face, which is no meeting."
    pair = vertex((1, 1, 1), (1, 1, THIN))
    rows.append(Named("close", flags, "medium", pair, what, DOUBLE))
    what = "The edges come to 2^-20 m of each other, which is no meeting."
    rows.append(Named("close", flags, "medium", turned(above), what, DOUBLE))
    return rows


_STARTS_FLAGS = ("starts-in-contact",)
_APART = edges(EDGE, shifted(CROSS, 0, 0, -1), EDGE, CROSS)
# Pairs that touch at t = 0, and some that only nearly do.
STARTS: tuple[Named, ...] = (
    Named(
        "start",
        _STARTS_FLAGS,
        "easy",
        vertex((1, 1, 0), (1, 1, 1)),
        "Touches at t = 0 and goes away.",
    ),
    Named(
        "start",
        _STARTS_FLAGS,
        "easy",
        turned(vertex((1, 1, 0), (1, 1, -1))),
        "Touches at t = 0 and goes through.",
    ),
    Named(
        "start", _STARTS_FLAGS, "medium", turned(_APART), "Edges that touch at t = 0 and go apart."
    ),
    Named(
        "start",
        _STARTS_FLAGS,
        "medium",
        vertex((4, 0, 0), (9, 9, 9)),
        "The vertex begins at a corner of the face.",
    ),
    Named(
        "start",
        _STARTS_FLAGS,
        "medium",
        turned(vertex((1, 1, 0), (1, 1, 0))),
        "The vertex lies on the face, and nothing moves.",
    ),
    Named(
        "start-above",
        _STARTS_FLAGS,
        "hard",
        turned(vertex((1, 1, 2.0**-30), (1, 1, 1))),
        "The vertex begins 2^-30 m above the face and goes away.",
        DOUBLE,
    ),
)


_COORDINATES_FLAGS = ("float32-coordinates",)
_FAR = moved_to(scaled(turned(DOWN), -4), 4096, -8192, 2048)
_FARTHER = moved_to(turned(EDGES_DOWN), 2.0**40, -(2.0**41), 2.0**38)
_LOW, _FINE = 1024.0, 2.0**-16
_FACE = shifted(FACE, 0, 0, _LOW + _FINE)
_X = _LOW + 2 - _FINE
# Pairs that need differences before products, or all digits of float64.
COORDINATES: tuple[Named, ...] = (
    Named(
        "far", _COORDINATES_FLAGS, "medium", _FAR, "Far from the origin: differences come first."
    ),
    Named("far", _COORDINATES_FLAGS, "hard", _FARTHER, "2^40 m from the origin.", DOUBLE),
    Named(
        "fine",
        _COORDINATES_FLAGS,
        "easy",
        vertex((1, 1, _LOW + 1), (1, 1, _LOW + 3 * _FINE), _FACE),
        "Ends 2^-15 m above a face at 1024 m, which float32 rounds away.",
        DOUBLE,
    ),
    Named(
        "fine",
        _COORDINATES_FLAGS,
        "hard",
        vertex((_X, 2, 1), (_X, 2, -1), shifted(FACE, _LOW, 0, 0)),
        "Goes through the face 2^-16 m from its side, at 1024 m from the origin.",
        DOUBLE,
    ),
    Named(
        "fine",
        _COORDINATES_FLAGS,
        "hard",
        vertex((_X + 2 * _FINE, 2, 1), (_X + 2 * _FINE, 2, -1), shifted(FACE, _LOW, 0, 0)),
        "Passes 2^-16 m beside the face, at 1024 m from the origin.",
        DOUBLE,
    ),
)


_RESTING_FLAGS = ("still-nodes",)
_MOVED = edges(EDGE, CROSS, EDGE, [(0, -1, -1), (1, 1, -2)])
# Pairs some nodes of which rest.
RESTING: tuple[Named, ...] = (
    Named(
        "still",
        _RESTING_FLAGS,
        "easy",
        turned(vertex((1, 1, 1), (1, 1, 1), FACE, shifted(FACE, 0, 0, 2))),
        "The vertex rests; the face moves.",
    ),
    Named(
        "still",
        _RESTING_FLAGS,
        "medium",
        vertex((1, 1, 1), (1, 1, 1), FACE, [(0, 0, 0), (4, 0, 0), (0, 4, 8)]),
        "The vertex and two corners rest.",
    ),
    Named(
        "still",
        _RESTING_FLAGS,
        "hard",
        edges(EDGE, [(0, -1, 1), (0, 1, -1 / 4)], EDGE, [(0, -1, 1 / 8), (0, 1, -1 / 4)]),
        "Three of the four nodes rest.",
    ),
    Named(
        "still",
        _RESTING_FLAGS,
        "easy",
        turned(vertex((1, 1, 1), (1, 1, 1))),
        "Nothing moves: apart.",
    ),
    Named(
        "still",
        _RESTING_FLAGS,
        "medium",
        _MOVED,
        "One edge rests; the other comes down on it, tilted.",
    ),
)


_LINEAR_FLAGS = ("linear-cubic",)
_SMALL, _LESS = 2.0**-16, 2.0**-18
_UP: Point = (0, 4 + _SMALL, 0)
_BENT: list[Point] = [(0, 0, 0), (4 + _LESS, 0, _LESS), (0, 4 + _LESS, -_LESS)]
# Pairs whose cubic is nearly linear, and whose time is not a round number.
LINEAR: tuple[Named, ...] = (
    Named(
        "nearly-linear",
        _LINEAR_FLAGS,
        "hard",
        vertex((1, 1, 1), (1.5, 0.5, -2), FACE, [(0, 0, _SMALL), (4, 0, -_SMALL), _UP]),
        "The face turns by 2^-16: formulas for cubics subtract numbers that are large.",
    ),
    Named(
        "nearly-linear",
        _LINEAR_FLAGS,
        "hard",
        turned(vertex((1, 1, 1), (1.25, 0.75, -2), FACE, _BENT)),
        "The face turns by 2^-18, in skew coordinates.",
    ),
    Named(
        "nearly-linear",
        _LINEAR_FLAGS,
        "hard",
        edges(EDGE, CROSS, [(-2 - THIN, 0, 0), (2, THIN, 0)], [(0, -1, -2), (THIN, 1, -2)]),
        "Both edges turn by 2^-20.",
    ),
)
