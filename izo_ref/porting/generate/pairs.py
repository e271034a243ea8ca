"""How the pairs of stages S2 and S3 are written down."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import ldexp
from typing import NamedTuple

from izo_ref.porting.reference.contact import Pair, Point

BOTH = ("f8", "f4")
DOUBLE = ("f8",)

FACE: list[Point] = [(0, 0, 0), (4, 0, 0), (0, 4, 0)]
EDGE: list[Point] = [(-2, 0, 0), (2, 0, 0)]


class Named(NamedTuple):
    """A pair with what it is for.

    Attributes:
        word: Part of its id.
        flags: The mistakes that it catches, the most likely one first.
        grade: `easy`, `medium` or `hard`.
        pair: The nodes at the start and at the end.
        what: One sentence that says what is special.
        dtypes: Types of floats that can decide it.
        share: The part of the time of impact at which stage S3 takes the frame.
    """

    word: str
    flags: tuple[str, ...]
    grade: str
    pair: Pair
    what: str
    dtypes: tuple[str, ...] = BOTH
    share: float = 1.0


def vertex(
    start: Point, end: Point, face: Sequence[Point] = (), face_end: Sequence[Point] = ()
) -> Pair:
    """Return a vertex and a face; without corners the face is FACE, without an end it rests."""
    face = face or FACE
    return Pair(False, [start, *face], [end, *(face_end or face)])


def edges(
    first: Sequence[Point],
    second: Sequence[Point],
    first_end: Sequence[Point] = (),
    second_end: Sequence[Point] = (),
) -> Pair:
    """Return two edges; an edge without an end of its own rests."""
    return Pair(True, [*first, *second], [*(first_end or first), *(second_end or second)])


def flat(points: Iterable[tuple[float, float]], height: float = 0) -> list[Point]:
    """Return points of a plane at a height."""
    return [(x, y, height) for x, y in points]


def shifted(points: Iterable[Point], x: float, y: float, z: float) -> list[Point]:
    """Return points moved by a vector."""
    return [(a + x, b + y, c + z) for a, b, c in points]


def turned(pair: Pair) -> Pair:
    """Return a pair in skew coordinates, where no axis is special.

    An affine map of all nodes changes neither whether they meet nor when. Its entries are small
    integers, so nothing is rounded.
    """
    return _mapped(pair, lambda x, y, z: (2 * x + y, 2 * y + z - x, x - y + 3 * z))


def scaled(pair: Pair, exponent: int) -> Pair:
    """Return a pair times a power of two."""
    return _mapped(
        pair, lambda x, y, z: (ldexp(x, exponent), ldexp(y, exponent), ldexp(z, exponent))
    )


def moved_to(pair: Pair, x: float, y: float, z: float) -> Pair:
    """Return a pair far from the origin; no coordinate may be rounded by that."""
    return _mapped(pair, lambda a, b, c: (a + x, b + y, c + z))


def _mapped(pair: Pair, function: Callable[[float, float, float], Point]) -> Pair:
    start, end = ([function(*p) for p in points] for points in (pair.start, pair.end))
    return Pair(pair.is_edge_edge, start, end)
