"""Whether a mesh intersects at rest, and which pairs meet on a path, by ipctk.

Question: does an edge meet a face at rest, and which vertex-face and edge-edge pairs meet while
the vertices move on straight lines?

Method: ipctk, the IPC Toolkit. Its linear bounding-volume hierarchy finds candidate pairs, and
Tight Inclusion decides them by interval arithmetic.

Independent of `izo_ref`: ipctk has its own trees, and its method of inclusion is different.

Limits: Tight Inclusion is conservative. Where it cannot decide, because of its tolerance or because
it reached its number of iterations, it reports that the pair meets. So it never misses a pair, and
it also reports pairs that only come within its tolerance. With the settings here, a vertex that
stops 1e-10 of its way before a face is no hit. With the defaults, which scale times back by 0.8, a
vertex that stops 1e-4 of its way before the face is a hit. Pairs that touch at the start are hits
at time 0. Pairs with a common vertex are not examined.
"""

import functools
import subprocess
import sys
from collections.abc import Iterator
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from validation.oracles.answer import Flags, Floats, Indices

CHUNK = 1000  # pairs that one call decides together; only a chunk with a hit is searched by pair

# A program that makes every call of this module once.
PROBE = """
import ipctk, numpy
positions = numpy.eye(3)
mesh = ipctk.CollisionMesh(positions, [[0, 1], [0, 2], [1, 2]], [[0, 1, 2]])
ipctk.Candidates().build(mesh, positions, positions, 0.0, ipctk.LBVH())
ipctk.has_intersections(mesh, positions)
"""


@functools.cache
def unusable() -> str | None:
    """Return the reason why ipctk does not run on this machine; None if it does.

    Some wheels of ipctk (1.6.1 for Python 3.12 and 3.13) use instructions that not every CPU has,
    and end the process. So this function tries ipctk in another process, once.
    """
    run = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True)
    if run.returncode == 0:
        return None
    lines = run.stderr.strip().splitlines()
    return lines[-1] if lines else f"it ends its process with signal {-run.returncode}"


def has_intersections(positions: ArrayLike, edges: Indices, faces: Indices) -> bool:
    """Return whether an edge meets a face that it shares no vertex with.

    ipctk reports no intersection for positions that are NaN, so they are rejected here.

    Args:
        positions: (n_vertices, 3) [m].
        edges: (n_edges, 2) vertex indices.
        faces: (n_faces, 3) vertex indices.

    Returns:
        Whether the mesh intersects.

    Raises:
        ValueError: A position is not finite.
    """
    import ipctk

    positions = _finite("positions", positions)
    if len(edges) == 0 or len(faces) == 0:
        return False
    return ipctk.has_intersections(ipctk.CollisionMesh(positions, edges, faces), positions)


class PathHits(NamedTuple):
    """The pairs that meet on a path."""

    nodes: Indices  # (k, 4) int, a vertex and a face's corners, or the ends of one edge and another
    is_edge_edge: Flags  # (k,) b1
    toi: Floats  # (k,) f8, when each pair meets, or a little before
    complete: bool  # these are all pairs that meet; False if there are more than were asked for


def path_hits(
    positions_t0: ArrayLike,
    positions_t1: ArrayLike,
    edges: ArrayLike,
    faces: ArrayLike,
    at_most: int = 1000,
    left_out: tuple[ArrayLike, ArrayLike] | None = None,
) -> PathHits:
    """Find the vertex-face and edge-edge pairs that meet on straight paths, by Tight Inclusion.

    Args:
        positions_t0: (n_vertices, 3) [m], start of the path.
        positions_t1: (n_vertices, 3) [m], end of the path.
        edges: (n_edges, 2) vertex indices.
        faces: (n_faces, 3) vertex indices.
        at_most: Number of hits to return; the search ends when it finds one more.
        left_out: Pairs that may meet, and are not looked at: (k, 4) vertex indices, a vertex and a
            face's corners, or the ends of one edge and another; and (k,) bool, True for two edges.

    Returns:
        The hits. A pair with a common vertex is never among them.

    Raises:
        ValueError: A position is not finite.
    """
    start = _finite("positions_t0", positions_t0)
    end = _finite("positions_t1", positions_t1)
    edges, faces = np.asarray(edges, np.int32), np.asarray(faces, np.int32)
    skipped = None if left_out is None else _numbers(*left_out, edges, faces)
    found = list(islice(_hits(start, end, edges, faces, skipped), at_most + 1))
    complete = len(found) <= at_most
    nodes, kinds, toi = zip(*found[:at_most], strict=True) if found[:at_most] else ((), (), ())
    nodes = np.array(nodes, int).reshape(-1, 4)
    return PathHits(nodes, np.array(kinds, bool), np.array(toi, float), complete)


