"""Small steps in which sheets go through each other, with coordinates that moving keeps exact.

All coordinates are multiples of LATTICE_M, so turning by angles of the triangle 3-4-5, mirroring,
and moving by multiples of the lattice change them without rounding.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Faces, Flags, Masses, Positions
from validation.scenes.sheets import grid_faces

LATTICE_M = 2.0**-24
THICKNESS_M = 2.0**-10
RIPPLE = 0.01  # of the sheets, over the length of an edge


class Step(NamedTuple):
    """The arrays of a time step.

    Attributes:
        start: (n, 3) f8 [m].
        end: (n, 3) f8 [m], proposed.
        faces: (m, 3) i4.
        masses: (n,) f8 [kg].
        pinned: (n,) b1.
        thickness: [m].
    """

    start: Positions
    end: Positions
    faces: Faces
    masses: Masses
    pinned: Flags
    thickness: float = THICKNESS_M


def crossing_sheets(rng: np.random.Generator, depth: float, n: int = 4) -> Step:
    """Make a rippled sheet that is proposed to end below another one.

    In one step of three, the lower sheet is pinned.

    Args:
        rng: Draws the ripples, the path, the masses and what is pinned.
        depth: How far the upper sheet ends below the lower one, over the length of an edge.
        n: Vertices along a side; a sheet is 1 m wide.

    Returns:
        The step; nothing touches at its start.
    """
    edge = 1.0 / (n - 1)
    gap = max(depth * edge, 8.0 * RIPPLE * edge)  # the ripples never reach so far
    flat = _grid(n)
    low = flat + RIPPLE * edge * rng.uniform(-1.0, 1.0, flat.shape)
    high = flat + RIPPLE * edge * rng.uniform(-1.0, 1.0, flat.shape)
    start = np.concatenate((low, high + (0.11 * edge, 0.17 * edge, gap)))
    end = start.copy()
    end[n * n :, 2] -= gap + depth * edge * rng.uniform(0.6, 1.4, n * n)
    end[: n * n, 2] += 0.2 * depth * edge * rng.random(n * n)
    pinned = np.arange(2 * n * n) < (n * n if rng.random() < 1.0 / 3.0 else 0)
    faces = grid_faces(n)
    masses = rng.uniform(0.5, 1.5, 2 * n * n)
    return Step(
        on_lattice(start), on_lattice(end), np.concatenate((faces, faces + n * n)), masses, pinned
    )


def regular_layers(rng: np.random.Generator, n: int = 4) -> Step:
    """Make equal flat sheets, the uppermost of which falls through all others.

    Masses are equal and nothing is uneven, so many impacts happen at the same time and are equally
    deep.

    Args:
        rng: Draws the number of sheets, their distance and the depth.
        n: Vertices along a side; a sheet is 1 m wide.
    """
    n_layers = int(rng.integers(2, 5))
    gap = 2.0 ** -float(rng.integers(3, 6))
    flat = on_lattice(_grid(n))
    start = np.concatenate([flat + (0.0, 0.0, -gap * k) for k in range(n_layers)])
    end = start.copy()
    end[: n * n, 2] -= on_lattice(gap * rng.uniform(1.0, 2.0 * n_layers))
    faces = np.concatenate([grid_faces(n) + n * n * k for k in range(n_layers)])
    return Step(start, end, faces, np.ones(len(start)), np.zeros(len(start), bool))


def on_lattice(numbers: Positions | float) -> Positions:
    """Round numbers to multiples of LATTICE_M."""
    return np.rint(np.asarray(numbers) / LATTICE_M) * LATTICE_M


def _grid(n: int) -> Positions:
    i, j = np.divmod(np.arange(n * n), n)
    return np.column_stack((i, j, np.zeros(n * n))) / (n - 1)
