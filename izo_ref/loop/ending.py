"""How a run ends: with a certified path, or with everything unpinned at the start."""

from __future__ import annotations

from collections.abc import Set
from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.base.deadline import OutOfTimeError
from izo_ref.base.options import RULES
from izo_ref.base.records import SceneArrays
from izo_ref.certificate.certify import PathCertificate, certify_in_time, unfinished_certificate
from izo_ref.loop.scale_back import ScaledBack
from izo_ref.loop.time_plan import TimePlan
from izo_ref.zones.objective import objective


class Ending(NamedTuple):
    """What a run returns, before its zones are judged."""

    positions: Positions  # (n, 3) f8 [m]
    certificate: PathCertificate
    scaled_back: list[ScaledBack]


def certified_ending(
    scene: SceneArrays,
    positions: Positions,
    scaled_back: list[ScaledBack],
    rules: Set[str],
    device: str,
    times: TimePlan,
) -> Ending:
    """Certify a path. If that takes too long, certify that everything unpinned stays at the start.

    Args:
        scene: The scene.
        positions: (n, 3) f8 [m], end of the path; not used if `times.stays`.
        scaled_back: What was scaled back on it.
        rules: Names of the rules of `options.RULES` to apply.
        device: Where the certificate's filter runs.
        times: The stages of the run.
    """
    if not times.stays:
        times.begin_certificate()
        try:
            certificate = certify_in_time(scene, positions, rules, device, times.deadline)
            return Ending(positions, certificate, scaled_back)
        except OutOfTimeError:
            times.stay()
    positions = at_start(scene)
    is_at_rest = bool((positions == scene.positions_t0).all())
    times.begin_at_start()
    try:
        # With all rules, pairs at rest are not looked at. That they are apart is proved already.
        where = "cpu" if is_at_rest else device
        own = scene, positions, frozenset(RULES), where, times.deadline
        certificate = certify_in_time(*own)
    except OutOfTimeError:
        times.note(
            "All vertices that are not pinned stay at the start, and nothing is proved about the "
            "path of the pinned ones."
        )
        certificate = unfinished_certificate(scene, positions)
    held = np.flatnonzero((positions != scene.positions_t1).any(axis=1))
    return Ending(positions, certificate, [ScaledBack(held, 0.0)] if len(held) else [])


def at_start(scene: SceneArrays) -> Positions:
    """Return pinned vertices at their proposed positions and all others at the start, (n, 3) f8."""
    return np.where(scene.pinned[:, None], scene.positions_t1, scene.positions_t0)


def start_is_nearer(scene: SceneArrays, positions: Positions) -> bool:
    """Return whether the start is a free answer that is nearer to the proposed positions.

    Args:
        scene: The scene.
        positions: (n, 3) f8 [m], another answer.
    """
    start = at_start(scene)
    if scene.touching is not None or (start != scene.positions_t0).any():
        return False  # what touches meets, and what is pinned may meet something
    return objective(scene, start) < objective(scene, positions)
