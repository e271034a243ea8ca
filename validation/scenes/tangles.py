"""Starts that are tangled: cloth that goes through cloth, as published scenes have it.

All sheets are slightly uneven, so that no vertex is in a face and no edge meets an edge. Nothing
moves: each is one set of positions, from which an animation that stands still can be made.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Faces, Flags, Masses, Positions
from validation.scenes.sheets import grid_faces

KG_PER_M2 = 0.2
UNEVEN_CELLS = 0.1  # each coordinate is drawn within this part of a cell
SHELL_RADIUS_M, SHELL_HEIGHT_M = 0.15, 0.3
SHELL_GAP_CELLS = 0.5  # distance of neighbouring shells
WAVE_CELLS = 0.6  # height of the waves of a shell, which make neighbours cross
WAVES = 5  # around a shell


class Tangle(NamedTuple):
    """A mesh that goes through itself.

    Attributes:
        positions_t0: (n, 3) f8 [m].
        faces: (m, 3) i4.
        masses: (n,) f8 [kg].
        pinned: (n,) b1.
    """

    positions_t0: Positions
    faces: Faces
    masses: Masses
    pinned: Flags


def crossed_corner(n: int = 17, depth_cells: float = 3.3, seed: int = 22) -> Tangle:
    """Make a level sheet with a pinned rim, and an upright one whose corner pokes through it.

    The contour is open: it begins and ends on the two sides of the corner.

    Args:
        n: Vertices along a side of the level sheet, which is 1 m wide.
        depth_cells: How deep the corner is below the level sheet, in cells.
        seed: Seed of what is uneven.
    """
    rng = np.random.default_rng(seed)
    cell = 1.0 / (n - 1)
    level = _sheet(rng, n, cell)
    upright = _sheet(rng, n // 2 + 1, cell)
    across, up = upright[:, 0], upright[:, 1]
    # the square stands on its corner, in a vertical plane through the middle of the level sheet
    turned = np.column_stack(
        (
            0.5 + np.sqrt(0.5) * (across - up),
            np.full(len(upright), 0.5 + 0.03 * cell) + upright[:, 2],
            np.sqrt(0.5) * (across + up) - depth_cells * cell,
        )
    )
    return _joined(level, turned, cell)


def crossed_sheets(n: int = 17, depth_cells: float = 2.4, seed: int = 22) -> Tangle:
    """Make a level sheet with a pinned rim, and a narrower upright one whose edge is below it.

    The contour is open: it begins and ends on the two upright sides of the second sheet.

    Args:
        n: Vertices along a side of the level sheet, which is 1 m wide.
        depth_cells: How deep the lower edge of the upright sheet is below the level one, in cells.
        seed: Seed of what is uneven.
    """
    rng = np.random.default_rng(seed)
    cell = 1.0 / (n - 1)
    level = _sheet(rng, n, cell)
    width = n // 2 + 1
    flat = _sheet(rng, width, cell)
    upright = np.column_stack(
        (
            0.5 + flat[:, 0] - 0.5 * (width - 1) * cell,
            0.5 + 0.03 * cell + flat[:, 2],
            flat[:, 1] - depth_cells * cell,
        )
    )
    return _joined(level, upright, cell)


def layered_shells(n_around: int = 40, n_shells: int = 3, seed: int = 22) -> Tangle:
    """Make open tubes around one another, as layers of a garment, whose waves go through them.

    The waves of neighbours are out of step, so that most contours are closed. The upper rim of each
    shell is pinned, and no two rims cross.

    Args:
        n_around: Cells around a shell.
        n_shells: Number of shells.
        seed: Seed of the waves and of what is uneven.
    """
    rng = np.random.default_rng(seed)
    cell = 2.0 * np.pi * SHELL_RADIUS_M / n_around
    n_rings = max(4, round(SHELL_HEIGHT_M / cell) + 1)
    ring, i = np.divmod(np.arange(n_around * n_rings), n_around)
    points, faces, pinned = [], [], []
    for shell in range(n_shells):
        uneven = UNEVEN_CELLS * rng.uniform(-1.0, 1.0, (3, len(ring)))
        angle = 2.0 * np.pi * (i + 0.37 * shell + uneven[0]) / n_around
        height = cell * (ring + 0.21 * shell + uneven[1])
        share = height / SHELL_HEIGHT_M
        wave = np.cos(WAVES * angle + 2.4 * shell) * np.sin(2.0 * np.pi * share)
        fade = np.clip(2.0 - 2.0 * share, 0.0, 1.0)  # the rims are apart
        radius = SHELL_RADIUS_M + cell * (
            SHELL_GAP_CELLS * shell + WAVE_CELLS * fade * wave + 0.2 * uneven[2]
        )
        points.append(np.column_stack((radius * np.cos(angle), radius * np.sin(angle), height)))
        faces.append(shell * len(ring) + _tube_faces(n_around, n_rings))
        pinned.append(ring == n_rings - 1)
    positions = np.concatenate(points)
    masses = np.full(len(positions), KG_PER_M2 * cell**2)
    return Tangle(positions, np.concatenate(faces), masses, np.concatenate(pinned))


def _sheet(rng: np.random.Generator, n: int, cell: float) -> Positions:
    """Return the vertices of a flat sheet of n x n vertices, slightly uneven."""
    i, j = np.divmod(np.arange(n * n), n)
    flat = np.column_stack((i, j, np.zeros(n * n)))
    uneven = UNEVEN_CELLS * rng.uniform(-1.0, 1.0, flat.shape)
    return np.asarray(cell * (flat + uneven * (1.0, 1.0, 0.5)), np.float64)


def _joined(level: Positions, other: Positions, cell: float) -> Tangle:
    """Return two sheets as one mesh, in which the rim of the first one is pinned."""
    n, m = (round(np.sqrt(len(sheet))) for sheet in (level, other))
    i, j = np.divmod(np.arange(n * n), n)
    pinned = np.zeros(n * n + m * m, bool)
    pinned[: n * n] = (np.minimum(i, j) == 0) | (np.maximum(i, j) == n - 1)
    positions = np.concatenate((level, other))
    faces = np.concatenate((grid_faces(n), n * n + grid_faces(m))).astype(np.int32)
    return Tangle(positions, faces, np.full(len(positions), KG_PER_M2 * cell**2), pinned)


def _tube_faces(n_around: int, n_rings: int) -> Faces:
    """Return the faces of a tube of rings of vertices; each cell is split along one diagonal."""
    ring, i = np.divmod(np.arange(n_around * (n_rings - 1), dtype=np.int32), n_around)
    a, b = ring * n_around + i, ring * n_around + (i + 1) % n_around
    c, d = b + n_around, a + n_around
    return np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
