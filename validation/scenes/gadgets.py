"""Two elements that meet in one place, with the answer worked out by hand.

One impact moves its vertices by w_i r / sum w^2 along its normal, where w are the weights of the
contact, r is what the gap lacks to the thickness at the proposed positions, and all masses are
equal (docs/method section 5). Coordinates are small whole numbers and powers of two where they can
be, so that gaps far below rounding can be asked for: contacts lie in the plane z = 0.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from izo_ref.base.arrays import Faces, Flags, Positions

THICKNESS_M = 2.0**-10


class Gadget(NamedTuple):
    """A step and its right answer.

    Attributes:
        start: (n, 3) f8 [m].
        end: (n, 3) f8 [m], proposed.
        faces: (m, 3) i4.
        best: (n, 3) f8 [m], the right end positions.
        pinned: (n,) b1, or None.
    """

    start: Positions
    end: Positions
    faces: Faces
    best: Positions
    pinned: Flags | None = None


def vertex_on_face(
    corners: ArrayLike, start_gap: float = 1.0, end_gap: float = -0.5, shift: ArrayLike = (0, 0, 0)
) -> Gadget:
    """Move a vertex in no face along z above the centre of a face.

    Args:
        corners: (3, 3) [m], of a face in the plane z = 0 whose centre is the origin.
        start_gap: Height of the vertex at the start [m].
        end_gap: Proposed height at the end [m]; if it is 0 or negative, the vertex goes through.
        shift: By which the whole scene moves during the step [m].
    """
    face = np.asarray(corners, np.float64)
    start = np.concatenate((face, [[0.0, 0.0, start_gap]]))
    end = np.concatenate((face, [[0.0, 0.0, end_gap]])) + np.asarray(shift, np.float64)
    best = end.copy()
    if end_gap <= 0.0:
        lacking = THICKNESS_M - end_gap
        best[:, 2] += np.array([-1.0, -1.0, -1.0, 3.0]) / 4.0 * lacking
    return Gadget(start, end, np.array([[0, 1, 2]]), best)


def edge_on_edge(
    length: float = 2.0, turn: float = 0.5 * np.pi, start_gap: float = 1.0, end_gap: float = -0.5
) -> Gadget:
    """Move the lower edge of an upright triangle onto the upper edge of another one.

    Args:
        length: Of the edge that falls [m]; the other one is 2 m long. They meet at their middles.
        turn: Angle between the edges [rad].
        start_gap: Height of the falling edge above the other one at the start [m].
        end_gap: Proposed height at the end [m], 0 or negative.
    """
    low = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -4.0]])
    # exactly along the axes where the angle is 0 or a right one
    along = {0.0: (1.0, 0.0), 0.5 * np.pi: (0.0, 1.0)}.get(turn, (np.cos(turn), np.sin(turn)))
    half = 0.5 * length * np.array([*along, 0.0])
    high = np.array([-half, half, (0.0, 0.0, 4.0)])
    start = np.concatenate((low, high + (0.0, 0.0, start_gap)))
    end = np.concatenate((low, high + (0.0, 0.0, end_gap)))
    best = end.copy()
    best[[0, 1], 2] -= 0.5 * (THICKNESS_M - end_gap)
    best[[3, 4], 2] += 0.5 * (THICKNESS_M - end_gap)
    return Gadget(start, end, np.array([[0, 1, 2], [3, 4, 5]]), best)


def vertex_on_edge(start_gap: float, end_gap: float) -> Gadget:
    """Move the tip of a triangle towards the edge of another one, all in the plane z = 0.

    Args:
        start_gap: Distance of the tip from the edge at the start [m].
        end_gap: Proposed distance at the end [m]; if it is 0 or negative, the tip goes through.
    """
    low = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -4.0, 0.0]])
    high = np.array([[0.0, 0.0, 0.0], [1.0, 4.0, 0.0], [-1.0, 4.0, 0.0]])
    start = np.concatenate((low, high + (0.0, start_gap, 0.0)))
    end = np.concatenate((low, high + (0.0, end_gap, 0.0)))
    best = end.copy()
    if end_gap <= 0.0:
        lacking = THICKNESS_M - end_gap
        best[[0, 1], 1] -= lacking / 3.0
        best[3, 1] += lacking * 2.0 / 3.0
    return Gadget(start, end, np.array([[0, 1, 2], [3, 4, 5]]), best)


def tiles(n: int) -> Gadget:
    """Drop n vertices onto n faces, each far from the others: n zones of one impact.

    Args:
        n: Number of tiles.
    """
    corners = np.array([[-0.25, -0.25, 0.0], [0.25, -0.25, 0.0], [0.0, 0.5, 0.0]])
    one = vertex_on_face(corners, 0.5, -0.25)
    side = int(np.ceil(np.sqrt(n)))
    places = np.zeros((n, 1, 3))
    places[:, 0, :2] = 2.0 * np.column_stack(np.divmod(np.arange(n), side))
    start, end, best = ((places + part).reshape(-1, 3) for part in (one.start, one.end, one.best))
    faces = 4 * np.arange(n)[:, None] + [0, 1, 2]
    return Gadget(start, end, faces.astype(np.int32), best)


def cage(half: float, proposed: ArrayLike) -> Gadget:
    """Close a pinned cube around a vertex in no face.

    Args:
        half: Half of the side of the cube at the end [m]; it is 1 m at the start.
        proposed: (3,) positive numbers [m], where the vertex wants to go, beyond three faces. Its
            best end keeps the thickness to these three. If the cube is so small that the vertex
            would then meet the other three, the best end that is returned is not free.
    """
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    start = np.concatenate((signs, [[0.125, 0.25, 0.375]]))
    end = np.concatenate((half * signs, [np.asarray(proposed, np.float64)]))
    best = end.copy()
    best[8] = np.minimum(end[8], half - THICKNESS_M)
    return Gadget(start, end, faces, best, np.arange(9) < 8)
