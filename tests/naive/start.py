"""Whether a path is free right after its start, by looking at a time close enough to it."""

from fractions import Fraction
from itertools import combinations

from tests.naive.simplices import simplices_meet
from validation.oracles import path as path_oracle

# A time before every root after 0 of the polynomials whose signs decide whether an edge and a face
# meet. They are of degree 3 at most. Coordinates that are multiples of 2^-200 and below 2^10 give
# integer coefficients below 2^640, and by Cauchy's bound no root after 0 is below 2^-641.
SOON = Fraction(1, 2**1000)


def elements_of(faces):
    """Return the edges and the faces of a mesh as tuples."""
    faces = [tuple(int(v) for v in face) for face in faces]
    return sorted({edge for face in faces for edge in combinations(sorted(face), 2)}), faces


def pairs_of(n_vertices, faces):
    """Yield kind and nodes of each vertex-face and edge-edge pair without a common vertex."""
    edges, faces = elements_of(faces)
    for v in range(n_vertices):
        yield from ((False, (v, *face)) for face in faces if v not in face)
    yield from ((True, (*a, *b)) for a, b in combinations(edges, 2) if not set(a) & set(b))


def pair_key(is_edge_edge, nodes):
    """Return a key that does not depend on the order in which a pair is written."""
    nodes = [int(node) for node in nodes]
    split = 2 if is_edge_edge else 1
    return frozenset((frozenset(nodes[:split]), frozenset(nodes[split:])))


def keys_of(pairs):
    """Return the keys of a record of pairs, or of None."""
    if pairs is None:
        return set()
    return {pair_key(*pair) for pair in zip(pairs.is_edge_edge, pairs.nodes, strict=True)}


def pairs_that_meet(start, end, faces, touching=()):
    """Return the keys of all pairs that meet on a path; those that touch at t = 0, after it."""
    found = set()
    for is_edge_edge, nodes in pairs_of(len(start), faces):
        rows, key = list(nodes), pair_key(is_edge_edge, nodes)
        ask = path_oracle.meets_after_start if key in touching else path_oracle.meets
        if _boxes_meet(start, end, rows, 2 if is_edge_edge else 1) and ask(
            is_edge_edge, start[rows], end[rows]
        ):
            found.add(key)
    return found


def five_pairs(edge, face):
    """Return the keys of the vertex-face and edge-edge pairs of an edge and a face."""
    a, b, c = face
    return {pair_key(False, (v, *face)) for v in edge} | {
        pair_key(True, (*edge, *side)) for side in ((a, b), (b, c), (c, a))
    }


def edges_through_faces_soon(start, end, faces, left_out):
    """Return the edges and faces without a common vertex that meet right after t = 0.

    Those of which one of the five pairs is left out do not count.
    """

    def now(a, b):
        return Fraction(float(a)) * (1 - SOON) + Fraction(float(b)) * SOON

    points = [list(map(now, p, q)) for p, q in zip(start, end, strict=True)]
    edges, faces = elements_of(faces)
    found = []
    for edge in edges:
        for face in faces:
            rows = [*edge, *face]
            if set(edge) & set(face) or not _boxes_meet(start, start, rows, 2):
                continue
            if five_pairs(edge, face) & left_out:
                continue
            p, q, *corners = (points[v] for v in rows)
            if _volume(p, *corners) * _volume(q, *corners) > 0:
                continue  # the edge is on one side of the plane of the face
            if simplices_meet([p, q], corners):
                found.append((edge, face))
    return found


def _volume(p, a, b, c):
    """Return det(a - p, b - p, c - p)."""
    u, v, w = ([x - y for x, y in zip(corner, p, strict=True)] for corner in (a, b, c))
    return (
        u[0] * (v[1] * w[2] - v[2] * w[1])
        + u[1] * (v[2] * w[0] - v[0] * w[2])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
    )


def _boxes_meet(start, end, rows, split):
    """Return whether the boxes of the two sides of a pair meet, over the whole path."""
    low = [min(x) for x in zip(*start[rows[:split]], *end[rows[:split]], strict=True)]
    high = [max(x) for x in zip(*start[rows[:split]], *end[rows[:split]], strict=True)]
    other_low = [min(x) for x in zip(*start[rows[split:]], *end[rows[split:]], strict=True)]
    other_high = [max(x) for x in zip(*start[rows[split:]], *end[rows[split:]], strict=True)]
    return all(
        a <= d and c <= b for a, b, c, d in zip(low, high, other_low, other_high, strict=True)
    )
