"""Which edges of a mesh meet which faces, by trying all of them in fractions."""

from itertools import combinations

from tests.naive.simplices import simplices_meet


def edges_through_faces(positions, faces):
    """Return the edges and faces without a common vertex that meet, as a set of two tuples.

    Args:
        positions: (n, 3), of few vertices.
        faces: (m, 3).
    """
    faces = [tuple(int(v) for v in face) for face in faces]
    edges = sorted({edge for face in faces for edge in combinations(sorted(face), 2)})
    return {
        (edge, face)
        for edge in edges
        for face in faces
        if not set(edge) & set(face) and _meet(positions, edge, face)
    }


def groups_of_crossings(crossings, faces):
    """Count the contours: chains of crossings of which each two neighbours are of two same faces.

    Args:
        crossings: Edges and faces, as `edges_through_faces` returns them.
        faces: (m, 3).
    """
    faces = [tuple(int(v) for v in face) for face in faces]
    of = {
        crossing: {frozenset((own, crossing[1])) for own in faces if set(crossing[0]) <= set(own)}
        for crossing in crossings
    }
    left, count = set(crossings), 0
    while left:
        count, chain = count + 1, [left.pop()]
        while chain:
            near = {other for other in left if of[other] & of[chain[-1]]}
            chain.pop()
            chain.extend(near)
            left -= near
    return count


def distance_to_face(point, corners):
    """Return the distance of a point from a face, by trisection in both directions of the face.

    The distance is a convex function of the place in the face, and so is the least one along lines.

    Args:
        point: (3,).
        corners: (3, 3).
    """
    a, b, c = corners

    def apart(s, t):
        return float((((a + s * (b - a) + t * (c - a)) - point) ** 2).sum()) ** 0.5

    return _least(lambda t: _least(lambda s: apart(s, t), 1.0 - t), 1.0)


def _least(function, end):
    """Return the least value of a convex function from 0 to `end`."""
    low, high = 0.0, end
    for _ in range(60):
        first, second = low + (high - low) / 3.0, high - (high - low) / 3.0
        if function(first) <= function(second):
            high = second
        else:
            low = first
    return function(0.5 * (low + high))


def _meet(positions, edge, face):
    """Compare the boxes first, which is exact too."""
    first, second = positions[list(edge)], positions[list(face)]
    if (first.min(axis=0) > second.max(axis=0)).any():
        return False
    if (second.min(axis=0) > first.max(axis=0)).any():
        return False
    return simplices_meet(first, second)
