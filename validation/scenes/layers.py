"""Flat layers above one another, whose best order under a proposal is known in closed form.

All layers are the same grid, so vertices stand in columns, each above a vertex of the layer below.
They start in order and move along z alone. On a free path the vertices of a column keep their
order, so heights that keep it with the thickness between them, and are closest to the proposed
ones, are the best end. That is isotonic regression: with z_i = x_i - i d the order is
z_0 <= z_1 <= ..., and the closest such numbers are means of neighbouring proposals.

Source: R. E. Barlow and others, Statistical Inference under Order Restrictions (1972), section 1.2.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from izo_ref.base.arrays import Faces, Flags, Floats, Positions
from validation.scenes.sheets import grid_faces

THICKNESS_M = 2.0**-10
GAP_M = 2.0**-4  # distance of neighbouring layers at the start
CELL_M = 2.0**-3  # length of the edges of the grid


class Layers(NamedTuple):
    """Layers, the lowest first, of which the outer ones may be pinned.

    Attributes:
        start: (k n^2, 3) f8 [m].
        end: (k n^2, 3) f8 [m], proposed.
        faces: (m, 3) i4.
        pinned: (k n^2,) b1.
        best: (k n^2, 3) f8 [m], the best end positions; None if nothing fits.
    """

    start: Positions
    end: Positions
    faces: Faces
    pinned: Flags
    best: Positions | None


def ordered(
    proposed: ArrayLike, thickness: float, low: float = -np.inf, high: float = np.inf
) -> Floats | None:
    """Return the heights closest to some proposed ones that keep their order and distance.

    Args:
        proposed: (k,) heights [m], the lowest layer first; all layers are equally heavy.
        thickness: Distance of neighbouring layers [m].
        low: Height of a pinned layer below the first one [m], or minus infinity.
        high: Height of a pinned layer above the last one [m], or infinity.

    Returns:
        (k,) f8 [m]; None if the layers do not fit between the pinned ones.
    """
    heights = np.asarray(proposed, np.float64)
    k = len(heights)
    if high - low < (k + 1) * thickness:
        return None
    pools: list[tuple[float, int]] = []  # mean and number of the layers that are moved as one
    for value in heights - thickness * np.arange(k):
        mean, n = float(value), 1
        while pools and pools[-1][0] > mean:
            other, m = pools.pop()
            mean, n = (mean * n + other * m) / (n + m), n + m
        pools.append((mean, n))
    pooled = np.repeat([mean for mean, _ in pools], [n for _, n in pools])
    least, most = low + thickness, high - k * thickness
    best = np.minimum(np.maximum(pooled, least), most) + thickness * np.arange(k)
    return np.asarray(best, np.float64)


def layers(
    end_heights: ArrayLike,
    n: int = 3,
    *,
    low: float | None = None,
    high: float | None = None,
    thickness: float = THICKNESS_M,
) -> Layers:
    """Make layers GAP_M apart that are proposed to end at some heights.

    Args:
        end_heights: (k,) proposed heights [m] of the free layers, the lowest first.
        n: Vertices along a side of a layer, at least 2.
        low: Height at which a pinned layer below all others ends [m]; None if there is none.
        high: Height at which a pinned layer above all others ends [m]; None if there is none.
        thickness: Distance that layers keep [m].
    """
    heights = np.asarray(end_heights, np.float64)
    ends = [low] * (low is not None) + heights.tolist() + [high] * (high is not None)
    best = ordered(
        heights, thickness, -np.inf if low is None else low, np.inf if high is None else high
    )
    size, k = n * n, len(ends)
    i, j = np.divmod(np.arange(size), n)
    start = np.empty((k, size, 3))
    start[:, :, :2] = CELL_M * np.column_stack((i, j))
    start[:, :, 2] = GAP_M * np.arange(k)[:, None]
    end = start.copy()
    end[:, :, 2] = np.array(ends)[:, None]
    pinned = np.zeros((k, size), bool)
    pinned[0], pinned[-1] = low is not None, pinned[-1] | (high is not None)
    known = None
    if best is not None:
        known = end.copy()
        own = slice(int(low is not None), k - int(high is not None))
        known[own, :, 2] = best[:, None]
        known = known.reshape(-1, 3)
    faces = size * np.arange(k)[:, None, None] + grid_faces(n)
    return Layers(
        start.reshape(-1, 3),
        end.reshape(-1, 3),
        faces.reshape(-1, 3).astype(np.int32),
        pinned.ravel(),
        known,
    )
