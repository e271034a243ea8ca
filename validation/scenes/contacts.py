"""Small scenes of a few triangles in contact; their zones are small enough for SLSQP."""

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.scene import Scene

KINDS = ("vertex on face", "edge on edge", "tetrahedron on face", "tetrahedra")
LOW = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.3], [0.5, 4.0, -0.2]]  # a slanted face


def contact_scene(rng: np.random.Generator, kind: str) -> Scene:
    """Make a scene in which one body falls onto another and through it, and turns a little.

    Args:
        rng: Draws shapes, masses and motion.
        kind: One of KINDS.

    Returns:
        A scene without pinned vertices.
    """
    if kind == "vertex on face":
        low, high = np.array(LOW), _tip(rng)
        faces = [[0, 1, 2], [3, 4, 5]]
    elif kind == "edge on edge":
        low = np.array([[-2.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.0, 0.3, -3.0]])
        high = np.array([[0.1, -2.0, 0.6], [-0.1, 2.0, 0.7], [0.2, 0.1, 4.0]])
        faces = [[0, 1, 2], [3, 4, 5]]
    elif kind == "tetrahedron on face":
        low, high = np.array(LOW), _tetrahedron(rng) + (1.3, 1.2, 0.9)
        faces = [[0, 1, 2], *(3 + TETRAHEDRON).tolist()]
    else:
        low, high = _tetrahedron(rng), _tetrahedron(rng) + (0.15, 0.1, 1.6)
        faces = [*TETRAHEDRON.tolist(), *(4 + TETRAHEDRON).tolist()]
    start = np.concatenate((low, high))
    end = start + 0.1 * rng.normal(size=start.shape)
    end[len(low) :, 2] -= rng.uniform(1.2, 1.6)
    return Scene(start, end, np.array(faces), 10.0 ** rng.uniform(-1, 1, len(start)))


TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def _tip(rng: np.random.Generator) -> Positions:
    """Make the corners of a triangle that stands on one corner."""
    return np.array([[1.2, 1.1, 0.5], [0.2, 1.3, 4.0], [2.0, 0.9, 4.2]]) + 0.1 * rng.normal(
        size=(3, 3)
    )


def _tetrahedron(rng: np.random.Generator) -> Positions:
    corners = np.array([[1.0, 0, -0.5], [-0.5, 0.87, -0.5], [-0.5, -0.87, -0.5], [0, 0, 1.0]])
    return 0.6 * (corners + 0.1 * rng.normal(size=(4, 3)))
