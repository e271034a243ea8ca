"""What a page shows: meshes, their positions before and after, and the pairs that meet."""

from __future__ import annotations

import enum
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyInts, Codes, Faces, Flags, Floats, Ints, Positions, Times
from izo_ref.base.records import Pairs

WIDTH = 6  # vertices of the widest kind of pair: two faces


class Kind(enum.IntEnum):
    """What the two sides of a pair are, and how many vertices the first side has."""

    VERTEX_FACE = 0
    EDGE_EDGE = 1
    EDGE_THROUGH_FACE = 2
    FACE_FACE = 3


class ShownPairs(NamedTuple):
    """Pairs that meet on a path, or that cross at rest.

    Attributes:
        nodes: (k, WIDTH) i4, the vertices of the first side, then those of the second; -1 where a
            pair has fewer.
        kinds: (k,) i1, values of `Kind`.
        times: (k,) f8, from 0 to 1, when they meet on the path; NaN for pairs at rest.
    """

    nodes: Ints
    kinds: Codes
    times: Times

    def first(self, most: int) -> ShownPairs:
        """Return the first pairs, at most so many."""
        return ShownPairs(self.nodes[:most], self.kinds[:most], self.times[:most])


def no_pairs() -> ShownPairs:
    """Return a record of no pairs."""
    return ShownPairs(np.empty((0, WIDTH), np.int32), np.empty(0, np.int8), np.empty(0))


def pairs_on_path(pairs: Pairs, times: Times) -> ShownPairs:
    """Return vertex-face and edge-edge pairs that meet on a path, the first to meet first.

    Args:
        pairs: The pairs.
        times: (n,) f8, from 0 to 1, when each of them meets.
    """
    order = np.argsort(times, kind="stable")
    kinds = np.where(pairs.is_edge_edge[order], Kind.EDGE_EDGE, Kind.VERTEX_FACE)
    return ShownPairs(_padded(pairs.nodes[order]), kinds.astype(np.int8), times[order])


def pairs_at_rest(kind: Kind, first: AnyInts, second: AnyInts) -> ShownPairs:
    """Return pairs of one kind that cross at rest.

    Args:
        kind: What the sides are.
        first: (k, a), vertices of the first sides.
        second: (k, b), vertices of the second sides.
    """
    nodes = _padded(np.hstack((first, second)))
    return ShownPairs(nodes, np.full(len(nodes), kind, np.int8), np.full(len(nodes), np.nan))


def join_pairs(parts: Iterable[ShownPairs]) -> ShownPairs:
    """Return the pairs of several records, one record after the other."""
    return ShownPairs._make(np.concatenate(columns) for columns in zip(*parts, strict=True))


def _padded(nodes: AnyInts) -> Ints:
    missing = ((0, 0), (0, WIDTH - nodes.shape[1]))
    return np.pad(nodes.astype(np.int32), missing, constant_values=-1)


class Table(NamedTuple):
    """A table below the view.

    Attributes:
        title: What it is about.
        heads: Names of its columns; empty if the first cell of each row names the row.
        rows: Its cells, as texts.
    """

    title: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, kw_only=True)
class Side:
    """The mesh as it was proposed, or as it was resolved.

    Attributes:
        name: What the page calls it, such as `Proposed`.
        positions: (n, 3) f8 [m], of each frame.
        pairs: The pairs of each frame: those that meet on the way to it, or cross in it.
        n_pairs: Number of pairs of each frame, of which `pairs` may hold only the first ones.
    """

    name: str
    positions: list[Positions]
    pairs: list[ShownPairs]
    n_pairs: list[int]


@dataclass(frozen=True, kw_only=True)
class View:
    """What a page shows.

    Attributes:
        title: Names what is shown, such as the name of the file.
        verdict: A sentence that says how it ended.
        passed: Whether that is good, bad, or neither (None).
        is_step: Whether it is one step: two frames, the start and the end, and a path between.
        faces: (m, 3) i4.
        parts: Names of the parts of the mesh.
        part_of: (n,) i4, the part of each vertex.
        pinned: (n,) b1.
        zone_of: (n,) i4, the zone of each vertex, -1 for no zone; None without zones.
        frames: Numbers of the frames that are shown.
        sides: One side, or two: before and after.
        up: The axis that points up, `y` or `z`.
        notes: Sentences about what is not shown.
        tables: Tables below the view.
    """

    title: str
    verdict: str
    passed: bool | None
    is_step: bool
    faces: Faces
    parts: list[str]
    part_of: Ints
    pinned: Flags
    zone_of: Ints | None
    frames: list[int]
    sides: list[Side]
    up: str = "z"
    notes: list[str] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)


class Grid(NamedTuple):
    """Whole numbers for positions: they are relative to a centre, and a step is tiny.

    Attributes:
        exponent: Positions are multiplied by 2^exponent first, so that no number overflows.
        centre: (3,) f8, in that unit.
        radius: Largest distance from the centre along an axis, in that unit.
    """

    exponent: int
    centre: Floats
    radius: float

    @property
    def radius_m(self) -> float:
        """The radius [m]."""
        return float(np.ldexp(self.radius, -self.exponent))

    def whole(self, positions: Positions) -> Ints:
        """Return positions as whole numbers, (n, 3) i4; `STEPS` of them are the radius.

        Positions far outside, which only vertices in no face have, are moved to the border.
        """
        near = (np.ldexp(positions, self.exponent) - self.centre) * (STEPS / self.radius)
        return np.rint(np.clip(near, -OUTSIDE * STEPS, OUTSIDE * STEPS)).astype(np.int32)


# A float32 holds whole numbers up to 2^24, so that graphics cards get these numbers exactly. The
# largest error of a position is then 2^-24 of the radius.
STEPS, OUTSIDE = 2**23, 2**6


def grid_of(view: View) -> Grid:
    """Return the grid that the positions of all frames fit in; vertices in no face do not count."""
    used = np.unique(view.faces)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for side in view.sides:
        for positions in side.positions:
            points = positions[used] if len(used) else positions
            low = np.minimum(low, points.min(axis=0, initial=np.inf))
            high = np.maximum(high, points.max(axis=0, initial=-np.inf))
    if not np.isfinite(low).all():
        low, high = np.zeros(3), np.zeros(3)
    largest = float(np.maximum(np.abs(low), np.abs(high)).max())
    exponent = -int(np.frexp(largest)[1]) if largest else 0
    low, high = np.ldexp(low, exponent), np.ldexp(high, exponent)
    centre = 0.5 * (low + high)
    return Grid(exponent, centre, float((high - centre).max()) or 1.0)
