"""Two sheets of any size that meet in a hundredth of their vertices."""

import numpy as np

from izo_ref.base.arrays import Faces, Floats, Indices
from izo_ref.scene import Scene

CELL_M = 0.01
APART_M = 0.005  # of the two sheets at the start
MEETING = 0.01  # share of all vertices that are pushed through the other sheet
BUMP_CELLS = 1.8  # radius of the bumps in which these vertices lie, in cells
BUMP_VERTICES = 10  # vertices in one bump, about
KG_PER_M2 = 0.2


def meeting_sheets(rng: np.random.Generator, n_triangles: int) -> Scene:
    """Make two square grids above one another, slightly uneven, without pinned vertices.

    The upper grid has bumps at random places. The vertices in a bump are proposed to end up to 4 mm
    below the lower grid. They are a hundredth of all vertices, whatever the number of triangles.
    The size of the cells does not depend on that number either.

    Args:
        rng: Draws the grids and the bumps.
        n_triangles: Triangles of both grids together; the scene has the nearest number that two
            grids can have.

    Returns:
        The scene.
    """
    n = max(2, round(np.sqrt(n_triangles / 4.0))) + 1
    start, faces = [], []
    for layer in range(2):
        i, j = np.divmod(np.arange(n * n), n)
        points = np.column_stack((i, j, np.full(n * n, 0.0))) * CELL_M
        # the grids are uneven and one is shifted, so that no vertex is above a vertex or an edge
        points += rng.uniform(-0.15, 0.15, points.shape) * (CELL_M, CELL_M, APART_M)
        points += layer * np.array([0.37 * CELL_M, 0.21 * CELL_M, APART_M])
        start.append(points)
        faces.append(layer * n * n + grid_faces(n))
    start = np.concatenate(start)
    end = start.copy()
    centres = rng.uniform(0.0, n - 1.0, (max(1, round(2 * MEETING * n * n / BUMP_VERTICES)), 2))
    vertex, depth = _bumps(centres, n)
    end[n * n + vertex, 2] = 0.001 - 0.005 * depth
    return Scene(start, end, np.concatenate(faces), np.full(len(start), KG_PER_M2 * CELL_M**2))


def _bumps(centres: Floats, n: int) -> tuple[Indices, Floats]:
    """Find the vertices of a grid within the bumps, and how deep in a bump they are.

    Args:
        centres: (k, 2) f8, of the bumps, in cells.
        n: Vertices along a side of the grid.

    Returns:
        (j,) i8, and (j,) f8 from 0 at the rim to 1 at the centre.
    """
    reach = int(np.ceil(BUMP_CELLS))
    steps = np.arange(-reach, reach + 1)
    around = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    near = np.rint(centres)[:, None, :].astype(int) + around
    depth = 1.0 - ((near - centres[:, None, :]) ** 2).sum(axis=2) / BUMP_CELLS**2
    inside = (depth > 0.0) & (near >= 0).all(axis=2) & (near < n).all(axis=2)
    order = np.argsort(depth[inside])  # where bumps overlap, the deeper one is written last
    vertex = (near[inside] @ (n, 1))[order]
    return vertex, depth[inside][order]


def grid_faces(n: int) -> Faces:
    """Return the faces of a grid of n x n vertices; each cell is split along the same diagonal.

    Args:
        n: Vertices along a side.

    Returns:
        (2 (n - 1)^2, 3) i4.
    """
    i, j = np.divmod(np.arange((n - 1) ** 2, dtype=np.int32), n - 1)
    a = i * n + j
    b, c, d = a + n, a + n + 1, a + 1
    return np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
