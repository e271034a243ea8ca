"""Single pairs on a path, with times of their first meeting that are worked out by hand."""

from fractions import Fraction

import numpy as np

TINY = 5e-324
ULP = 2.0**-52
HALF = Fraction(1, 2)
FACE = [(0, 0, 0), (4, 0, 0), (0, 4, 0)]
LINE = [(0, 0, 0), (4, 0, 0), (2, 0, 0)]
BESIDE = [(0, TINY, 0)] * 3
ORIGIN = [(0, 0, 0)] * 3
EDGE = [(-2, 0, 0), (2, 0, 0)]


def vertex(start, end, face_start=FACE, face_end=None):
    """Return a vertex and a face; without an end of its own, the face rests."""
    return False, [start, *face_start], [end, *(face_start if face_end is None else face_end)]


def edges(a_start, b_start, a_end=None, b_end=None):
    """Return two edges; an edge without an end of its own rests."""
    a_end = a_start if a_end is None else a_end
    b_end = b_start if b_end is None else b_end
    return True, [*a_start, *b_start], [*a_end, *b_end]


def grazing_face(height):
    """Return a vertex that rests at (0, 0, height); the face there has height -(1 - 2 t)^2."""
    start = [(-2, 0, -1), (2, 0, -1), (0, 3, 2)]
    return vertex((0, 0, height), (0, 0, height), start, [(-2, -2, 1), (2, -2, 1), (0, 1, -2)])


def grazing_edge(height):
    """Return edges that cross, seen from above; there the second has height - (1 - 2 t)^2."""
    b_start, b_end = [(0, 0, height - 1), (0, 2, height + 1)], [(0, -2, height + 1), (0, 0, 0)]
    b_end[1] = (0, 0, height - 1)
    return edges(EDGE, b_start, EDGE, b_end)


def irrational(x, length=2):
    """Return edges of which the second, in the plane at x, reaches y = z = 0 when 2 t^2 = 1."""
    b_start = [(x, -length, 1), (x, length, 1)]
    return edges(EDGE, b_start, EDGE, [(x, 1 - length, 1 - 2 * length), (x, 1 + length, 5)])


def shrinking(at):
    """Return a face whose corners pass the origin at t = 1/2, and a vertex at rest."""
    corners = np.eye(3)
    return vertex(at, at, corners, -corners)


def turning(first, second):
    """Return two edges in a plane; the first has tips on x + y = 2 and -2, the second rests."""
    return edges(EDGE, [first, second], [(0, -2, 0), (0, 2, 0)])


def passing(x):
    """Return a vertex that moves in the plane of the face through (x, 0); (4, 0) is a corner."""
    return vertex((x - 1, -1, 0), (x + 1, 1, 0))