def _numbers(
    nodes: ArrayLike, is_edge_edge: ArrayLike, edges: Indices, faces: Indices
) -> set[tuple[bool, int, int]]:
    """Return pairs as ipctk numbers them: vertex and face, or two edges, the lower one first."""
    edge_of = {tuple(sorted(row)): i for i, row in enumerate(edges.tolist())}
    face_of = {tuple(sorted(row)): i for i, row in enumerate(faces.tolist())}
    found = set()
    for row, kind in zip(np.asarray(nodes).tolist(), np.asarray(is_edge_edge), strict=True):
        if kind:
            one, other = sorted((edge_of[tuple(sorted(row[:2]))], edge_of[tuple(sorted(row[2:]))]))
            found.add((True, one, other))
        else:
            found.add((False, row[0], face_of[tuple(sorted(row[1:]))]))
    return found


def _hits(
    start: Floats,
    end: Floats,
    edges: Indices,
    faces: Indices,
    skipped: set[tuple[bool, int, int]] | None = None,
) -> Iterator[tuple[Any, bool, float]]:
    """Yield nodes, kind and time of each pair that meets."""
    import ipctk

    mesh = ipctk.CollisionMesh(start, edges, faces)
    candidates = ipctk.Candidates()
    candidates.build(mesh, start, end, 0.0, ipctk.LBVH())
    ccd = ipctk.TightInclusionCCD(tolerance=1e-9, max_iterations=10**7, conservative_rescaling=1.0)

    def is_free(pairs: list[Any], is_edge_edge: bool) -> bool:
        some = ipctk.Candidates()
        if is_edge_edge:
            some.ee_candidates = pairs
        else:
            some.fv_candidates = pairs
        return some.is_step_collision_free(mesh, start, end, 0.0, ccd)

    # compiled code decides many pairs at once; only chunks with a hit are examined pair by pair
    if skipped is None and candidates.is_step_collision_free(mesh, start, end, 0.0, ccd):
        return
    for pairs, is_edge_edge in _in_order(candidates, skipped or set()):
        for first in range(0, len(pairs), CHUNK):
            chunk = pairs[first : first + CHUNK]
            for pair in [] if is_free(chunk, is_edge_edge) else chunk:
                nodes = pair.vertex_ids(edges, faces)
                points = start[nodes].ravel(), end[nodes].ravel()
                met, toi = pair.ccd(*points, 0.0, 1.0, ccd)
                if met:
                    yield nodes, is_edge_edge, toi


def _in_order(
    candidates: Any, skipped: set[tuple[bool, int, int]]
) -> tuple[tuple[list[Any], bool], tuple[list[Any], bool]]:
    """Sort the vertex-face and the edge-edge pairs, since parallel trees list them in any order."""
    import ipctk

    numbers = sorted((c.vertex_id, c.face_id) for c in candidates.fv_candidates)
    vertex_face = [
        ipctk.FaceVertexCandidate(face, vertex)
        for vertex, face in numbers
        if (False, vertex, face) not in skipped
    ]
    ends = sorted(sorted((c.edge0_id, c.edge1_id)) for c in candidates.ee_candidates)
    edge_edge = [ipctk.EdgeEdgeCandidate(*pair) for pair in ends if (True, *pair) not in skipped]
    return (vertex_face, False), (edge_edge, True)


def _finite(name: str, positions: ArrayLike) -> Floats:
    """Return positions as f8; raise a ValueError if one is not finite."""
    positions = np.asarray(positions, float)
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(bad):
        raise ValueError(f"{name}: expected finite, vertex {bad[0]} is {positions[bad[0]]}")
    return positions
