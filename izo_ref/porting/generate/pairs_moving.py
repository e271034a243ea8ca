"""Pairs that meet while no plane holds them: degrees of the cubic, times, and many roots."""

from __future__ import annotations

from izo_ref.porting.generate.pairs import (
    DOUBLE,
    EDGE,
    FACE,
    Named,
    edges,
    shifted,
    turned,
    vertex,
)
from izo_ref.porting.reference.contact import Pair, Point

CROSS: list[Point] = [(0, -1, 1), (0, 1, 1)]  # an edge above EDGE, which it crosses from above
BELOW: list[Point] = [(0, -1, -1), (0, 1, -1)]
DOWN = vertex((1, 1, 1), (1, 1, -2), FACE, shifted(FACE, 0, 0, 1))  # meets at t = 1/4
EDGES_DOWN = edges(EDGE, CROSS, shifted(EDGE, 0, 0, 2), BELOW)  # meet at t = 1/4
THIN = 2.0**-20  # a length far above rounding, and near tolerances like 1e-6


def grazing(height: float) -> Pair:
    """Return a face that is at height -(1 - 2 t)^2 below or above a vertex at rest."""
    start: list[Point] = [(-2, 0, -1), (2, 0, -1), (0, 3, 2)]
    end: list[Point] = [(-2, -2, 1), (2, -2, 1), (0, 1, -2)]
    return vertex((0, 0, height), (0, 0, height), start, end)


_DEGREES_FLAGS = ("linear-cubic",)
_WIDE: list[Point] = [(0, 0, 0), (4 + THIN, 0, 0), (0, 4 + THIN, 0)]
_TURNING = edges(EDGE, CROSS, EDGE, [(0, -1, -1), (1, 2, -3)])
_TILTING: list[Point] = [(0, 0, 0), (4, 0, 2), (0, 4, 0)]
# Pairs whose cubic is linear, quadratic, constant, or nearly so.
DEGREES: tuple[Named, ...] = (
    Named(
        "linear",
        _DEGREES_FLAGS,
        "easy",
        vertex((1, 1, 1), (1, 1, -1)),
        "The face rests: degree one.",
    ),
    Named("linear", _DEGREES_FLAGS, "medium", turned(DOWN), "The face does not turn: degree one."),
    Named(
        "linear",
        _DEGREES_FLAGS,
        "medium",
        turned(vertex((1, 1, 5), (1, 1, 1))),
        "The root of the linear polynomial is at 5/4, after the step.",
    ),
    Named("linear", _DEGREES_FLAGS, "easy", EDGES_DOWN, "Edges that do not turn: degree one."),
    Named(
        "quadratic",
        _DEGREES_FLAGS,
        "medium",
        turned(_TURNING),
        "One edge turns: the coefficient of t^3 is zero, that of t^2 is not.",
    ),
    Named(
        "quadratic",
        _DEGREES_FLAGS,
        "medium",
        turned(vertex((1, 1, 1), (2, 1, -1), FACE, _TILTING)),
        "One corner moves, and the vertex moves along the face: degree two.",
    ),
    Named(
        "constant",
        _DEGREES_FLAGS,
        "easy",
        Pair(False, [(1, 1, 1), *FACE], shifted([(1, 1, 1), *FACE], 5, -3, 2)),
        "All nodes move alike: the polynomial is a constant, and nothing meets.",
    ),
    Named(
        "nearly-linear",
        _DEGREES_FLAGS,
        "hard",
        vertex((1, 1, 1), (1, 1, -1), FACE, _WIDE),
        "The coefficient of t^3 is 2^-43 of the largest: formulas divide by it.",
    ),
    Named(
        "nearly-linear",
        _DEGREES_FLAGS,
        "hard",
        turned(vertex((3, 3, 1), (3, 3, -1), FACE, _WIDE)),
        "The coefficient of t^3 is tiny, and the vertex passes beside the face.",
    ),
)


