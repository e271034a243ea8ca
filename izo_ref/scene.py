"""The door: arrays of a step come in here and are checked once."""

import numpy as np

from izo_ref.errors import (
    DegenerateFaceError,
    IndexRangeError,
    InitialIntersectionError,
    MassError,
    NonFiniteError,
    OptionError,
    ShapeError,
)
from izo_ref.intersections import intersecting_pairs

SHOWN = 5  # offenders named in a message


class Scene:
    """One time step of a triangle mesh: where it starts and where it is proposed to end.

    Args:
        positions_t0: (n, 3) [m], start of the step, free of intersections (Q0).
        positions_t1: (n, 3) [m], proposed end (Q1).
        faces: (m, 3) vertex indices. Vertices in no face take part as points.
        masses: (n,) [kg], positive; 1 if None. Those of pinned vertices are not used.
        pinned: (n,) bool, vertices that follow their path exactly; none if None.
        initial_intersections: `raise`, or `exclude`: leave out the pairs that intersect
            at the start and list them in `excluded`.

    Attributes:
        positions_t0, positions_t1: (n, 3) f8 [m].
        faces: (m, 3) i4.
        edges: (k, 2) i4, each edge once, lower index first, sorted.
        masses: (n,) f8 [kg].
        pinned: (n,) b1.
        excluded: `Pairs` left out, or None.

    Raises:
        ShapeError, NonFiniteError, IndexRangeError, DegenerateFaceError, MassError,
        InitialIntersectionError: with what was expected, what was found, and the first
        offenders.
    """

    def __init__(
        self,
        positions_t0,
        positions_t1,
        faces,
        masses=None,
        pinned=None,
        *,
        initial_intersections="raise",
    ):
        if initial_intersections not in ("raise", "exclude"):
            raise OptionError(
                "initial_intersections: expected 'raise' or 'exclude', "
                f"got {initial_intersections!r}"
            )
        self.positions_t0 = _floats("positions_t0", positions_t0, (None, 3))
        n = len(self.positions_t0)
        self.positions_t1 = _floats("positions_t1", positions_t1, (n, 3))
        self.faces = _faces(faces, n)
        self.masses = np.ones(n) if masses is None else _masses(masses, n)
        self.pinned = np.zeros(n, bool) if pinned is None else _pinned(pinned, n)
        self.edges = edges_of(self.faces)
        self.excluded = self._initial_intersections(initial_intersections == "exclude")

    def _initial_intersections(self, exclude):
        crossing, pairs = intersecting_pairs(self.positions_t0, self.edges, self.faces)
        if len(pairs.nodes) == 0:
            return None
        if exclude:
            return pairs
        shown = "; ".join(f"{a} and {b}" for a, b in crossing[:SHOWN])
        raise InitialIntersectionError(
            "positions_t0: expected a mesh without intersections, found "
            f"{len(crossing)}, the first: {shown}. Pass initial_intersections='exclude' to "
            "leave these pairs out.",
            pairs,
        )


def edges_of(faces):
    """(k, 2) i4, each edge of the faces once, lower index first, sorted."""
    ends = np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]))
    if len(ends) == 0:
        return np.empty((0, 2), np.int32)
    return np.unique(np.sort(ends, axis=1), axis=0)


def _floats(name, values, shape):
    try:
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise ShapeError(f"{name}: expected numbers of shape {_text(shape)}: {error}") from None
    expected = tuple(found if want is None else want for want, found in zip(shape, array.shape))
    if array.ndim != len(shape) or array.shape != expected:
        raise ShapeError(f"{name}: expected shape {_text(shape)}, got {array.shape}")
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        first = tuple(int(i) for i in bad[0])
        raise NonFiniteError(
            f"{name}: expected finite numbers, found {len(bad)} others, the first "
            f"{array[first]} at {list(first)}"
        )
    return array


def _text(shape):
    return "(" + ", ".join("n" if size is None else str(size) for size in shape) + ")"


def _faces(faces, n):
    array = np.asarray(faces)
    if array.size == 0 and array.ndim <= 2:
        return np.empty((0, 3), np.int32)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ShapeError(f"faces: expected shape (m, 3), got {array.shape}")
    if array.dtype.kind not in "iu":
        raise ShapeError(f"faces: expected integers, got {array.dtype}")
    bad = np.flatnonzero(((array < 0) | (array >= n)).any(axis=1))
    if len(bad):
        raise IndexRangeError(
            f"faces: expected indices 0 to {n - 1}, found {len(bad)} faces with others, the "
            f"first face {bad[0]}: {array[bad[0]].tolist()}"
        )
    a, b, c = array.T
    bad = np.flatnonzero((a == b) | (b == c) | (c == a))
    if len(bad):
        raise DegenerateFaceError(
            f"faces: expected three different vertices each, found {len(bad)} with a repeated "
            f"one, the first face {bad[0]}: {array[bad[0]].tolist()}"
        )
    return np.array(array, dtype=np.int32, order="C")


def _masses(masses, n):
    array = _floats("masses", masses, (n,))
    bad = np.flatnonzero(~(array > 0.0))
    if len(bad):
        raise MassError(
            f"masses: expected numbers > 0 [kg], found {len(bad)} others, the first "
            f"{array[bad[0]]} at vertex {bad[0]}"
        )
    return array


def _pinned(pinned, n):
    array = np.array(pinned)
    if array.shape != (n,) or array.dtype != bool:
        raise ShapeError(f"pinned: expected shape ({n},) bool, got {array.shape} {array.dtype}")
    return array
