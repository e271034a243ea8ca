"""The objective of a step: how far end positions are from the proposed ones."""

import math

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.base.records import SceneArrays
from izo_ref.base.units import largest, mass_exponent, times_power
from izo_ref.zones.serial.objective import weighted_squares

SMALL = 2.0**-900  # terms of a smaller sum may have lost digits


def objective(scene: SceneArrays, positions: Positions) -> float:
    """Compute sum m |x - y|^2 / sum m over the unpinned vertices (page eq. 1).

    Args:
        scene: The scene, with the proposed positions y and the masses m.
        positions: (n, 3) f8 [m], the end positions x.

    Returns:
        The objective [m^2]; 0 if every vertex is pinned. It is infinite or 0 where no float can
        hold it.
    """
    proposed, masses, pinned = scene.positions_t1, scene.masses, scene.pinned
    squares, mass = weighted_squares(positions, proposed, masses, pinned)
    unit = 0
    if not (SMALL < squares < math.inf and mass < math.inf):
        # either the sums are 0, or numbers in them overflow or underflow
        moved = 0.5 * positions - 0.5 * proposed  # half of it, because the whole may overflow
        length = -math.frexp(largest(moved))[1]
        scaled = times_power(masses, mass_exponent(masses, ~pinned))
        squares, mass = weighted_squares(
            times_power(moved, length), np.zeros_like(moved), scaled, pinned
        )
        unit = 2 - 2 * length
    value = squares / mass if mass > 0.0 else 0.0
    return times_power(value, unit) if unit else value
