"""Motions of a whole mesh in one step, most of which are linear maps.

A mesh that moves by a linear map x -> A x goes through the maps (1 - t) I + t A. It stays free of
intersections if none of them is singular, because each is then one to one. So for these steps it is
known exactly whether the proposed positions are the answer.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Faces, Floats, Positions
from validation.scenes.sheets import grid_faces


class Motion(NamedTuple):
    """A step without pinned vertices.

    Attributes:
        start: (n, 3) f8 [m].
        end: (n, 3) f8 [m], proposed.
        faces: (m, 3) i4.
    """

    start: Positions
    end: Positions
    faces: Faces


def flat_grid(n: int, x: float = 0.0, z: float = 0.0) -> tuple[Positions, Faces]:
    """Return a grid of n x n vertices, 1 m apart, in a plane of constant z.

    Args:
        n: Vertices along a side.
        x: Coordinate of the first column [m].
        z: Height of the plane [m].
    """
    i, j = np.divmod(np.arange(n * n), n)
    return np.column_stack((i + x, j, np.full(n * n, z))).astype(float), grid_faces(n)


def turned_block(degrees: float) -> Motion:
    """Turn two sheets as one body about the x axis, in a straight step.

    The map of a turn by an angle a is singular at t = 1/2 if a is 180 degrees, and never for
    smaller angles.

    Args:
        degrees: Angle of the turn; sine and cosine are exact for 180 degrees.
    """
    low, faces = flat_grid(3, -1.0, -0.25)
    high, _ = flat_grid(3, -0.75, 0.25)
    start = np.concatenate((low, high)) - (0.0, 1.0, 0.0)
    angle = np.radians(degrees)
    cos, sin = (-1.0, 0.0) if degrees == 180.0 else (np.cos(angle), np.sin(angle))
    turn = np.array([[1.0, 0.0, 0.0], [0.0, cos, sin], [0.0, -sin, cos]])
    return Motion(start, start @ turn, np.concatenate((faces, faces + 9)).astype(np.int32))


def scaled_ball(factor: float) -> Motion:
    """Scale an octahedron, with each face divided in four, about its middle.

    The map is singular if the factor is 0 or negative; the ball is then turned inside out.

    Args:
        factor: Of the map.
    """
    corners = np.array(
        [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]], np.float64
    )
    faces = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    points, split = list(corners), []
    middles: dict[tuple[int, int], int] = {}

    def middle(a: int, b: int) -> int:
        key = min(a, b), max(a, b)
        if key not in middles:
            middles[key] = len(points)
            points.append(0.625 * (corners[a] + corners[b]))
        return middles[key]

    for a, b, c in faces:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        split += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    start = np.array(points)
    return Motion(start, factor * start, np.array(split, np.int32))


def folded_sheet(n: int, fold: float) -> Motion:
    """Move the right half of a flat sheet over its left half, without leaving the plane.

    The proposed x of the right half is (1 - 2 fold) x. The path is free below a fold of 1/2, where
    the right half becomes a line; at 1 it lies on the mirrored left half.

    Args:
        n: Vertices along a side, odd.
        fold: Part of the way to the mirrored place.
    """
    start, faces = flat_grid(n, -0.5 * (n - 1))
    end = start.copy()
    right = start[:, 0] > 0.0
    end[right, 0] *= 1.0 - 2.0 * fold
    return Motion(start, end, faces)


def coplanar_grids(n: int, move: float) -> Motion:
    """Push two grids that start in one plane, side by side, into each other in this plane.

    Args:
        n: Vertices along a side of a grid.
        move: How far each grid moves toward the other one [m]; they start 0.5 m apart, and their
            edges are 1 m long.
    """
    left, faces = flat_grid(n, -0.25 - (n - 1))
    right, _ = flat_grid(n, 0.25)
    right[:, 1] += 0.375  # no vertex is level with another one
    start = np.concatenate((left, right))
    side = np.repeat([1.0, -1.0], n * n)
    end = start.copy()
    end[:, 0] += move * side
    return Motion(start, end, np.concatenate((faces, faces + n * n)).astype(np.int32))


def rippled_sheets(rng: np.random.Generator, n: int = 6) -> Motion:
    """Drive a rippled sheet through another one, up to half an edge deep.

    Args:
        rng: Draws the ripples and how deep each vertex goes.
        n: Vertices along a side of each sheet.
    """
    low, faces = flat_grid(n)
    high, _ = flat_grid(n, 0.31, 0.25)
    start = np.concatenate((low, high + (0.0, 0.17, 0.0)))
    start += 0.05 * rng.uniform(-1.0, 1.0, start.shape)
    end = start.copy()
    end[n * n :, 2] -= rng.uniform(0.3, 0.7, n * n)
    return Motion(start, end, np.concatenate((faces, faces + n * n)).astype(np.int32))


def centre(positions: Floats) -> Floats:
    """Return the mean of positions, (3,) f8 [m]: the centre of mass of equal masses."""
    return positions.mean(axis=0)