_LATE, _ENDS = ("late-time",), ("ends-of-step",)
_FASTER = edges(EDGE, [(-1, -2, 1), (-1, 2, 1)], EDGE, [(1.5, -1, -3), (1.5, 3, 4)])
_HALF: list[Point] = [(0, -1, 2), (0, 1, 2)]
# Pairs that meet late, soon, at the ends of the step, or just not in it.
TIMES: tuple[Named, ...] = (
    Named(
        "late",
        _LATE,
        "easy",
        vertex((1, 1, 1), (1, 1, -(2.0**-6))),
        "Meets at 64/65; a time that is reported later lets the vertex through.",
    ),
    Named(
        "late",
        _LATE,
        "medium",
        vertex((1, 1, 2.0**16), (1, 1, -1)),
        "A path of 65537 m that meets at 65536/65537: 1e-6 of the step are 7 cm.",
    ),
    Named(
        "late",
        _LATE,
        "medium",
        turned(edges(EDGE, shifted(CROSS, 0, 0, 63), EDGE, BELOW)),
        "Edges that meet at 64/65.",
    ),
    Named(
        "third",
        _LATE,
        "hard",
        turned(vertex((1, 1, 1), (1, 1, -2))),
        "Meets at 1/3, which halving never hits: its upper end is too late.",
    ),
    Named(
        "irrational",
        _LATE,
        "hard",
        turned(edges(EDGE, [(1, -2, 1), (1, 2, 1)], EDGE, [(1, -1, -3), (1, 3, 5)])),
        "Meets at the square root of 1/2.",
    ),
    Named(
        "faster",
        _LATE,
        "medium",
        turned(vertex((0.5, 0.5, 1), (2.5, 0.5, 1), FACE, _TILTING)),
        "The face comes faster and faster: Newton's method reaches the time from behind.",
    ),
    Named("faster", _LATE, "hard", _FASTER, "The edges come faster and faster to each other."),
    Named(
        "soon",
        _LATE,
        "hard",
        vertex((1, 1, THIN), (1, 1, THIN - 1)),
        "Meets at 2^-20: a solver that stops at 1e-6 reports a time after it.",
    ),
    Named(
        "soon",
        _LATE,
        "hard",
        edges(EDGE, shifted(CROSS, 0, 0, THIN - 1), EDGE, shifted(BELOW, 0, 0, THIN)),
        "Edges that meet at 2^-20.",
    ),
    Named(
        "end", _ENDS, "easy", vertex((1, 1, 1), (1, 1, 0)), "The vertex ends on the face: t = 1."
    ),
    Named(
        "end",
        _ENDS,
        "medium",
        turned(edges(EDGE, _HALF, EDGE, [(0, -1, 0), (0, 1, 0)])),
        "The edges touch at t = 1.",
    ),
    Named(
        "end",
        _ENDS,
        "hard",
        turned(vertex((3, 1, 3), (2, 2, 0))),
        "The vertex ends on a side of the face.",
    ),
    Named(
        "end-above",
        _ENDS,
        "medium",
        vertex((1, 1, 1), (1, 1, 2.0**-10)),
        "The vertex ends 2^-10 above the face.",
    ),
    Named(
        "end-above",
        _ENDS,
        "hard",
        turned(vertex((1, 1, 1), (1, 1, 2.0**-40))),
        "The vertex ends 2^-40 above the face.",
        DOUBLE,
    ),
    Named(
        "end-above",
        _ENDS,
        "hard",
        edges(EDGE, _HALF, EDGE, [(0, -1, 2.0**-40), (0, 1, 2.0**-40)]),
        "The edges end 2^-40 apart.",
        DOUBLE,
    ),
)


def _triple() -> Pair:
    """Return a vertex and a face with the cubic (1 - 2 t)^3, that meet at the centroid.

    Relative to the vertex, the corners are the rows of (1 - 2 t) I + N. All eigenvalues of N are
    zero, so the determinant is the cube; its columns add up to zero, so at t = 1/2 the vertex is at
    the centroid of the face.
    """
    start: list[Point] = [(-1, -2, -2), (0, 2, 1), (2, 1, 2)]
    end: list[Point] = [(-3, -2, -2), (0, 0, 1), (2, 1, 0)]
    return vertex((0, 0, 0), (0, 0, 0), start, end)


