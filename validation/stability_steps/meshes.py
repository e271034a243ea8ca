"""Small meshes and motions from which the families of steps are put together."""

import numpy as np

from izo_ref.base.arrays import Faces, Floats, Positions

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32)
OCTAHEDRON = np.array(
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
)
AXES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)


def join(parts: list[tuple[Positions, Faces]]) -> tuple[Positions, Faces]:
    """Put meshes side by side into one mesh, without joining vertices."""
    firsts = np.cumsum([0, *(len(positions) for positions, _ in parts)])
    faces = [part[1] + first for part, first in zip(parts, firsts, strict=False)]
    return np.concatenate([positions for positions, _ in parts]), np.concatenate(faces).astype(
        np.int32
    )


def sheet(side: int, height: float = 0.0, size: float = 1.0) -> tuple[Positions, Faces]:
    """Return a flat square sheet of side x side vertices around the origin.

    Args:
        side: Vertices along a side, at least 2.
        height: z [m].
        size: Length of a side [m].
    """
    i, j = np.divmod(np.arange(side * side), side)
    points = np.column_stack((i, j, np.zeros(side * side))) / (side - 1) - (0.5, 0.5, 0.0)
    a = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.concatenate(
        (
            np.column_stack((a, a + side, a + side + 1)),
            np.column_stack((a, a + side + 1, a + 1)),
        )
    )
    return points * size + (0.0, 0.0, height), faces.astype(np.int32)


def ball(rng: np.random.Generator, rounds: int = 0) -> tuple[Positions, Faces]:
    """Return a closed body of radius 1: a tetrahedron, or an octahedron whose faces are divided.

    Args:
        rng: Draws which, and turns it.
        rounds: How often the faces of the octahedron are divided into four.
    """
    if rounds == 0 and rng.random() < 0.5:
        corners = np.array([[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]]) / np.sqrt(3.0)
        return corners @ turn(rng).T, TETRAHEDRON
    points, faces = AXES, OCTAHEDRON
    for _ in range(rounds):
        edges = np.sort(np.concatenate((faces[:, :2], faces[:, 1:], faces[:, ::2])), axis=1)
        unique, place = np.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = place.reshape(3, -1) + len(points)
        middle = points[unique].sum(axis=1)
        points = np.concatenate((points, middle / np.linalg.norm(middle, axis=1, keepdims=True)))
        a, b, c = faces.T
        parts = (a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)
        faces = np.concatenate([np.column_stack(part) for part in parts])
    return points @ turn(rng).T, faces.astype(np.int32)


def turn(rng: np.random.Generator) -> Floats:
    """Draw a rotation, (3, 3) f8."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def turned(positions: Positions, axis: int, degrees: float, centre: Positions) -> Positions:
    """Rotate positions about an axis of coordinates through a centre.

    By 90 and by 180 degrees, the rotation of numbers with few digits is exact.
    """
    a = np.deg2rad(degrees)
    cos, sin = np.round((np.cos(a), np.sin(a)), 15)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    arms, out = positions - centre, positions.copy()
    out[:, j] = centre[j] + cos * arms[:, j] - sin * arms[:, k]
    out[:, k] = centre[k] + sin * arms[:, j] + cos * arms[:, k]
    return out


def power(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a number whose decimal logarithm is uniform between two."""
    return float(10.0 ** rng.uniform(low, high))
