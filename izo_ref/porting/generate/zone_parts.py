"""Builds zones vertex by vertex and impact by impact, for the vectors of stage S11."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from typing import Any

from izo_ref.porting.reference.rounded import CONTEXT

Triple = tuple[float, float, float]
UP: Triple = (0.0, 0.0, 1.0)
MIDDLES = (0.5, 0.5, -0.5, -0.5)
FACE = (1.0, -0.5, -0.25, -0.25)


def unit(x: float, y: float, z: float) -> Triple:
    """Return a vector of length 1, rounded to float64."""
    length = CONTEXT.sqrt(Decimal(x) ** 2 + Decimal(y) ** 2 + Decimal(z) ** 2)
    a, b, c = (float(CONTEXT.divide(Decimal(value), length)) for value in (x, y, z))
    return a, b, c


class ZoneParts:
    """A zone that grows.

    Attributes:
        thickness: The thickness [m].
    """

    def __init__(self, thickness: float = 2.0**-6) -> None:
        """Begin with no vertices and no impacts."""
        self.thickness = thickness
        self._vertices: list[tuple[Sequence[float], float, int]] = []
        self._impacts: list[tuple[Sequence[int], Sequence[float], Triple]] = []

    def vertex(self, place: Sequence[float], mass: float = 1.0, pinned: int = 0) -> int:
        """Add a vertex at its proposed position, and return its number."""
        self._vertices.append((place, mass, pinned))
        return len(self._vertices) - 1

    def plate(self, place: Sequence[float], mass: float = 0.0) -> list[int]:
        """Add a pinned face whose corners are at and near a place, and return its corners."""
        x, y, z = place
        return [self.vertex((x + a, y + b, z), mass, 1) for a, b in ((0, 0), (1, 0), (0, 1))]

    def impact(
        self, nodes: Sequence[int], weights: Sequence[float] = FACE, normal: Triple = UP
    ) -> None:
        """Add an impact."""
        self._impacts.append((nodes, weights, normal))

    def wall(self, vertex: int, at: Sequence[float], normal: Triple) -> None:
        """Keep a vertex on one side of a pinned vertex."""
        corner = self.vertex(at, 0.0, 1)
        others = [self.vertex(at, 0.0, 1) for _ in range(2)]
        self.impact([vertex, corner, *others], (1.0, -1.0, 0.0, 0.0), normal)

    def inputs(self) -> dict[str, Any]:
        """Return the inputs of stage S11."""
        return {
            "nodes": [v for nodes, _, _ in self._impacts for v in nodes],
            "weights": [float(w) for _, weights, _ in self._impacts for w in weights],
            "normals": [float(c) for _, _, normal in self._impacts for c in normal],
            "proposed": [float(c) for place, _, _ in self._vertices for c in place],
            "masses": [float(mass) for _, mass, _ in self._vertices],
            "pinned": [pinned for _, _, pinned in self._vertices],
            "thickness": float(self.thickness),
        }


def stack(
    masses: Sequence[float],
    drop: float = 0.125,
    floor: bool = True,
    thickness: float = 2.0**-6,
    normal: Triple = UP,
) -> ZoneParts:
    """Return edges that lie across each other; each is proposed below the one under it.

    Args:
        masses: Mass of both ends of each edge, from the lowest one on [kg].
        drop: How far each edge is proposed below the one under it [m].
        floor: Whether a pinned edge lies below all others.
        thickness: The thickness [m].
        normal: Direction of the stack.
    """
    parts, below = ZoneParts(thickness), list[int]()
    for k, mass in enumerate([0.0, *masses] if floor else masses):
        across = (1.0, 0.0) if k % 2 else (0.0, 1.0)
        ends = [(s * across[0], s * across[1], -drop * k) for s in (-1.0, 1.0)]
        own = [parts.vertex(end, mass, int(floor and k == 0)) for end in ends]
        if below:
            parts.impact([*own, *below], MIDDLES, normal)
        below = own
    return parts