_ROOTS_FLAGS = ("many-roots",)
_GRAZING_FLAGS = ("stays-coplanar", "many-roots")
_VF = [(3, -4, -2), (4, 3, 3), (-4, -3, -2), (2, -4, -1)]
_TWO = Pair(False, [(-2, 3, 2), (2, -3, 1), (1, 3, -1), (3, 2, -2)], _VF)
_LAST = [(-2, -1, -2), (-4, 4, 4), (-1, -4, -4), (2, 3, -4)]
_THREE = Pair(False, [(0, 1, 4), (0, -2, 1), (-1, 3, -2), (-2, -3, 3)], _LAST)
_NEVER = [(-4, -2, 2), (4, -3, -2), (-2, 1, -1), (-3, 0, 0)]
_NONE = Pair(False, [(-3, -1, -4), (-1, 4, -2), (0, -2, -3), (4, -2, -3)], _NEVER)
_FIRST = [(1, -4, -2), (4, 3, 4), (1, -2, 3), (-3, -2, 1)]
_ALL3 = Pair(False, [(-1, 2, 4), (-2, -1, 2), (-3, 3, 0), (2, 3, 4)], _FIRST)
_EE2 = [(-4, 0, 0), (0, 4, 2), (-3, -4, 4), (4, 1, 0)]
_SECOND = Pair(True, [(4, -1, -2), (2, -1, 2), (2, 3, -2), (-2, 3, 1)], _EE2)
_EE3 = [(-2, 2, -3), (1, -1, 0), (-1, 0, -2), (3, 2, 1)]
_THIRD = Pair(True, [(1, 1, 0), (0, -3, -2), (1, 2, 0), (-4, 0, -3)], _EE3)
# Pairs whose cubic has two or three roots, also double and triple ones.
ROOTS: tuple[Named, ...] = (
    Named("first-root", _ROOTS_FLAGS, "easy", _ALL3, "Of three roots the first is the meeting."),
    Named(
        "second-root", _ROOTS_FLAGS, "medium", _TWO, "The first of two roots lies beside the face."
    ),
    Named("third-root", _ROOTS_FLAGS, "hard", _THREE, "The first two roots lie beside the face."),
    Named("no-root", _ROOTS_FLAGS, "medium", _NONE, "Three roots, and all lie beside the face."),
    Named(
        "second-root", _ROOTS_FLAGS, "medium", _SECOND, "At the first of two roots the edges miss."
    ),
    Named("third-root", _ROOTS_FLAGS, "hard", _THIRD, "At the first two roots the edges miss."),
    Named(
        "graze",
        _GRAZING_FLAGS,
        "hard",
        grazing(0),
        "A double root: the face touches and goes away.",
    ),
    Named(
        "graze-above",
        _ROOTS_FLAGS,
        "hard",
        grazing(2.0**-10),
        "The face comes to 2^-10 m and goes away: almost a double root, and no meeting.",
    ),
    Named(
        "graze-below",
        _GRAZING_FLAGS,
        "hard",
        grazing(-(2.0**-10)),
        "Two roots 2^-5 apart, without a change of sign at the ends of the step.",
    ),
    Named(
        "plane-start",
        _GRAZING_FLAGS,
        "medium",
        turned(vertex((-1, 1, 0), (2, 1, 0.5), FACE, [(0, 0, 0), (4, 0, 4), (0, 4, 0)])),
        "Begins in the plane of the face, beside it, and goes through it at 1/2.",
    ),
    Named(
        "plane-start",
        _GRAZING_FLAGS,
        "hard",
        turned(vertex((-1, 1, 0), (2, 1, -1), FACE, [(0, 0, 0), (4, 0, 4), (0, 4, 0)])),
        "Begins in the plane of the face, with a double root at 0, beside it, and leaves it.",
    ),
    Named(
        "triple-root",
        _ROOTS_FLAGS,
        "hard",
        _triple(),
        "A triple root: the cubic is flat where the vertex goes through.",
    ),
)
