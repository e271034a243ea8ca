"""All pairs of a mesh that meet on a straight path, by brute force and exact arithmetic.

Question: which vertex-face and edge-edge pairs without a common vertex meet on the path, and when?

Method: every vertex is compared with every face, and every edge with every other edge. A pair is
left out only if a fixed direction certainly keeps its two sides apart during the whole step; the
exact arithmetic of `path.py` decides every other pair.

Independent of `izo_ref`: there is no tree, no tolerance and no iteration.

Limits: a mesh of a thousand triangles takes a few seconds, and the time grows with the square of
the number of triangles.

Why a direction is enough. For a fixed direction d, the gap d . (b - a) between two nodes is linear
in the time. If it is positive at t = 0 and at t = 1 for every node a of one side and every node
b of the other, then it is positive at every time in between, and so it is for all points of the
two convex hulls. Pairs whose swept boxes (start and end together) do not meet are left out by this
rule too: along one of the axes, the gap is positive at both times.

Rounding. A component of d is -1, 0 or 1, and a coordinate is at most S in magnitude. With
u = 2^-53, a dot product takes two additions, whose results are at most 3 S, so its error is at most
6 u S. The difference of two dot products is at most 6 S and is rounded by at most 6 u S. The
computed gap is thus wrong by at most 18 u S, up to terms in u^2. A pair is left out only if its
computed gap exceeds 32 u S.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from validation.oracles import path
from validation.oracles.answer import Flags, Floats, Indices, Ints

CHUNK = 256  # rows of the table of pairs that are compared at once
CERTAIN = 32.0 * 2.0**-53  # gaps above this, times the largest coordinate, are positive


class MeetingPairs(NamedTuple):
    """The pairs that meet, sorted by their nodes."""

    vertex_face: Ints  # (k, 4) i4, the vertex, then the corners of the face in its order
    vertex_face_time: Floats  # (k,) f8, first meeting, rounded to a double
    edge_edge: Ints  # (l, 4) i4, each edge with its lower node first, the lower edge first
    edge_edge_time: Floats  # (l,) f8
    decided: int  # pairs that went to exact arithmetic


def meeting_pairs(start: ArrayLike, end: ArrayLike, faces: ArrayLike) -> MeetingPairs:
    """Find all pairs without a common vertex that meet at some time in [0, 1].

    Args:
        start: (n, 3) f8 [m], positions at t = 0. Vertices in no face take part.
        end: (n, 3) f8 [m], positions at t = 1.
        faces: (m, 3) i4.

    Returns:
        The pairs and the times at which they first meet.
    """
    start, end = np.asarray(start, np.float64), np.asarray(end, np.float64)
    faces = np.asarray(faces, np.int32)
    vertices = np.arange(len(start), dtype=np.int32)[:, None]
    edges = mesh_edges(faces)
    vf = _not_separated(start, end, vertices, faces)
    ee = _not_separated(start, end, edges, edges)
    ee = ee[ee[:, 0] < ee[:, 1]]
    vf = np.hstack((vertices[vf[:, 0]], faces[vf[:, 1]]))
    ee = np.hstack((edges[ee[:, 0]], edges[ee[:, 1]]))
    vf, ee = vf[_distinct(vf, 1)], ee[_distinct(ee, 2)]
    return MeetingPairs(
        *_decide(start, end, vf, is_edge_edge=False),
        *_decide(start, end, ee, is_edge_edge=True),
        decided=len(vf) + len(ee),
    )


def mesh_edges(faces: Ints) -> Ints:
    """Return (k, 2) i4, each edge once, its lower node first, sorted."""
    pairs = np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]))
    return np.unique(np.sort(pairs, axis=1), axis=0)


def _not_separated(start: Floats, end: Floats, first: Ints, second: Ints) -> Indices:
    """Find the pairs that no plane of a fixed direction certainly separates.

    Args:
        start: (n, 3) f8 [m].
        end: (n, 3) f8 [m].
        first: (f, i) i4, nodes of each first side.
        second: (s, j) i4, nodes of each second side.

    Returns:
        (k, 2) int, the first and the second side of each pair.
    """
    size = max(np.abs(start).max(initial=0.0), np.abs(end).max(initial=0.0))
    # one direction of each opposite pair; the other sign is compared below
    directions = [d for d in product((-1, 0, 1), repeat=3) if d > (0, 0, 0)]
    along = np.array([positions @ np.array(directions, float).T for positions in (start, end)])
    lows = [along[:, nodes].min(axis=2) for nodes in (first, second)]  # (time, side, direction)
    highs = [along[:, nodes].max(axis=2) for nodes in (first, second)]
    found = [np.empty((0, 2), int)]
    for begin in range(0, len(first), CHUNK):
        rows = slice(begin, begin + CHUNK)
        open_pairs = np.ones((len(first[rows]), len(second)), bool)
        for k in range(len(directions)):
            above = [lows[1][t, None, :, k] - highs[0][t, rows, None, k] for t in (0, 1)]
            below = [lows[0][t, rows, None, k] - highs[1][t, None, :, k] for t in (0, 1)]
            for gaps in (above, below):
                open_pairs &= ~(np.minimum(*gaps) > CERTAIN * size)
        found.append(np.argwhere(open_pairs) + (begin, 0))
    return np.concatenate(found)


def _distinct(nodes: Ints, split: int) -> Flags:
    """Mark the pairs whose two sides have no common node."""
    return ~(nodes[:, :split, None] == nodes[:, None, split:]).any(axis=(1, 2))


def _decide(start: Floats, end: Floats, nodes: Ints, is_edge_edge: bool) -> tuple[Ints, Floats]:
    """Return nodes and first times of the pairs that meet, by exact arithmetic."""
    kept, times = [], []
    for row in nodes:
        bracket = path.first_meeting(is_edge_edge, start[row], end[row])
        if bracket is not None:
            kept.append(row)
            times.append(float(bracket[0]))
    return np.array(kept, np.int32).reshape(-1, 4), np.array(times, np.float64)