MISS = None
# {name: (pair, time)}. The time is MISS, an exact number, a float where it is irrational, or True
# where the pair meets at a time that was not worked out.
CASES = {
    # general cases, and the boundaries of the face, of the edges and of the time
    "through the face": (vertex((1, 1, 1), (1, 1, -1)), HALF),
    "beside the face": (vertex((3, 3, 1), (3, 3, -1)), MISS),
    "ends on the face": (vertex((1, 1, 1), (1, 1, 0)), 1),
    "ends a denormal above": (vertex((1, 1, 1), (1, 1, TINY)), MISS),
    "ends one ulp above": (
        vertex((1, 1, 2), (1, 1, 1 + ULP), np.add(FACE, (0, 0, 1)), np.add(FACE, (0, 0, 1))),
        MISS,
    ),
    "starts on the face": (vertex((1, 1, 0), (1, 1, 1)), 0),
    "starts a denormal above": (vertex((1, 1, TINY), (1, 1, 1)), MISS),
    "through a side": (vertex((2, 2, 1), (2, 2, -1)), HALF),
    "one ulp off a side": (vertex((2, 2 + 2 * ULP, 1), (2, 2 + 2 * ULP, -1)), MISS),
    "through a corner": (vertex((4, 0, 1), (4, 0, -1)), HALF),
    "a denormal off a corner": (vertex((4, -TINY, 1), (4, -TINY, -1)), MISS),
    "starts at a corner": (vertex((4, 0, 0), (9, 9, 9)), 0),
    "edges cross": (edges(EDGE, [(0, -1, 1), (0, 1, 1)], None, [(0, -1, -1), (0, 1, -1)]), HALF),
    "end through edge": (edges(EDGE, [(0, 0, 1), (0, 1, 1)], None, [(0, 0, -1), (0, 1, -1)]), HALF),
    "end a denormal off": (
        edges(EDGE, [(0, TINY, 1), (0, 1, 1)], None, [(0, TINY, -1), (0, 1, -1)]),
        MISS,
    ),
    "end to end": (edges(EDGE, [(2, 0, 1), (2, 1, 1)], None, [(2, 0, -1), (2, 1, -1)]), HALF),
    "end past end": (
        edges(EDGE, [(2 + 2 * ULP, 0, 1), (2, 1, 1)], None, [(2 + 2 * ULP, 0, -1), (2, 1, -1)]),
        MISS,
    ),
    # multiple roots, and cases close to them
    "face grazes": (grazing_face(0.0), HALF),
    "face just misses": (grazing_face(TINY), MISS),
    "face goes in and out": (grazing_face(-TINY), True),
    "face goes in and out at 1/4": (grazing_face(-0.25), Fraction(1, 4)),
    "edge grazes": (grazing_edge(0.0), HALF),
    "edge goes in and out at 1/4": (grazing_edge(0.25), Fraction(1, 4)),
    "edge just misses": (grazing_edge(-ULP), MISS),
    "triple root": (shrinking((0, 0, 0)), HALF),
    "double root beside the vertex": (shrinking((1, -1, 1)), MISS),
    "over the side that rests, roots at both ends of time": (
        vertex((9, 9, 0), (1, 1, 0), FACE, [(0, 0, 1), (4, 0, 0), (0, 4, 0)]),
        Fraction(7, 8),
    ),
    # irrational times
    "irrational, inside": (irrational(1.0), 2.0**-0.5),
    "irrational, at an end": (irrational(2.0), 2.0**-0.5),
    "irrational, past an end": (irrational(2.0 + 2 * ULP), MISS),
    "irrational, too short": (irrational(1.0, 0.7071067811865475), MISS),
    "irrational, long enough": (irrational(1.0, 0.7071067811865476), 2.0**-0.5),
    # coplanar all the time
    "slides into the face": (vertex((5, 5, 0), (1, 1, 0)), Fraction(3, 4)),
    "slides past the face": (vertex((5, -1, 0), (-5, -1, 0)), MISS),
    "slides over the corner": (passing(4.0), HALF),
    "slides past the corner": (passing(4.0 + 4 * ULP), MISS),
    "slides inside": (vertex((1, 1, 0), (1.5, 1, 0)), 0),
    "slides out": (vertex((4, 0, 0), (5, 0, 0)), 0),
    "slides to a side at t = 1": (vertex((3, 3, 0), (2, 2, 0)), 1),
    "rests inside": (vertex((1, 1, 0), (1, 1, 0)), 0),
    "rests outside": (vertex((5, 1, 0), (5, 1, 0)), MISS),
    "moves above, never coplanar": (vertex((1, 1, 1), (2, 1, 1)), MISS),
    "tip meets tip": (turning((1, 1, 0), (3, 3, 0)), HALF),
    "turns before": (turning((1, -1, 0), (3, -3, 0)), MISS),
    "turns an ulp before": (turning((1 + ULP, 1, 0), (3, 3, 0)), MISS),
    "turns through": (turning((1, 0.5, 0), (3, 0, 0)), True),
    # collinear and parallel
    "parallel edges pass": (
        edges(EDGE, [(1, 0, 1), (3, 0, 1)], None, [(1, 0, -1), (3, 0, -1)]),
        HALF,
    ),
    "parallel, end over end": (
        edges(EDGE, [(2, 0, 1), (3, 0, 1)], None, [(2, 0, -1), (3, 0, -1)]),
        HALF,
    ),
    "parallel, one ulp apart": (
        edges(EDGE, [(2 + 2 * ULP, 0, 1), (3, 0, 1)], None, [(2 + 2 * ULP, 0, -1), (3, 0, -1)]),
        MISS,
    ),
    "on one line, meet": (
        edges(EDGE, [(5, 0, 0), (6, 0, 0)], None, [(1, 0, 0), (2, 0, 0)]),
        Fraction(3, 4),
    ),
    "on one line, meet at t = 1": (
        edges(EDGE, [(5, 0, 0), (6, 0, 0)], None, [(2, 0, 0), (3, 0, 0)]),
        1,
    ),
    "on one line, an ulp short": (
        edges(EDGE, [(5, 0, 0), (6, 0, 0)], None, [(2 + 2 * ULP, 0, 0), (3, 0, 0)]),
        MISS,
    ),
    "face is a line, through": (vertex((3, 0, 1), (3, 0, -1), LINE), HALF),
    "face is a line, at its end": (vertex((4, 0, 1), (4, 0, -1), LINE), HALF),
    "face is a line, past its end": (vertex((-TINY, 0, 1), (-TINY, 0, -1), LINE), MISS),
    "face is a line, beside": (vertex((3, TINY, 1), (3, TINY, -1), LINE), MISS),
    "face is a line, along it": (vertex((6, 0, 0), (2, 0, 0), LINE), HALF),
    "face is a line at t = 1/2": (
        vertex((1, 0, 1), (1, 0, -1), [*FACE[:2], (2, 1, 0)], [*FACE[:2], (2, -1, 0)]),
        HALF,
    ),
    "face is a line at t = 1/2, past its end": (
        vertex((5, 0, 1), (5, 0, -1), [*FACE[:2], (2, 1, 0)], [*FACE[:2], (2, -1, 0)]),
        MISS,
    ),
    "face is a line at t = 1/2, beside": (
        vertex((1, TINY, 1), (1, TINY, -1), [*FACE[:2], (2, 1, 0)], [*FACE[:2], (2, -1, 0)]),
        MISS,
    ),
    # point-like
    "face is a point, hit": (vertex((-1, 0, 0), (1, 0, 0), ORIGIN), HALF),
    "face is a point, missed": (vertex((-1, 0, 0), (1, 0, 0), BESIDE), MISS),
    "face shrinks to a point": (vertex((0, 0, 1), (0, 0, 1), FACE, [(0, 0, 1)] * 3), 1),
    "edge is a point, hit": (
        edges(EDGE, [(1, 1, 1)] * 2, None, [(1, -1, -1)] * 2),
        HALF,
    ),
    "edge is a point, missed": (
        edges(EDGE, [(1, 1, 1)] * 2, None, [(1, -1, -1 - 2 * ULP)] * 2),
        MISS,
    ),
    "both are points, hit": (
        edges([(0, 0, 0)] * 2, [(3, 6, 9)] * 2, None, [(-6, -12, -18)] * 2),
        Fraction(1, 3),
    ),
    "both are points, missed": (
        edges([(0, 0, 0)] * 2, [(3, 6, 9)] * 2, None, [(-6, -12, -18 + 2**-48)] * 2),
        MISS,
    ),
    "all one point": (edges(*[[(7, 7, 7)] * 2] * 2), 0),
    "two points at rest": (edges([(7, 7, 7)] * 2, [(7, 7, 7 - 4 * ULP)] * 2), MISS),
    # numbers of very different size
    "huge and small": (
        vertex((1e-300, 1e-300, 1e300), (1e-300, 1e-300, -1e300), 1e300 / 4 * np.array(FACE)),
        HALF,
    ),
    "huge, off by a denormal": (
        vertex((1e-300, -TINY, 1e300), (1e-300, -TINY, -1e300), 1e300 / 4 * np.array(FACE)),
        MISS,
    ),
    "huge and early": (vertex((1, 1, TINY), (1, 1, -1e300)), True),
    "huge and late": (vertex((1, 1, 1e300), (1, 1, -TINY)), True),
    "denormal face": (
        vertex((TINY, TINY, 1e300), (TINY, TINY, -1e300), TINY * np.array(FACE)),
        HALF,
    ),
    "denormal face, beside": (
        vertex((3 * TINY, 2 * TINY, 1.0), (3 * TINY, 2 * TINY, -1.0), TINY * np.array(FACE)),
        MISS,
    ),
}
