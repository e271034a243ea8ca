"""The objective of a step: how far end positions are from the proposed ones."""

from izo_ref.base.arrays import Positions
from izo_ref.base.records import SceneArrays
from izo_ref.zones.serial.objective import weighted_squares


def objective(scene: SceneArrays, positions: Positions) -> float:
    """Compute sum m |x - y|^2 / sum m over the unpinned vertices (page eq. 1).

    Args:
        scene: The scene, with the proposed positions y and the masses m.
        positions: (n, 3) f8 [m], the end positions x.

    Returns:
        The objective [m^2]; 0 if every vertex is pinned.
    """
    squares, mass = weighted_squares(positions, scene.positions_t1, scene.masses, scene.pinned)
    return squares / mass if mass > 0.0 else 0.0
