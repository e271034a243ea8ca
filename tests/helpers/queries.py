"""Queries of single pairs on a path, with their answers."""

import numpy as np
import pytest

from validation.scenes.queries import Queries, degenerate_queries
from validation.study import steps

# Our own degenerate cases, and the published ones where the step files are.
SOURCES = ("own", pytest.param("published", marks=pytest.mark.data))
EACH = 20  # of our own cases


def queries_of(source, rng) -> Queries:
    """Read or draw the queries of one of SOURCES."""
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
    """Pairs that meet exactly, at times and with weights that are multiples of 1/16 and 1/8.

    Integers and powers of two throughout, so that every position is a float and the meeting
    is no approximation. Some are flat, some graze, some have elements without size.
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
    steps = 1 if kind == 3 else 8  # corners and ends only
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
    if kind == 4:  # the velocity at the contact lies in the plane
        slide = x[:, 2] - x[:, 3] if is_edge_edge else x[:, 1] - x[:, 2]
        relative = np.einsum("jk,jkx->jx", weights, v)
        v[:, moved] += (rng.integers(-2, 3, (n, 1)) * slide - relative)[:, None, :]
    t = rng.integers(0, 17, n)[:, None, None] / 16
    return x - t * v, x + (1 - t) * v, t.ravel()
