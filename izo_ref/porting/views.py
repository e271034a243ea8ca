"""Views of points in space, as flat drawings need them: a direction to look along, and a scale."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

Point: TypeAlias = tuple[float, float, float]
Flat: TypeAlias = tuple[float, float]

SIZE, MARGIN = 480.0, 40.0  # of a drawing, and of the empty space around [pixels]
TILT = 0.4  # sine of the angle from which slanted views look down
# Cosine and sine of their turn; no multiple of 45 degrees, since made-up cases are full of
# diagonals, which would then hide each other. Views along an axis would hide what moves along it.
TURN = (0.9, math.sqrt(1.0 - 0.81))


class View(NamedTuple):
    """Turns points of space into points of a square drawing.

    Attributes:
        right: Unit vector that points to the right of the drawing.
        up: Unit vector that points up.
        centre: The point of the drawing's plane that is in the middle.
        scale: Pixels for a unit of length.
    """

    right: Point
    up: Point
    centre: Flat
    scale: float

    def __call__(self, point: Sequence[float]) -> Flat:
        """Return where a point is in the drawing [pixels], from the upper left corner."""
        x = (_dot(self.right, point) - self.centre[0]) * self.scale
        y = (_dot(self.up, point) - self.centre[1]) * self.scale
        return 0.5 * SIZE + x, 0.5 * SIZE - y


def best_view(points: Sequence[Sequence[float]]) -> View:
    """Return the view from above in which points are spread over the largest area.

    Args:
        points: The points that the drawing has to show.
    """
    right, up = max(_directions(), key=lambda pair: _spread(points, *pair))
    x = [_dot(right, point) for point in points]
    y = [_dot(up, point) for point in points]
    centre = (0.5 * (min(x) + max(x)), 0.5 * (min(y) + max(y)))
    extent = max(max(x) - min(x), max(y) - min(y))
    return View(right, up, centre, (SIZE - 2.0 * MARGIN) / extent if extent > 0.0 else 1.0)


def _directions() -> list[tuple[Point, Point]]:
    """Return what points right and up in four views from above, a quarter turn apart."""
    c, s = TURN
    high = math.sqrt(1.0 - TILT * TILT)
    turns = ((c, s), (-s, c), (-c, -s), (s, -c))
    return [((a, b, 0.0), (-b * TILT, a * TILT, high)) for a, b in turns]


def _spread(points: Sequence[Sequence[float]], right: Point, up: Point) -> float:
    """Return the area over which points are spread: the determinant of their covariance."""
    x = [_dot(right, point) for point in points]
    y = [_dot(up, point) for point in points]
    mean_x, mean_y = math.fsum(x) / len(x), math.fsum(y) / len(y)
    xx = math.fsum((a - mean_x) ** 2 for a in x)
    yy = math.fsum((b - mean_y) ** 2 for b in y)
    xy = math.fsum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True))
    return xx * yy - xy * xy


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
