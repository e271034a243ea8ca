"""Animations that cross themselves in known frames."""

import numpy as np

from tests.helpers.shapes import grid

# Heights of the tip of a spike over a plate: through it in frames 3 to 7.
HEIGHTS = (0.9, 0.5, 0.1, -0.05, -0.2, -0.3, -0.2, -0.05, 0.2, 0.6)


def dipping_spike(heights=HEIGHTS):
    """Return frames in which a spike dips through a plate, faces and parts.

    The plate has 4 large faces about its centre, part 0. The spike is a tetrahedron without its
    upper face, part 1. Its three edges go through the plate if its tip is below it.

    Args:
        heights: Height of the tip over the plate in each frame [m].
    """
    plate = [(-4.0, -4.0, 0.0), (4.0, -4.0, 0.0), (4.0, 4.0, 0.0), (-4.0, 4.0, 0.0)]
    plate += [(0.0, 0.0, 0.0)]
    faces = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    # All of the spike is over the face 0 1 4, whose middle is at (0, -4 / 3).
    tip = np.array((0.0, -1.5, 0.0))
    rim = np.array([(0.3, -1.6, 1.0), (-0.3, -1.6, 1.0), (0.0, -1.2, 1.0)])
    faces += [(5, 6, 7), (5, 7, 8), (5, 8, 6)]
    frames = [
        np.concatenate((plate, [tip + (0.0, 0.0, height)], rim + (0.0, 0.0, height)))
        for height in heights
    ]
    return frames, np.array(faces), np.repeat([0, 1], [5, 4])


def passing_sheets(heights, n=5, jitter=None):
    """Return frames in which a sheet is at some heights over another one, faces, and parts.

    Args:
        heights: Height of the upper sheet in each frame [m].
        n: Vertices along a side.
        jitter: (2 n^2, 3) added to the positions [m], or None.
    """
    low, faces = grid(n)
    high, _ = grid(n, size=0.9)
    high[:, :2] += (0.033, 0.047)
    both = np.concatenate((low, high)) + (0.0 if jitter is None else jitter)
    rise = np.zeros((2 * n * n, 3))
    rise[n * n :, 2] = 1.0
    frames = [both + height * rise for height in heights]
    return frames, np.concatenate((faces, faces + n * n)), np.repeat([0, 1], n * n)


def tangle(rng, n_faces):
    """Return positions and faces of triangles that share no vertex and cross each other at random.

    Args:
        rng: Draws the corners.
        n_faces: Number of triangles.
    """
    centres = rng.normal(size=(n_faces, 1, 3))
    positions = (centres + rng.normal(size=(n_faces, 3, 3))).reshape(-1, 3)
    return positions, np.arange(3 * n_faces).reshape(-1, 3)
