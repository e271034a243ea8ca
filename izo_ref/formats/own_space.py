"""Positions of a mesh in its own space, as float32 numbers of a file, and in the world."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import AnyArray, Floats, Positions
from izo_ref.base.errors import FileFormatError

IDENTITY = np.eye(4)
SMALLEST = 1e-12  # least ratio of the smallest to the largest stretch that can be undone


def check_matrix(matrix: Floats, where: str) -> Floats:
    """Return a transform that can be undone.

    Args:
        matrix: (4, 4) f8; a row vector (x, y, z, 1) times it is the position in the world.
        where: Path, frame and mesh, for the message.

    Raises:
        FileFormatError: It is not affine, not finite, or flattens the mesh.
    """
    if not np.isfinite(matrix).all() or (matrix[:, 3] != IDENTITY[:, 3]).any():
        raise FileFormatError(f"{where}: expected a transform that is affine and finite")
    stretches = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    if not (np.isfinite(stretches).all() and stretches[2] > SMALLEST * stretches[0]):
        raise FileFormatError(
            f"{where}: expected a transform that can be undone, found one that flattens the mesh "
            f"(it stretches by {stretches[0]:.3g}, {stretches[1]:.3g} and {stretches[2]:.3g})"
        )
    return matrix


def to_world(own: AnyArray, matrix: Floats) -> Positions:
    """Return positions in the world, (n, 3) f8.

    Args:
        own: (n, 3) f4, positions in the space of the mesh.
        matrix: (4, 4) f8, from `check_matrix`. The identity changes no bit.
    """
    with np.errstate(all="ignore"):  # callers look at what is not finite
        own = own.astype(np.float64)
        if np.array_equal(matrix, IDENTITY):
            return own
        # not `@`, whose sums may depend on the number of rows
        rows = (own[:, k : k + 1] * matrix[k, :3] for k in range(3))
        return sum(rows, start=np.zeros_like(own)) + matrix[3, :3]


def to_own(world: Positions, matrix: Floats, old: AnyArray, coarser: int = 0) -> AnyArray:
    """Return the float32 numbers that a file holds for positions in the world.

    Positions in the world that `to_world` returned for an answer of this function have the same
    positions in the world again, so a caller can round first, certify, and write afterwards.

    Args:
        world: (n, 3) f8.
        matrix: (4, 4) f8, from `check_matrix`.
        old: (n, 3) f4, what was read. A vertex that stays where it was keeps its bits.
        coarser: Bits that are dropped beyond those that a transform loses.

    Returns:
        (n, 3) f4; infinite where a number is too large for float32.
    """
    stays = (world == to_world(old, matrix)).all(axis=1)
    if stays.all():
        return old
    with np.errstate(all="ignore"):
        if np.array_equal(matrix, IDENTITY):
            own = world.astype(np.float32)
        else:
            moved = world - matrix[3, :3]
            own = np.linalg.solve(matrix[:3, :3].T, moved.T).T
            own = _on_grid(own, matrix, coarser).astype(np.float32)
    return np.where(stays[:, None], old, own)


def _on_grid(own: AnyArray, matrix: Floats, coarser: int) -> AnyArray:
    """Round positions to a grid that is coarser than the errors of a transform and its inverse.

    With u = 2^-53, the way to the world and back errs by less than 32 u (3 m s + t) / r: m is the
    largest coordinate, t the shift, and s and r are the largest and the smallest stretch. The grid
    is at least 2^-44 times that without 32 u, so it is 16 times as coarse as the error, and the way
    back ends at the same number. It depends on m as float32, which the way does not change.
    `coarser` is a number of bits that are dropped beyond these.
    """
    stretches = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    largest = np.abs(own).max(axis=1, initial=0).astype(np.float32).astype(np.float64)
    reach = (3 * largest * stretches[0] + np.abs(matrix[3, :3]).max()) / stretches[2]
    _, exponents = np.frexp(reach)  # reach < 2^exponent
    grid = np.ldexp(1.0, exponents - 44 + coarser)[:, None]
    return np.round(own / grid) * grid


def check_finite(positions: AnyArray, where: str) -> None:
    """Check that positions are finite.

    Args:
        positions: (n, 3) floats.
        where: Path, frame and mesh, for the message.

    Raises:
        FileFormatError: One is not; names the first vertex.
    """
    wrong = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(wrong):
        raise FileFormatError(
            f"{where}: expected finite positions, found {positions[wrong[0]].tolist()} at vertex "
            f"{wrong[0]}"
        )


def check_polygons(counts: AnyArray, corners: AnyArray, n_vertices: int, where: str) -> None:
    """Check that polygons name vertices of their mesh.

    Args:
        counts: (k,) whole numbers, corners of each polygon.
        corners: (sum of counts,) whole numbers, vertices.
        n_vertices: Number of vertices of the mesh.
        where: Path and mesh, for the message.

    Raises:
        FileFormatError: A count is negative, the counts do not sum to the number of corners, or a
            corner is no vertex.
    """
    if len(counts) and counts.min() < 0:
        raise FileFormatError(f"{where}: expected counts of corners, found {counts.min()}")
    if counts.sum(dtype=np.int64) != len(corners):
        raise FileFormatError(
            f"{where}: expected {counts.sum(dtype=np.int64)} corners, as the polygons have, found "
            f"{len(corners)}"
        )
    if len(corners) and not 0 <= corners.min() <= corners.max() < n_vertices:
        raise FileFormatError(
            f"{where}: expected vertices from 0 to {n_vertices - 1} in the polygons, found "
            f"{corners.min()} to {corners.max()}"
        )
