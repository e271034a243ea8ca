"""A garment of several layers on a body; the layers are pressed through one another."""

import numpy as np

from izo_ref.base.arrays import Faces, Floats, Positions
from izo_ref.scene import Scene

RADIUS_M, HALF_HEIGHT_M = 0.15, 0.3  # half axes of the body
COVERED = 0.7  # part of the body's height that the layers cover
WRINKLE_M = 0.003  # height of the wrinkles
WRINKLES = 6  # around the body
# Distance of neighbouring layers: this part of a cell, and this much. A triangle is flat, so it is
# up to a fifteenth of a cell of 5,000 triangles away from the surface that its layer follows.
GAP_CELLS, GAP_M = 0.16, 0.0005
# Standard deviation of the motion, in gaps. A step of 20,000 triangles takes 7 s with 0.7, 16 s
# with 1.2, and 27 s with 2.
PUSH_GAPS = 1.0
KG_PER_M2 = 0.2


def garment(rng: np.random.Generator, n_triangles: int, n_layers: int = 5) -> Scene:
    """Make layers of cloth around a pinned body, and a motion that presses them together.

    The body is an ellipsoid. Each layer is an open tube around it, with the same wrinkles as the
    layer below, farther out by a gap and with a mesh of its own. The gap is more than twice what
    a mesh is away from its surface, so there is no intersection at the start. All layers are
    proposed to end where the wrinkles touch the body, moved besides by a smooth random field of
    their own. So about half of each layer ends inside the layer below.

    Args:
        rng: Draws wrinkles, meshes and motion.
        n_triangles: Triangles of the body and all layers; the scene has about that number.
        n_layers: Number of layers, at least 1.

    Returns:
        The scene. The vertices of the body are pinned; masses [kg] are those of KG_PER_M2.
    """
    tube_m = 2.0 * COVERED * HALF_HEIGHT_M
    # cells are as long as they are wide, and all meshes have the same number of them
    rows_a_column = tube_m / (2.0 * np.pi * RADIUS_M)
    n_around = max(8, round(np.sqrt(0.5 * n_triangles / ((n_layers + 1) * rows_a_column))))
    n_along = max(3, round(0.5 * n_triangles / ((n_layers + 1) * n_around)))
    cell = 2.0 * np.pi * RADIUS_M / n_around
    gap = GAP_CELLS * cell + GAP_M
    body, body_faces = ellipsoid(n_around, n_along)
    start, end, faces = [body], [body], [body_faces]
    wrinkles = rng.uniform(0.0, 2.0 * np.pi, 3)
    n = len(body)
    for layer in range(1, n_layers + 1):
        angle, height = uneven_grid(rng, n_around, n_along + 1)
        radius = ellipsoid_radius(height) + wrinkle(wrinkles, angle, height) + layer * gap
        push = PUSH_GAPS * gap * smooth_field(rng, angle, height) - layer * gap
        start.append(around_axis(angle, radius, height))
        shear = 0.5 * gap * smooth_field(rng, angle, height)
        end.append(around_axis(angle + shear / RADIUS_M, radius + push, height + shear))
        faces.append(n + tube_faces(n_around, n_along + 1))
        n += len(angle)
    pinned = np.arange(n) < len(body)
    masses = np.full(n, KG_PER_M2 * cell**2)
    return Scene(np.concatenate(start), np.concatenate(end), np.concatenate(faces), masses, pinned)


def ellipsoid(n_around: int, n_along: int) -> tuple[Positions, Faces]:
    """Return a closed ellipsoid of n_along rings of vertices and two poles."""
    along = np.linspace(np.pi, 0.0, n_along + 2)[1:-1]
    angle = np.tile(2.0 * np.pi * np.arange(n_around) / n_around, n_along)
    height = HALF_HEIGHT_M * np.repeat(np.cos(along), n_around)
    poles = np.array([[0.0, 0.0, -HALF_HEIGHT_M], [0.0, 0.0, HALF_HEIGHT_M]])
    points = np.concatenate((around_axis(angle, ellipsoid_radius(height), height), poles))
    i = np.arange(n_around)
    j, top, pole = (i + 1) % n_around, n_around * (n_along - 1), n_around * n_along
    low = np.column_stack((j, i, np.full(n_around, pole)))
    high = np.column_stack((top + i, top + j, np.full(n_around, pole + 1)))
    return points, np.concatenate((tube_faces(n_around, n_along), low, high)).astype(np.int32)


def tube_faces(n_around: int, n_rings: int) -> Faces:
    """Return the faces of a tube of rings of vertices; each cell is split along one diagonal."""
    ring, i = np.divmod(np.arange(n_around * (n_rings - 1), dtype=np.int32), n_around)
    a, b = ring * n_around + i, ring * n_around + (i + 1) % n_around
    c, d = b + n_around, a + n_around
    return np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))


def uneven_grid(rng: np.random.Generator, n_around: int, n_rings: int) -> tuple[Floats, Floats]:
    """Draw the angles [rad] and heights [m] of the vertices of a tube, slightly uneven."""
    ring, i = np.divmod(np.arange(n_around * n_rings), n_around)
    uneven = rng.uniform(-0.15, 0.15, (2, len(ring)))
    angle = 2.0 * np.pi * (i + rng.uniform() + uneven[0]) / n_around
    height = COVERED * HALF_HEIGHT_M * (2.0 * (ring + uneven[1]) / (n_rings - 1) - 1.0)
    return angle, height


def ellipsoid_radius(height: Floats) -> Floats:
    """Return the radius of the ellipsoid at some heights [m]."""
    return RADIUS_M * np.sqrt(1.0 - (height / HALF_HEIGHT_M) ** 2)


def wrinkle(phases: Floats, angle: Floats, height: Floats) -> Floats:
    """Return how far wrinkles stand out from the body [m], never less than 0."""
    bend = 0.5 * np.sin(10.0 * height + phases[0])  # wrinkles are not straight
    across = np.cos(WRINKLES * angle + 4.0 * bend + phases[1])
    return 0.5 * WRINKLE_M * (1.0 + across * np.cos(8.0 * height + phases[2]))


def smooth_field(rng: np.random.Generator, angle: Floats, height: Floats) -> Floats:
    """Draw a smooth field with a standard deviation of about 1."""
    waves = 8
    around = rng.integers(-7, 8, waves)
    along = rng.uniform(-40.0, 40.0, waves)
    phases = np.multiply.outer(angle, around) + np.multiply.outer(height, along)
    phases += rng.uniform(0.0, 2.0 * np.pi, waves)
    return np.sqrt(2.0 / waves) * np.cos(phases).sum(axis=1)


def around_axis(angle: Floats, radius: Floats, height: Floats) -> Positions:
    """Return positions (n, 3) [m] from cylindrical coordinates."""
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle), height))
