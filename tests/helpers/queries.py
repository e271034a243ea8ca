"""Single pairs on a path whose answer is known."""

import numpy as np
import pytest

from validation.scenes.queries import Queries, degenerate_queries
from validation.study import steps

# Our own degenerate cases, and the published ones if the larger step files are there.
SOURCES = ("own", pytest.param("published", marks=pytest.mark.data))
EACH = 20  # queries drawn of each kind of our own cases


def queries_of(source, rng) -> Queries:
    """Read the published queries, or draw our own, according to one of `SOURCES`."""
    if source == "own":
        return degenerate_queries(rng, EACH)
    data = steps.load("ccd-queries")
    return Queries(
        data["vertices"],
        data["kind_names"][data["kind"]] == "ee",
        data["truth"],
        [str(data["names"][name]) for name in data["name"]],
    )


def constructed_meetings(rng, n, is_edge_edge):
    """Draw pairs that meet exactly at a known time.

    All positions, times and weights are integers times powers of two, so every position is a
    float and the meeting is exact. Times are multiples of 1/16, and weights multiples of 1/8.
    Some draws are flat, some graze, and some have edges or faces without size.

    Args:
        rng: draws everything.
        n: number of pairs.
        is_edge_edge: kind of all pairs.

    Returns:
        start (n, 4, 3), end (n, 4, 3) and the time of the meeting (n,), all f8.
    """
    largest = 2 ** int(rng.integers(1, 22))
    x, v = rng.integers(-largest, largest + 1, (2, n, 4, 3)).astype(float)
    x *= 2.0 ** rng.integers(-12, 1, (n, 1, 3))
    v *= 2.0 ** rng.integers(-12, 1, (n, 1, 3))
    kind = rng.integers(5)
    if kind == 0:
        x[..., 2] = v[..., 2] = 0.0
    elif kind == 1:
        v[:, 1:] = v[:, 1:2]
    elif kind == 2:
        x[:, 3], v[:, 3] = x[:, 2], v[:, 2]
    steps = 1 if kind == 3 else 8  # kind 3 meets at corners and ends of edges only
    if is_edge_edge:
        s, r = rng.integers(0, steps + 1, (2, n)) / steps
        weights = np.column_stack((1 - s, s, -(1 - r), -r))
        moved = slice(0, 2)
    else:
        corners = rng.multinomial(steps, [1 / 3] * 3, n) / steps
        weights = np.column_stack((np.ones(n), -corners))
        moved = slice(0, 1)
    apart = np.einsum("jk,jkx->jx", weights, x)
    x[:, moved] -= apart[:, None, :]
    if kind == 4:  # at the meeting, the relative velocity lies in the plane
        slide = x[:, 2] - x[:, 3] if is_edge_edge else x[:, 1] - x[:, 2]
        relative = np.einsum("jk,jkx->jx", weights, v)
        v[:, moved] += (rng.integers(-2, 3, (n, 1)) * slide - relative)[:, None, :]
    t = rng.integers(0, 17, n)[:, None, None] / 16
    return x - t * v, x + (1 - t) * v, t.ravel()
