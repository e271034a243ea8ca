"""Pairs that punish tolerances of a fixed size, exact comparisons, and interpolated coordinates."""

from __future__ import annotations

from izo_ref.porting.generate.pairs import (
    BOTH,
    DOUBLE,
    EDGE,
    Named,
    edges,
    flat,
    moved_to,
    scaled,
    turned,
    vertex,
)
from izo_ref.porting.generate.pairs_early import SHARE, edges_before, vertex_before
from izo_ref.porting.reference.contact import Pair


def _sized(grade: str, pair: Pair, exponent: int, what: str) -> Named:
    """Return a pair of another size; squares of its areas have to be numbers in its types."""
    dtypes = BOTH if abs(exponent) < 30 else DOUBLE
    what = f"{what}, and all of it is of a size of 2^{exponent} m."
    return Named("size", ("absolute-tolerance",), grade, scaled(pair, exponent), what, dtypes)


_TILT = turned(vertex_before((1, 1, 0), (-1, 0.25, 0.5)))
_LEAN = turned(edges_before((0, 0, 0), (1, 2, 1), (1, 2, 0), (-1, 1)))
_SLIDE = turned(vertex((-1, -2, 0), (2, 3, 0)))
# Small and large pairs whose normal is not the direction between them at the start.
SIZES: tuple[Named, ...] = (
    _sized("easy", _TILT, -20, "A vertex comes from beside a face"),
    _sized("easy", _LEAN, -20, "Two edges come from the side"),
    _sized("easy", _SLIDE, -20, "A vertex slides in the plane of a face"),
    _sized("medium", _TILT, -24, "A vertex comes from beside a face"),
    _sized("medium", _LEAN, -24, "Two edges come from the side"),
    _sized("hard", _TILT, -66, "A vertex comes from beside a face"),
    _sized("hard", _LEAN, -66, "Two edges come from the side"),
    _sized("hard", _SLIDE, 20, "A vertex slides in the plane of a face"),
)

_FLAT_FLAGS = ("coplanar-motion",)
# Pairs that stay in one plane; floats find a gap along its normal that is not zero.
ROUNDED: tuple[Named, ...] = (
    Named(
        "in-plane",
        _FLAT_FLAGS,
        "medium",
        turned(vertex((-2, 1, 0), (3, 2, 0))),
        "The vertex meets a side at 2/5, and rounding gives a gap along the normal of the plane.",
    ),
    Named(
        "in-plane",
        _FLAT_FLAGS,
        "hard",
        turned(edges(EDGE, flat([(-1, 2), (1, 3)]), EDGE, flat([(0, -3), (2, 1)]))),
        "An edge turns and meets the other at 2/5: the gap of rounding is not zero.",
    ),
)

_FAR_FLAGS = ("float32-coordinates",)
_THIRD = turned(vertex((0, 1, 1), (2, 2, -2)))
_EDGES_THIRD = turned(edges(EDGE, [(1, -2, 1), (1, 6, 1)], EDGE, [(0, -2, -2), (2, 6, -2)]))
_BESIDE = turned(vertex((-5, 0, 3), (4, 2, -2)))
# Powers of two would leave the products exact.
_ORIGIN = (20011, -30029, 9973)
_FARTHEST = (12345678901, -9876543211, 1234567891)
# Far from the origin; no node that moves is at a round place when the frame is taken.
FAR: tuple[Named, ...] = (
    Named(
        "far",
        _FAR_FLAGS,
        "medium",
        moved_to(scaled(_THIRD, -3), *_ORIGIN),
        "Meets at 1/3, far from the origin: subtract first, then interpolate.",
    ),
    Named(
        "far",
        _FAR_FLAGS,
        "medium",
        moved_to(scaled(_EDGES_THIRD, -3), *_ORIGIN),
        "Edges that meet at 1/3, far from the origin.",
    ),
    Named(
        "far",
        _FAR_FLAGS,
        "hard",
        moved_to(scaled(_BESIDE, -4), *_ORIGIN),
        "The frame is taken just before they meet, beside the face, far from the origin.",
        share=SHARE,
    ),
    Named(
        "far",
        _FAR_FLAGS,
        "hard",
        moved_to(_THIRD, *_FARTHEST),
        "Meets at 1/3, 1e10 m from the origin: float64 rounds interpolated coordinates, too.",
        DOUBLE,
    ),
    Named(
        "far",
        _FAR_FLAGS,
        "hard",
        moved_to(_EDGES_THIRD, *_FARTHEST),
        "Edges that meet at 1/3, 1e10 m from the origin.",
        DOUBLE,
    ),
    Named(
        "far",
        _FAR_FLAGS,
        "hard",
        moved_to(_BESIDE, *_FARTHEST),
        "The frame is taken just before they meet, 1e10 m from the origin.",
        DOUBLE,
        SHARE,
    ),
)
