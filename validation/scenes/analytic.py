"""Steps whose right end positions follow by hand; all their numbers are multiples of 2^-10."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from izo_ref.base.arrays import Faces, Flags, Masses, Positions

THICKNESS_M = 2.0**-10
HIGH = 8.0  # far parts of a mesh, which meet nothing [m]


class AnalyticStep(NamedTuple):
    """A step and its right end.

    Attributes:
        start: (n, 3) f8 [m].
        end: (n, 3) f8 [m], proposed.
        faces: (m, 3) i4.
        masses: (n,) f8 [kg].
        pinned: (n,) b1.
        thickness: [m].
        right: (n, 3) f8 [m], right end positions.
    """

    start: Positions
    end: Positions
    faces: Faces
    masses: Masses
    pinned: Flags
    thickness: float
    right: Positions


def vertex_on_face(thickness: float = THICKNESS_M, height: float = 0.0) -> AnalyticStep:
    """Return a vertex that falls from 1 m above a pinned face to 1 m below it.

    The right end of the vertex is one thickness above the face, where it fell.

    Args:
        thickness: [m].
        height: Of the face, above the origin [m].
    """
    start = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, 1], [0.25, 0, HIGH], [0, 0.25, HIGH]], float
    )
    return _falling(start, [[0, 1, 2], [3, 4, 5]], (0, 1, 2), (3,), thickness, height)


def edge_on_edge(thickness: float = THICKNESS_M, height: float = 0.0) -> AnalyticStep:
    """Return an edge that falls across a pinned edge; the arguments are those of `vertex_on_face`.

    The two edges cross in their middles, so both ends of the falling one end one thickness above
    the pinned one.
    """
    start = np.array(
        [[-1, 0, 0], [1, 0, 0], [0, 0, -HIGH], [0, -1, 1], [0, 1, 1], [0, 0, HIGH]], float
    )
    return _falling(start, [[0, 1, 2], [3, 4, 5]], (0, 1, 2), (3, 4), thickness, height)


def sheet_on_table(
    thickness: float = THICKNESS_M, height: float = 0.0, side: int = 4
) -> AnalyticStep:
    """Return a flat sheet that falls through a pinned table, onto which it lies down.

    The table is one face. With two, an edge of the sheet that keeps the thickness from the diagonal
    could hold a vertex up, which then needs no thickness of its own.

    Args:
        thickness: [m].
        height: Of the table, above the origin [m].
        side: Number of vertices along a side of the sheet, with 0.25 m between them.
    """
    table = np.array([[-HIGH, -HIGH, 0.0], [3.0 * HIGH, -HIGH, 0.0], [-HIGH, 3.0 * HIGH, 0.0]])
    x, y = np.meshgrid(np.arange(side) / 4.0, np.arange(side) / 4.0, indexing="ij")
    sheet = np.column_stack((x.ravel(), y.ravel(), np.ones(side * side)))
    corner = (side * np.arange(side - 1)[:, None] + np.arange(side - 1)).ravel() + 3
    low = np.column_stack((corner, corner + side, corner + 1))
    high = np.column_stack((corner + side, corner + side + 1, corner + 1))
    faces = np.concatenate(([[0, 1, 2]], low, high))
    start = np.concatenate((table, sheet))
    falling = range(3, 3 + side * side)
    return _falling(start, faces, range(3), falling, thickness, height)


def free_vertex_on_face(
    masses: tuple[float, float, float, float], thickness: float = THICKNESS_M
) -> AnalyticStep:
    """Return `vertex_on_face` with a free face.

    The right end is that of the one impact with its normal at the start: a vertex of weight a and
    mass m moves along z by a / m (1 + d) / sum(a^2 / m).

    Args:
        masses: Of the corners of the face, and of the vertex [kg].
        thickness: d [m].
    """
    step = vertex_on_face(thickness)
    weights, own = np.array([-0.5, -0.25, -0.25, 1.0]), np.array(masses)
    right = step.end.copy()
    right[:4, 2] += weights / own * (1.0 + thickness) / (weights**2 / own).sum()
    everything = np.ones(len(right))
    everything[:4] = own
    return step._replace(masses=everything, pinned=np.zeros(len(right), bool), right=right)


def scaled(step: AnalyticStep, factor: float) -> AnalyticStep:
    """Return a step with all lengths multiplied; each number is rounded once."""
    lengths = {name: getattr(step, name) * factor for name in ("start", "end", "right")}
    return step._replace(thickness=step.thickness * factor, **lengths)


def moved(step: AnalyticStep, by: Positions) -> AnalyticStep:
    """Return a step at another place; each number is rounded once.

    Args:
        step: The step.
        by: (3,) f8 [m].
    """
    return step._replace(start=step.start + by, end=step.end + by, right=step.right + by)


def turned(step: AnalyticStep, axes: tuple[int, int, int]) -> AnalyticStep:
    """Return a step with its axes in another order, as from a program with another vertical."""
    order = list(axes)
    return step._replace(
        start=step.start[:, order], end=step.end[:, order], right=step.right[:, order]
    )


def _falling(
    start: Positions,
    faces: ArrayLike,
    pinned: Iterable[int],
    lands: Iterable[int],
    thickness: float,
    height: float,
) -> AnalyticStep:
    """Return a step in which everything that is not pinned falls by 2 m, and some vertices land.

    Args:
        start: (n, 3) f8 [m], with the pinned part at z = 0.
        faces: (m, 3).
        pinned: The pinned vertices.
        lands: Vertices that end one thickness above z = 0.
        thickness: [m].
        height: Added to every z [m].
    """
    is_pinned = np.zeros(len(start), bool)
    is_pinned[list(pinned)] = True
    end = start.copy()
    end[~is_pinned, 2] -= 2.0
    right = end.copy()
    right[list(lands), 2] = thickness
    up = np.array([0.0, 0.0, height])
    return AnalyticStep(
        start + up, end + up, np.array(faces, np.int32), np.ones(len(start)), is_pinned,
        thickness, right + up,
    )  # fmt: skip
