"""Which parts of a mesh cross each other in the frames of a sequence, and since when."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Indices, Nodes
from izo_ref.sequence.crossings import Crossings
from izo_ref.sequence.inspection import PartPair, Verdict


class Rows(NamedTuple):
    """What intersects in a frame or on the way to it, one row each.

    Attributes:
        crossings: What crosses and what touches in the frame.
        depths: (n,) f8, depth of each crossing [m].
        reaches: (n,) f8, how far what is behind each crossing has gone through [m].
        kept: (n,) b1, whether each crossing was there in all frames.
        passing: (k, 4) i4, the pairs that meet on the way and belong to no crossing.
    """

    crossings: Crossings
    depths: Floats
    reaches: Floats
    kept: Flags
    passing: Nodes


class PartPairs:
    """Sorts what intersects by the two parts that it is between, frame after frame.

    Args:
        parts: (n_vertices,) i8, the part that each vertex is in.
        pinned: (n_vertices,) b1.
    """

    def __init__(self, parts: Indices, pinned: Flags) -> None:
        """Keep the parts; nothing has been crossing yet."""
        self._parts, self._pinned = parts, pinned
        self._since: dict[tuple[int, int], int] = {}

    def of_frame(self, number: int, rows: Rows) -> tuple[PartPair, ...]:
        """Return what is wrong between which parts in the next frame.

        Args:
            number: Number of the frame.
            rows: What intersects.
        """
        crossings = rows.crossings
        edge_face = np.hstack((crossings.edges, crossings.faces))
        sets = [edge_face, crossings.touching.nodes, rows.passing]
        # The first vertex is of one side, and the last one of the other.
        sides = [np.sort(self._parts[nodes[:, [0, -1]]], axis=1) for nodes in sets]
        names = [(int(a), int(b)) for a, b in np.unique(np.concatenate(sides), axis=0)]
        masks = [[(side == name).all(axis=1) for side in sides] for name in names]
        crossing = {
            name: self._since.get(name, number)
            for name, (own, _, _) in zip(names, masks, strict=True)
            if own.any()
        }
        self._since = crossing
        fixed = [np.asarray(self._pinned[nodes].all(axis=1)) for nodes in sets]
        return tuple(
            _part_pair(name, own, fixed, rows, crossing.get(name))
            for name, own in zip(names, masks, strict=True)
        )


def _part_pair(
    name: tuple[int, int],
    own: list[Flags],
    fixed: list[Flags],
    rows: Rows,
    since: int | None,
) -> PartPair:
    """Return what is wrong between two parts.

    Args:
        name: Numbers of the parts.
        own: Which crossings, touching pairs and passing pairs are between them.
        fixed: Which of them have pinned vertices alone.
        rows: What intersects.
        since: The frame from which on the two have been crossing, or None.
    """
    pinned = [_count(a & b) for a, b in zip(own, fixed, strict=True)]
    kept = own[0] & rows.kept
    if pinned[0] or pinned[2]:
        verdict = Verdict.PINNED
    elif kept.any():
        verdict = Verdict.SINCE_START
    elif own[0].any() or own[2].any():
        verdict = Verdict.RESOLVABLE
    else:
        verdict = Verdict.TOUCHES
    return PartPair(
        parts=name,
        crossings=_count(own[0]),
        touching=_count(own[1]),
        passing=_count(own[2]),
        pinned=sum(pinned),
        since=since,
        kept=_count(kept),
        depth=float(rows.depths[own[0]].max(initial=0.0)),
        reach=float(rows.reaches[own[0]].max(initial=0.0)),
        verdict=verdict,
    )


def _count(flags: Flags) -> int:
    return int(np.count_nonzero(flags))
