"""Judge the frames of a sequence by programs that have not made them."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyInts, Edges, Faces, Flags, Positions
from izo_ref.base.records import ExcludedPairs
from izo_ref.certificate.certify import certify_path
from izo_ref.scene import Scene
from validation.oracles import fcl, ipc
from validation.oracles import path as path_oracle

HITS = 1000  # hits of ipctk on a path that are decided exactly


class Verdict(NamedTuple):
    """What judges say of the frames of a sequence.

    Attributes:
        paths: Number of paths from a frame to the next one.
        certified: How many of them the certificate of izo_ref proves free.
        by_ipctk: How many ipctk finds free; each of its hits is decided in exact arithmetic. None
            if it does not run on this machine.
        by_fcl: How many of the frames at their ends python-fcl finds free.
    """

    paths: int
    certified: int
    by_ipctk: int | None
    by_fcl: int


def judge_frames(positions: Positions, faces: Faces, pinned: Flags) -> Verdict:
    """Judge each path from a frame to the next one, and each frame at its end.

    Args:
        positions: (n_frames, n, 3) f8 [m].
        faces: (m, 3) i4.
        pinned: (n,) b1.
    """
    certified = by_ipctk = by_fcl = 0
    for start, end in pairwise(positions):
        scene = Scene(start, end, faces, pinned=pinned, initial_intersections="ratchet")
        certificate = certify_path(scene, end)
        certified += certificate.free and certificate.excluded is None
        by_ipctk += meeting_by_ipctk(start, end, scene.edges, faces) == 0
        by_fcl += len(fcl.crossing_faces(end, faces)) == 0
    return Verdict(len(positions) - 1, certified, None if ipc.unusable() else by_ipctk, by_fcl)


def meeting_by_ipctk(
    start: Positions,
    end: Positions,
    edges: Edges,
    faces: Faces,
    excluded: ExcludedPairs | None = None,
) -> int | None:
    """Count the pairs that meet on a path, by ipctk and exact arithmetic.

    Args:
        start: (n, 3) f8 [m].
        end: (n, 3) f8 [m].
        edges: (k, 2) i4.
        faces: (m, 3) i4.
        excluded: Pairs that may meet; None if there are none.

    Returns:
        The number; HITS + 1 if there are more hits than can be decided, and None if ipctk does not
        run on this machine.
    """
    if ipc.unusable():
        return None
    left_out = None if excluded is None else (excluded.nodes, excluded.is_edge_edge)
    hits = ipc.path_hits(start, end, edges, faces, HITS, left_out)
    if not hits.complete:
        return HITS + 1
    count = 0
    for row, kind in zip(hits.nodes, map(bool, hits.is_edge_edge), strict=True):
        touches = path_oracle.meets(kind, start[row], start[row])
        meets = path_oracle.meets_after_start if touches else path_oracle.meets
        count += meets(kind, start[row], end[row])
    return count


def unexplained_by_fcl(
    positions: Positions, edges: Edges, faces: Faces, excluded: ExcludedPairs | None
) -> int:
    """Count the pairs of faces that cross according to python-fcl, though none may.

    Two faces may cross if a vertex or an edge of one and an element of the other are a pair that
    is left out.

    Args:
        positions: (n, 3) f8 [m].
        edges: (k, 2) i4.
        faces: (m, 3) i4.
        excluded: The pairs that are left out; None if there are none.
    """
    crossing = {(int(a), int(b)) for a, b in fcl.crossing_faces(positions, faces)}
    return len(crossing - _faces_of(excluded, faces)) if excluded is not None else len(crossing)


def _faces_of(excluded: ExcludedPairs, faces: Faces) -> set[tuple[int, int]]:
    """Return the pairs of faces that have the elements of pairs, the lower one first."""
    at_vertex: dict[int, set[int]] = {}
    for number, corners in enumerate(faces.tolist()):
        for corner in corners:
            at_vertex.setdefault(corner, set()).add(number)

    def having(vertices: list[int]) -> set[int]:
        return set.intersection(*(at_vertex.get(vertex, set()) for vertex in vertices))

    found = set()
    for row, kind in zip(excluded.nodes.tolist(), excluded.is_edge_edge, strict=True):
        split = 2 if kind else 1
        for one in having(row[:split]):
            found |= {(min(one, other), max(one, other)) for other in having(row[split:])}
    return found


def new_rows(before: AnyInts, after: AnyInts) -> int:
    """Count the rows that one array of whole numbers has and an earlier one has not.

    Args:
        before: (k, d).
        after: (l, d).
    """
    old = set(map(tuple, np.asarray(before).tolist()))
    return sum(tuple(row) not in old for row in np.asarray(after).tolist())
