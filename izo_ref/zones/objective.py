"""The objective of a step: how far end positions are from the proposed ones."""

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.base.records import SceneArrays


def objective(scene: SceneArrays, positions: Positions) -> float:
    """Compute sum m |x - y|^2 / sum m over the unpinned vertices (page eq. 1).

    Args:
        scene: The scene, with the proposed positions y and the masses m.
        positions: (n, 3) f8 [m], the end positions x.

    Returns:
        The objective [m^2]; 0 if every vertex is pinned.
    """
    unpinned = ~scene.pinned
    if not unpinned.any():
        return 0.0
    masses = scene.masses[unpinned]
    offsets = (positions - scene.positions_t1)[unpinned]
    squares: np.ndarray = (offsets**2).sum(axis=1)
    return float((masses * squares).sum() / masses.sum())
