"""What is said of a frame that was inspected: records and verdicts."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from izo_ref.base.arrays import Edges, Faces, Indices


class Verdict(enum.Enum):
    """What is wrong with a frame, from the best to the worst. The value is a sentence."""

    CLEAN = "Nothing crosses or touches, and nothing passes through on the way to the frame."
    TOUCHES = "Something touches, and nothing goes through anything."
    RESOLVABLE = (
        "All that crosses or meets came after the first frame, and has a vertex that may move. "
        "Resolving the sequence keeps it apart, unless it is pinched between pinned parts."
    )
    SINCE_START = (
        "Something has been crossing since the first frame. It is left alone until it comes apart "
        "(the ratchet); all else is kept apart."
    )
    PINNED = (
        "Pinned vertices alone cross or meet. No other vertex can prevent that, so it is left out. "
        "Change the motion of the pinned parts."
    )


# From the best to the worst; a frame has the worst of its parts.
ORDER = tuple(Verdict)


@dataclass(frozen=True, kw_only=True)
class PartPair:
    """What crosses, touches or meets between two parts, or within one, in a frame.

    Attributes:
        parts: Numbers of the two parts, the lower one first; equal if a part crosses itself.
        crossings: Number of edges that go through a face, each face counted.
        touching: Number of vertex-face and edge-edge pairs that touch.
        passing: Number of pairs that meet on the way where nothing crosses at its ends.
        pinned: How many of all these have pinned vertices alone.
        since: The frame from which on the two have been crossing in every frame; None if they do
            not cross in this one.
        kept: Number of crossings that were there in all frames from the first one on.
        depth: Largest depth of a crossing, see `depths_of` [m].
        reach: How far a vertex has gone through, see `reaches_of` [m].
        verdict: What is wrong between the two.
    """

    parts: tuple[int, int]
    crossings: int
    touching: int
    passing: int
    pinned: int
    since: int | None
    kept: int
    depth: float
    reach: float
    verdict: Verdict


@dataclass(frozen=True, kw_only=True)
class Inspection:
    """What is wrong with a frame.

    Attributes:
        number: Number of the frame.
        verdict: The worst verdict of its pairs of parts.
        crossings: Number of edges that go through a face, each face counted.
        new: How many of them did not cross in the frame before; all of them in the first frame.
        gone: How many crossings of the frame before are no longer there.
        kept: How many of them were there in all frames from the first one on.
        touching: Number of vertex-face and edge-edge pairs that touch where nothing goes through.
        met: Number of pairs that meet on the straight way from the frame before, without those that
            cross or touch there.
        passing: How many of these belong to no crossing: nothing in their surroundings crosses or
            touches, neither in this frame nor in the one before.
        contours: Number of contours along which surfaces cross.
        depth: Largest depth of a crossing, see `depths_of` [m].
        reach: How far a vertex has gone through, see `reaches_of` [m].
        width: Diagonal of the box about the widest contour [m].
        move: Largest distance of a vertex from where it is in the frame before [m].
        pairs: What is wrong between which parts, sorted by their numbers.
        edges: (crossings, 2) i4, the vertices of each edge that goes through a face.
        faces: (crossings, 3) i4, the vertices of that face.
        contour_of: (crossings,) i8, the contour that each of them is a point of, from 0 on.
    """

    number: int
    verdict: Verdict
    crossings: int
    new: int
    gone: int
    kept: int
    touching: int
    met: int
    passing: int
    contours: int
    depth: float
    reach: float
    width: float
    move: float
    pairs: tuple[PartPair, ...]
    edges: Edges
    faces: Faces
    contour_of: Indices
