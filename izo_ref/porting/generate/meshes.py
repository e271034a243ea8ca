"""Small meshes of stage S1: a start without intersections, a proposed end, and faces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random
from typing import NamedTuple

from izo_ref.porting.reference.contact import Point

Face = tuple[int, int, int]

TETRAHEDRON: list[Point] = [(0, 0, 0), (4, 0, 0), (0, 4, 0), (0, 0, 4)]
TETRAHEDRON_FACES: list[Face] = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


class Mesh(NamedTuple):
    """A mesh on its path."""

    start: list[Point]
    end: list[Point]
    faces: list[Face]


def shift(points: Sequence[Point], x: float, y: float, z: float) -> list[Point]:
    """Return points moved by a vector."""
    return [(a + x, b + y, c + z) for a, b, c in points]


def flipped(points: Sequence[Point]) -> list[Point]:
    """Return points reflected at the plane z = 0."""
    return [(x, y, -z) for x, y, z in points]


def part(start: Sequence[Point], faces: Sequence[Face], x: float, y: float, z: float) -> Mesh:
    """Return a part of a mesh that moves by a vector."""
    return Mesh(list(start), shift(start, x, y, z), list(faces))


def joined(*parts: Mesh) -> Mesh:
    """Return one mesh of several parts."""
    start: list[Point] = []
    end: list[Point] = []
    faces: list[Face] = []
    for one in parts:
        n = len(start)
        start += one.start
        end += one.end
        faces += [(a + n, b + n, c + n) for a, b, c in one.faces]
    return Mesh(start, end, faces)


def grid(n: int, height: Callable[[int, int], float]) -> tuple[list[Point], list[Face]]:
    """Return a sheet of n x n vertices at distances of 1, over heights at its vertices."""
    points: list[Point] = [(i, j, height(i, j)) for i in range(n) for j in range(n)]
    faces: list[Face] = []
    for i in range(n - 1):
        for j in range(n - 1):
            a, b, c, d = i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1
            faces += [(a, b, c), (a, c, d)]
    return points, faces


def noise(seed: int, steps: int = 64) -> Callable[..., float]:
    """Return a function that gives multiples of 1 / steps in (-1/2, 1/2)."""
    random = Random(seed)
    return lambda *_: int(random.random() * steps - steps / 2) / steps


def stack(n: int, distance: float) -> Mesh:
    """Return n large faces at rest, one above the other."""
    face: list[Point] = [(-4, -4, 0), (4, -4, 0), (0, 4, 0)]
    layers = [part(shift(face, 0, 0, -distance * k), [(0, 1, 2)], 0, 0, 0) for k in range(n)]
    return joined(*layers)
