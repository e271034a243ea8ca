"""Many balls that are pressed together: each of them meets several others."""

import numpy as np

from izo_ref.base.arrays import AnyInts, Faces, Floats, Positions
from izo_ref.scene import Scene

RADIUS_M = 0.01  # of the largest ball
BALL_FACES = 320  # of an icosahedron whose faces were split in four, twice
# Distance of neighbouring places at the start, over the radius. Two balls of full radius at their
# places leave 0.2 of it between them.
SPACING = 2.2
# Centres end at this part of their distance from the middle, so that neighbours of full radius
# overlap by 0.8 of it. A step of 20,000 triangles takes 4 s; with 0.76 it takes 0.3 s, and with 0.5
# 11 s.
PRESSED = 0.55
KG_PER_M2 = 0.2


def pressed_balls(rng: np.random.Generator, n_balls: int) -> Scene:
    """Make balls on the places of a cubic lattice, which are proposed to end overlapping.

    Balls differ in radius and in how they are turned. A ball stays within the sphere of full radius
    around its place, and these spheres do not meet, so there is no intersection at the start. Each
    ball moves toward the middle of all, turns a little, and moves a little by chance, without
    changing its shape.

    Args:
        rng: Draws places, radii, turns and motion.
        n_balls: Number of balls, at least 1; each has BALL_FACES triangles.

    Returns:
        The scene, without pinned vertices; masses [kg] are those of shells of KG_PER_M2.
    """
    unit, faces = _ball()
    side = int(np.ceil(np.cbrt(n_balls) - 1e-9))
    places = np.stack(np.unravel_index(np.arange(side**3), (side,) * 3), axis=1)
    # the places that are left empty are at random
    places = places[np.sort(rng.permutation(side**3)[:n_balls])] - 0.5 * (side - 1)
    places = SPACING * RADIUS_M * places
    start, end, masses = [], [], []
    for place in places:
        radius = RADIUS_M * rng.uniform(0.85, 1.0)
        ball = radius * unit @ _turn(rng, np.pi)
        away = rng.uniform(-1.0, 1.0, 3)
        # the ball stays within the sphere of full radius around its place
        centre = place + (RADIUS_M - radius) * away / max(1.0, float(np.linalg.norm(away)))
        start.append(centre + ball)
        moved = PRESSED * place + 0.1 * RADIUS_M * rng.uniform(-1.0, 1.0, 3)
        end.append(moved + ball @ _turn(rng, 0.2))
        masses.append(np.full(len(ball), KG_PER_M2 * 4.0 * np.pi * radius**2 / len(ball)))
    numbers = len(unit) * np.arange(n_balls, dtype=np.int32)[:, None, None]
    all_faces = (numbers + faces).reshape(-1, 3)
    return Scene(np.concatenate(start), np.concatenate(end), all_faces, np.concatenate(masses))


def _ball() -> tuple[Positions, Faces]:
    """Return vertices on the unit sphere, and BALL_FACES faces that point outward."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    pairs = [(a, b) for a in (-1.0, 1.0) for b in (-golden, golden)]
    corners = np.array([p for a, b in pairs for p in ((0.0, a, b), (a, b, 0.0), (b, 0.0, a))])
    apart = np.linalg.norm(corners[:, None] - corners, axis=2)
    near = (apart > 0.0) & (apart < 2.1)  # the edges have length 2
    faces = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if near[a, b] and near[b, c] and near[a, c]:
                    outward = np.linalg.det(corners[[a, b, c]]) > 0.0
                    faces.append((a, b, c) if outward else (a, c, b))
    points, split = corners, np.array(faces)
    for _ in range(2):
        points, split = _split(points, split)
    return points / np.linalg.norm(points, axis=1, keepdims=True), split.astype(np.int32)


def _split(points: Positions, faces: AnyInts) -> tuple[Positions, AnyInts]:
    """Split each face in four, at the middles of its edges."""
    a, b, c = faces.T
    edges = np.sort(np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]])), axis=1)
    unique, index = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = (len(points) + index.reshape(3, -1)).reshape(3, -1)
    middles = points[unique].mean(axis=1)
    parts = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
    return np.concatenate((points, middles)), np.concatenate([np.column_stack(p) for p in parts])


def _turn(rng: np.random.Generator, most: float) -> Floats:
    """Draw a rotation matrix (3, 3) about any axis, by up to an angle [rad]."""
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    angle = rng.uniform(-most, most)
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
