"""Check that a step may start where the path of a result ends."""

from typing import Any

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.base.errors import UncertifiedStartError


def certified_end(scene: Any, result: Any) -> Positions:
    """Return the end of a path that is certified free, or raise an error.

    Args:
        scene: The scene of the path.
        result: What `resolve` returned for it, or anything else.

    Returns:
        (n, 3) f8 [m].

    Raises:
        UncertifiedStartError: The path is not certified free, or it is that of another scene, or
            the positions of the result are not those that were certified.
    """
    certificate: Any = getattr(result, "certificate", None)
    known = all(hasattr(certificate, name) for name in ("free", "meeting_toi", "positions"))
    if not known or not hasattr(getattr(certificate, "scene", None), "positions_t0"):
        raise UncertifiedStartError(
            f"result: expected what `resolve` returned, got {type(result).__name__}, which has no "
            "certificate of a path. Pass its positions to a new Scene, which checks its start in "
            "full."
        )
    if certificate.scene is not scene:
        other = certificate.scene
        raise UncertifiedStartError(
            "result: expected the result of this scene, got that of another one, with "
            f"{len(other.positions_t0)} vertices and {len(other.faces)} faces; this scene has "
            f"{len(scene.positions_t0)} and {len(scene.faces)}. Call `after` of the scene that was "
            "resolved, or make a new Scene, which checks its start in full."
        )
    if not getattr(certificate, "finished", True):
        raise UncertifiedStartError(
            "result: expected a path that is certified free, but the time limit ended its "
            "certificate. Resolve the step again with a larger limit, or a smaller step."
        )
    if not certificate.free:
        raise UncertifiedStartError(
            f"result: expected a path that is certified free, got one on which "
            f"{len(certificate.meeting_toi)} pairs meet, the first at t = {certificate.time_free}. "
            "Resolve a smaller step, or change the motion of the pinned vertices, and go on from "
            "there."
        )
    if not np.array_equal(getattr(result, "positions", ()), certificate.positions):
        raise UncertifiedStartError(
            "result.positions: expected the positions that were certified, found others. Copy them "
            "before you change them, or pass them to a new Scene, which checks its start in full."
        )
    return certificate.positions
