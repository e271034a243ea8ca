"""Faults of a mesh that keep it from being resolved, or that look like contact."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Faces, Flags, Indices, Positions
from izo_ref.base.exact_vectors import NOWHERE, cross, integer_points, minus
from izo_ref.detection.rows import equal_rows

# A face is looked at exactly if its area is below this fraction of the square of its longest side.
# A side is a rounded difference, whose error is 2^-53 of itself. So the area of a flat face is
# computed as less than 16 * 2^-53 of that square, wherever the face is.
THIN = 2.0**-40


class MeshFaults(NamedTuple):
    """Faults of a mesh.

    Attributes:
        repeated: (k,) i8, faces that name a vertex twice; they are refused when it is resolved.
        flat: (k,) i8, other faces without area, whose corners are on one line or at one place.
        coincident: (k,) i8, vertices of faces that are at the place of another one of lower number.
    """

    repeated: Indices
    flat: Indices
    coincident: Indices


def find_faults(positions: Positions, faces: Faces) -> MeshFaults:
    """Find the faults of a mesh at rest, exactly.

    Args:
        positions: (n, 3) f8 [m].
        faces: (m, 3) i4, which may name a vertex twice.
    """
    a, b, c = faces.T
    is_repeated = (a == b) | (b == c) | (c == a)
    flat = np.flatnonzero(~is_repeated & _may_be_flat(positions, faces))
    flat = np.array([i for i in flat.tolist() if _is_flat(positions[faces[i]])], np.int64)
    used = np.unique(faces).astype(np.int64)
    place = equal_rows(positions[used] + 0.0)  # -0 and 0 are one place
    _, lowest = np.unique(place, return_index=True)
    several = np.ones(len(used), bool)
    several[lowest] = False
    return MeshFaults(np.flatnonzero(is_repeated), flat, used[several])


def _may_be_flat(positions: Positions, faces: Faces) -> Flags:
    """Return which faces may have no area, as far as rounding can tell, (m,) b1."""
    a, b, c = (positions[faces[:, k]] for k in range(3))
    with np.errstate(all="ignore"):
        sides = b - a, c - a, c - b
        longest_sq = np.max([(side * side).sum(axis=1) for side in sides], axis=0)
        area = np.linalg.norm(np.cross(sides[0], sides[1]), axis=1)
    # NaN, after an overflow, is looked at as well.
    return np.asarray(~(area > THIN * longest_sq))


def _is_flat(corners: Positions) -> bool:
    """Return whether three points are on one line, exactly."""
    a, b, c = integer_points(corners)
    return cross(minus(b, a), minus(c, a)) == NOWHERE
