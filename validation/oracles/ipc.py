"""Whether a mesh intersects at rest and what meets on a path, by ipctk.

Tight Inclusion is conservative: where it cannot tell, because of its tolerance or because
it reached its iterations, it says that the pair meets. So it never misses, and it reports
what only comes within its tolerance. With the settings here a vertex that stops 1e-10 of
its way before a face is no hit; with the defaults, which scale times back by 0.8, one that
stops 1e-4 before it is. Pairs that touch at the start are hits at time 0.
"""

import functools
import subprocess
import sys
from itertools import islice

import numpy as np

CHUNK = 1000  # pairs that are asked for together before each is asked for


PROBE = """
import ipctk, numpy
positions = numpy.eye(3)
mesh = ipctk.CollisionMesh(positions, [[0, 1], [0, 2], [1, 2]], [[0, 1, 2]])
ipctk.Candidates().build(mesh, positions, positions, 0.0, ipctk.LBVH())
ipctk.has_intersections(mesh, positions)
"""


@functools.cache
def unusable():
    """Why ipctk cannot be asked on this machine; None if it can.

    Some of its wheels (1.6.1 for Python 3.12 and 3.13) hold instructions that not every
    processor has, and end the process. So another process tries first, once.
    """
    run = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True)
    if run.returncode == 0:
        return None
    said = run.stderr.strip().splitlines()
    return said[-1] if said else f"it ends its process with signal {-run.returncode}"


def has_intersections(positions, edges, faces):
    """Whether an edge meets a face it has no vertex in common with.

    ipctk takes NaN for no intersection, hence the check.

    Args:
        positions: (n_vertices, 3) [m].
        edges: (n_edges, 2) vertex indices.
        faces: (n_faces, 3) vertex indices.

    Raises:
        ValueError: a position is not finite.
    """
    import ipctk

    positions = _finite("positions", positions)
    if len(edges) == 0 or len(faces) == 0:
        return False
    return ipctk.has_intersections(ipctk.CollisionMesh(positions, edges, faces), positions)


def path_hits(positions_t0, positions_t1, edges, faces, at_most=1000):
    """Vertex-face and edge-edge pairs that meet on straight paths, by Tight Inclusion.

    Pairs with a vertex in common are not asked about.

    Args:
        positions_t0, positions_t1: (n_vertices, 3) [m].
        edges: (n_edges, 2) vertex indices.
        faces: (n_faces, 3) vertex indices.
        at_most: hits to return; with one more the search ends.

    Returns:
        nodes: (k, 4) int, a vertex, then the face's corners; or the ends of one edge, then
            of the other.
        is_edge_edge: (k,) bool.
        toi: (k,) f8, when each pair meets, or a little before.
        complete: these are all; False if there are more than `at_most`.

    Raises:
        ValueError: a position is not finite.
    """
    import ipctk

    start = _finite("positions_t0", positions_t0)
    end = _finite("positions_t1", positions_t1)
    edges, faces = np.asarray(edges, np.int32), np.asarray(faces, np.int32)
    mesh = ipctk.CollisionMesh(start, edges, faces)
    candidates = ipctk.Candidates()
    candidates.build(mesh, start, end, 0.0, ipctk.LBVH())
    ccd = ipctk.TightInclusionCCD(tolerance=1e-9, max_iterations=10**7, conservative_rescaling=1.0)

    def is_free(pairs, is_edge_edge):
        some = ipctk.Candidates()
        if is_edge_edge:
            some.ee_candidates = pairs
        else:
            some.fv_candidates = pairs
        return some.is_step_collision_free(mesh, start, end, 0.0, ccd)

    def hits():
        # compiled code decides about many; only chunks that are not free are asked one by one
        if candidates.is_step_collision_free(mesh, start, end, 0.0, ccd):
            return
        for pairs, is_edge_edge in _in_order(candidates):
            for first in range(0, len(pairs), CHUNK):
                chunk = pairs[first : first + CHUNK]
                for pair in [] if is_free(chunk, is_edge_edge) else chunk:
                    nodes = pair.vertex_ids(edges, faces)
                    points = start[nodes].ravel(), end[nodes].ravel()
                    met, toi = pair.ccd(*points, 0.0, 1.0, ccd)
                    if met:
                        yield nodes, is_edge_edge, toi

    found = list(islice(hits(), at_most + 1))
    complete = len(found) <= at_most
    nodes, kinds, toi = zip(*found[:at_most], strict=True) if found[:at_most] else ((), (), ())
    nodes = np.array(nodes, int).reshape(-1, 4)
    return nodes, np.array(kinds, bool), np.array(toi, float), complete


def _in_order(candidates):
    """Vertex-face and edge-edge pairs; trees built in parallel list them in any order."""
    import ipctk

    vertex_face = sorted(candidates.fv_candidates, key=lambda c: (c.vertex_id, c.face_id))
    ends = sorted(sorted((c.edge0_id, c.edge1_id)) for c in candidates.ee_candidates)
    return (vertex_face, False), ([ipctk.EdgeEdgeCandidate(*pair) for pair in ends], True)


def _finite(name, positions):
    positions = np.asarray(positions, float)
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(bad):
        raise ValueError(f"{name}: expected finite, vertex {bad[0]} is {positions[bad[0]]}")
    return positions
