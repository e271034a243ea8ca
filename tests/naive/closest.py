"""Distance of a vertex and a face, or of two edges, by trying every pair of their features."""

import numpy as np

L = np.longdouble


def _point_segment(p, a, b):
    """Return the vector from p to the closest point of the segment a b."""
    d = b - a
    length_sq = d @ d
    s = L(0) if length_sq == 0 else np.clip((p - a) @ d / length_sq, L(0), L(1))
    return a + s * d - p


def _point_plane(p, a, b, c):
    """Return the vector from p to its foot in the plane, or None if that is not in the face."""
    n = np.cross(b - a, c - a)
    if n @ n == 0:
        return None
    foot = p - ((p - a) @ n) / (n @ n) * n
    inside = all(np.cross(v - u, foot - u) @ n >= 0 for u, v in ((a, b), (b, c), (c, a)))
    return foot - p if inside else None


def _line_line(a, b, c, d):
    """Return the vector between two lines, or None if it does not join points of the edges."""
    u, v = b - a, d - c
    n = np.cross(u, v)
    if n @ n == 0:
        return None
    s = np.cross(c - a, v) @ n / (n @ n)
    r = np.cross(c - a, u) @ n / (n @ n)
    inside = 0 <= s <= 1 and 0 <= r <= 1
    return (a + s * u) - (c + r * v) if inside else None


def closest_vector(is_edge_edge, points):
    """Return the vector from the closest point of the second side to that of the first.

    Args:
        is_edge_edge: kind of the pair.
        points: (4, 3) positions of its nodes [m].
    """
    a, b, c, d = np.asarray(points, L)
    if is_edge_edge:
        back = [_line_line(a, b, c, d), _point_segment(c, a, b), _point_segment(d, a, b)]
        forth = [_point_segment(a, c, d), _point_segment(b, c, d)]
    else:
        back, forth = [], [_point_plane(a, b, c, d)]
        forth += [_point_segment(a, b, c), _point_segment(a, c, d), _point_segment(a, d, b)]
    vectors = [v for v in back if v is not None] + [-v for v in forth if v is not None]
    return min(vectors, key=lambda v: v @ v)


def distance(is_edge_edge, start, end, t):
    """Return the distance of a pair at time t, computed in long double.

    Args:
        is_edge_edge: kind of the pair.
        start, end: (4, 3) positions of its nodes at t = 0 and t = 1 [m].
        t: time.
    """
    start, end, t = np.asarray(start, L), np.asarray(end, L), L(t)
    vector = closest_vector(is_edge_edge, (1 - t) * start + t * end)
    return float(np.sqrt(vector @ vector))
