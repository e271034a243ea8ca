"""Builds small scenes part by part, for the vectors of stages S12 and S13."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random
from typing import Any

from izo_ref.porting.generate.random_numbers import dyadic

Place = Sequence[float]


class SceneParts:
    """A scene that grows.

    Attributes:
        thickness: The thickness [m].
        start: Start of each vertex [m].
        end: Proposed end of each vertex [m].
        faces: Vertices of each face.
        masses: Mass of each vertex [kg].
        pinned: For each vertex, 1 if it is pinned.
    """

    def __init__(self, thickness: float = 2.0**-7) -> None:
        """Begin with no vertices and no faces."""
        self.thickness = thickness
        self.start: list[Place] = []
        self.end: list[Place] = []
        self.faces: list[Sequence[int]] = []
        self.masses: list[float] = []
        self.pinned: list[int] = []

    def add(
        self,
        places: Sequence[Place],
        faces: Sequence[Sequence[int]],
        move: Place | Callable[[int, Place], Place] = (0.0, 0.0, 0.0),
        mass: float = 1.0,
        pinned: int = 0,
    ) -> list[int]:
        """Add a piece of mesh.

        Args:
            places: Start of each vertex [m].
            faces: Faces, by the numbers of these vertices.
            move: How all vertices move, or a function of the number and the place of one [m].
            mass: Mass of each vertex [kg].
            pinned: Whether the vertices are pinned.

        Returns:
            The numbers of the vertices.
        """
        first = len(self.start)
        for k, place in enumerate(places):
            own = move(k, place) if callable(move) else move
            self.start.append(tuple(place))
            self.end.append(tuple(c + m for c, m in zip(place, own, strict=True)))
            self.masses.append(mass)
            self.pinned.append(pinned)
        self.faces += [[first + v for v in face] for face in faces]
        return list(range(first, len(self.start)))

    def inputs(self) -> dict[str, Any]:
        """Return the inputs of stages S12 and S13."""
        return {
            "positions_t0": [float(c) for place in self.start for c in place],
            "positions_t1": [float(c) for place in self.end for c in place],
            "faces": [v for face in self.faces for v in face],
            "masses": [float(mass) for mass in self.masses],
            "pinned": list(self.pinned),
            "thickness": float(self.thickness),
        }


def sheet(
    side: int, z: float, size: float = 1.0, at: Place = (0.0, 0.0), ripple: Random | None = None
) -> tuple[list[Place], list[list[int]]]:
    """Return places and faces of a square sheet of side x side vertices.

    Args:
        side: Vertices along a side; size / (side - 1) should have few bits.
        z: Height [m].
        size: Length of a side [m].
        at: x and y of the first corner [m].
        ripple: Moves each vertex a little up or down, if given.
    """
    step = size / (side - 1)
    places: list[Place] = []
    for i in range(side):
        for j in range(side):
            bump = dyadic(ripple, -1.0, 1.0) / 64.0 if ripple else 0.0
            places.append((at[0] + i * step, at[1] + j * step, z + bump))
    faces: list[list[int]] = []
    for i in range(side - 1):
        for j in range(side - 1):
            a, b = i * side + j, (i + 1) * side + j
            faces += [[a, b, b + 1], [a, b + 1, a + 1]]
    return places, faces


def hanging_triangle(tip: Place, width: float = 0.125, height: float = 2.0) -> list[Place]:
    """Return a narrow triangle that stands on its tip."""
    x, y, z = tip
    return [tip, (x - width, y, z + height), (x + width, y, z + height)]


def fan(
    tip: Place, rim: int, radius: float, height: float
) -> tuple[Sequence[Place], list[list[int]]]:
    """Return a cone that stands on its tip; its rim is a square with vertices along its sides.

    Args:
        tip: The tip [m].
        rim: Vertices of the rim, a multiple of 8.
        radius: Half a side of the square [m].
        height: Height of the rim above the tip [m].
    """
    x, y, z = tip
    quarter, places = rim // 4, list[Place]([tip])
    corners = [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
    for k in range(rim):
        (ax, ay), (bx, by) = corners[k // quarter], corners[(k // quarter + 1) % 4]
        part = (k % quarter) / quarter
        u, v = ax + part * (bx - ax), ay + part * (by - ay)
        places.append((x + radius * u, y + radius * v, z + height))
    return places, [[0, 1 + k, 1 + (k + 1) % rim] for k in range(rim)]
