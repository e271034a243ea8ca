"""Small scenes whose parts touch or cross at the start, at coordinates that are small fractions."""

from itertools import permutations

import numpy as np

# Parts at the origin: the origin is a corner, on an edge, or inside a face of each.
PARTS = {
    "triangle": ([[0, 0, 0], [2, 0, 0], [0, 2, 0]], [[0, 1, 2]]),
    "face above": ([[-2, -2, 0], [2, -2, 0], [0, 2, 0]], [[0, 1, 2]]),
    "tip": (
        [[0, 0, 0], [1, 0, 2], [0, 1, 2], [-1, 0, 2], [0, -1, 2]],
        [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
    ),
    "ridge": ([[-2, 0, 0], [2, 0, 0], [0, 2, 1], [0, -2, 1]], [[0, 1, 2], [0, 1, 3]]),
    "flat pair": ([[-2, 0, 0], [2, 0, 0], [0, 2, 0], [0, -2, 0]], [[0, 1, 2], [0, 1, 3]]),
    "blade": ([[-1, 0, 0], [1, 0, 0], [0, 0, 2]], [[0, 1, 2]]),
    "needle": ([[0, 0, 1], [0, 0, -1], [1, 1, 3]], [[0, 1, 2]]),
    "fan": (
        [[0, 0, 0], [2, 0, 0], [0, 2, 0], [-2, 0, 0], [0, -2, 0]],
        [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
    ),
}
TURNS = [
    np.eye(3)[list(order)] * signs
    for order in permutations(range(3))
    for signs in ((1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1), (-1, -1, -1))
]


def random_scene(rng):
    """Return start, end, faces and pinned of a few parts that touch or cross at the origin."""
    starts, ends, faces, pinned = [], [], [], []
    n = 0
    for _ in range(int(rng.integers(2, 4))):
        points, own = PARTS[rng.choice(list(PARTS))]
        turn = TURNS[rng.integers(len(TURNS))] if rng.random() < 0.7 else np.eye(3)
        points = np.array(points, float) @ turn.T
        points += rng.integers(-1, 2, 3) * rng.choice([0.0, 0.5, 1.0])
        move = rng.integers(-2, 3, 3) / 4 * (rng.random() < 0.8)
        noise = rng.integers(-2, 3, points.shape) / 8 * (rng.random() < 0.5)
        starts.append(points)
        ends.append(points + move + noise)
        faces.append(np.array(own) + n)
        pinned.append(np.full(len(points), rng.random() < 0.25))
        n += len(points)
    parts = starts, ends, faces, pinned
    start, end, faces, pinned = (np.concatenate(part) for part in parts)
    return start, end, faces, pinned
