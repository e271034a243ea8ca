"""An overhand knot in a thin tube, which is pulled until it is tight, and then on."""

import numpy as np

from izo_ref.base.arrays import Faces, Positions

RADIUS_M = 0.02
REACH = 2.1  # of the parameter of the curve


def pulled_knot(n_rings: int, pull: float) -> tuple[Positions, Positions, Faces]:
    """Make a knotted tube of triangular cross-section that is proposed to become straight.

    The curve is the polynomial trefoil knot (t^3 - 3 t, t^5 - 10 t, t^4 - 4 t^2), made narrower.
    Each ring moves on a straight line toward its place on the straight tube between the two ends.

    Args:
        n_rings: Rings of three vertices along the tube, at least 2.
        pull: Part of its way that each ring is to go; at 1 the tube is straight, without a knot.

    Returns:
        Positions at the start, proposed positions at the end, and faces.

    Source: A. R. Shastri, Polynomial representations of knots, Tohoku Math. J. 44 (1992).
    """
    t = np.linspace(-REACH, REACH, n_rings)
    curve = np.column_stack((t**3 - 3.0 * t, 0.1 * (t**5 - 10.0 * t), 0.3 * (t**4 - 4.0 * t**2)))
    along = np.gradient(curve, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(along, (0.31, 0.17, 0.93))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    third = np.cross(along, across)
    angles = 2.0 * np.pi * np.arange(3) / 3.0
    around = (
        across[:, None] * np.cos(angles)[None, :, None]
        + third[:, None] * np.sin(angles)[None, :, None]
    )
    start = curve[:, None] + RADIUS_M * around
    share = np.linspace(0.0, 1.0, n_rings)[:, None]
    line = (1.0 - share) * curve[0] + share * curve[-1]
    end = start + pull * (line - curve)[:, None]
    ring = 3 * np.arange(n_rings - 1)[:, None]
    k = np.arange(3)
    a, b = ring + k, ring + (k + 1) % 3
    faces = np.concatenate(
        (
            np.stack((a, b, b + 3), axis=2).reshape(-1, 3),
            np.stack((a, b + 3, a + 3), axis=2).reshape(-1, 3),
        )
    )
    return start.reshape(-1, 3), end.reshape(-1, 3), faces.astype(np.int32)
