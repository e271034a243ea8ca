"""Frames of pairs in floats of both types, in parts that tests exchange for wrong ones."""

from fractions import Fraction

import numpy as np

from izo_ref.porting.reference.contact import Pair, meeting
from izo_ref.porting.reference.rounded import EPS

NUMBERS = {"f8": np.float64, "f4": np.float32}
APART = {"meets": 0}


def fused(a, b, c):
    """Return a b + c, rounded once, of finite floats; of others, a b + c."""
    if not np.isfinite([a, b, c]).all():
        return float(a) * float(b) + float(c)
    return float(Fraction(float(a)) * Fraction(float(b)) + Fraction(float(c)))


def dot(a, b):
    """Return a @ b as a processor with fused operations sums it: `@` depends on the processor."""
    total = a[0] * b[0]
    for i in range(1, len(a)):
        total = np.frompyfunc(fused, 3, 1)(a[i], b[i], total)
        total = np.asarray(total, a.dtype)[()]
    return total


def pair_of(inputs):
    """Return the pair of a case of stage S2 or S3."""
    return Pair(
        bool(inputs["is_edge_edge"]),
        np.reshape(inputs["start"], (4, 3)).tolist(),
        np.reshape(inputs["end"], (4, 3)).tolist(),
    )


def right_answer(pair):
    """Return whether a pair meets, and when, by the reference."""
    found = meeting(pair, 4)
    return APART if found is None else {"meets": 1, "toi": float(found.time)}


def unit(a):
    """Return a / |a|, without underflow."""
    with np.errstate(all="ignore"):  # nothing was apart at the start
        a = a / np.abs(a).max()
    return a / np.sqrt(dot(a, a))


def nodes_at(start, end, time):
    """Subtract first, then interpolate."""
    return (1 - time) * (start - start[0]) + time * (end - end[0])


def coordinates(x):
    """Return the coordinates on the face of the foot of the vertex."""
    n = np.cross(x[2] - x[1], x[3] - x[1])
    areas = np.array([dot(n, np.cross(x[i], x[j])) for i, j in ((2, 3), (3, 1), (1, 2))])
    return areas / dot(n, n)


def nearest(p, a, b):
    """Return the fraction of the edge a b that is nearest to p."""
    length_sq = dot(b - a, b - a)
    return np.clip(dot(p - a, b - a) / length_sq, 0, 1) if length_sq > 0 else a[0] * 0


def on_side(x, i, j):
    s = nearest(x[0], x[i], x[j])
    weights = np.zeros(4, x.dtype)
    weights[[0, i, j]] = 1, s - 1, -s
    return weights


def best_of(x, found):
    return min(found, key=lambda weights: dot(dot(weights, x), dot(weights, x)))


def face(x):
    with np.errstate(all="ignore"):
        inner = coordinates(x)
    if (inner > 0).all():
        return np.array([1, *-inner], x.dtype)
    return best_of(x, [on_side(x, i, j) for i, j in ((1, 2), (2, 3), (3, 1))])


def of_fractions(x, s, r):
    return np.array([1 - s, s, r - 1, -r], x.dtype)


def fractions(x):
    """Return where the lines of two edges are closest; NaN if they are parallel."""
    u, v, w = x[1] - x[0], x[3] - x[2], x[2] - x[0]
    n = np.cross(u, v)
    with np.errstate(all="ignore"):
        return dot(np.cross(w, v), n) / dot(n, n), dot(np.cross(w, u), n) / dot(n, n)


def edges(x):
    s, r = fractions(x)
    found = [of_fractions(x, s, r)] if 0 <= s <= 1 and 0 <= r <= 1 else []
    for end in (0, 1):
        found.append(of_fractions(x, end, nearest(x[end], x[2], x[3])))
        found.append(of_fractions(x, nearest(x[2 + end], x[0], x[1]), end))
    return best_of(x, found)


def no_side(gap, size, length, sides, eps):
    """Return whether the normal does not say from which side the pair came."""
    return not length > 64 * eps * sides or abs(gap) <= 64 * eps * size


RIGHT = {"nodes_at": nodes_at, "face": face, "edges": edges, "no_side": no_side}


def frame(inputs, dtype, parts):
    """Return the weights and the normal, by parts some of which may be wrong."""
    parts = RIGHT | parts
    number = NUMBERS[dtype]
    start, end = (np.array(inputs[k], number).reshape(4, 3) for k in ("start", "end"))
    x = parts["nodes_at"](start, end, number(inputs["toi"]))
    closest = parts["edges" if inputs["is_edge_edge"] else "face"]
    u, v = (x[1] - x[0], x[3] - x[2]) if inputs["is_edge_edge"] else (x[2] - x[1], x[3] - x[1])
    normal, weights, begin = np.cross(u, v), closest(x), start - start[0]
    length = np.sqrt(dot(normal, normal))
    sides = np.sqrt(dot(u, u) * dot(v, v))
    with np.errstate(all="ignore"):
        gap = dot(normal / length, dot(weights, begin))
    if parts["no_side"](gap, np.abs(begin).max(), length, sides, EPS[dtype]):
        return {"weights": weights.tolist(), "normal": unit(dot(closest(begin), begin)).tolist()}
    return {"weights": weights.tolist(), "normal": (unit(normal) * np.sign(gap)).tolist()}
