"""Judge what the loop returns: the residuals of the zones, and how they and the step ended."""

from __future__ import annotations

import numpy as np

from izo_ref.base.arrays import Multipliers, Positions
from izo_ref.base.options import Options
from izo_ref.base.records import Impacts, SceneArrays, Status
from izo_ref.certificate.certify import PathCertificate
from izo_ref.loop.scale_back import ScaledBack
from izo_ref.zones.grouping import Zones
from izo_ref.zones.problem import Residuals
from izo_ref.zones.residuals import residuals_of_zones
from izo_ref.zones.system import zone_system


def judge_zones(
    scene: SceneArrays,
    impacts: Impacts,
    multipliers: Multipliers,
    zones: Zones,
    thickness: float,
    positions: Positions,
) -> list[Residuals]:
    """Compute the residuals of each zone from the positions and multipliers that are returned."""
    system = zone_system(scene, impacts, zones, thickness)
    ends = np.empty_like(system.proposed)
    ends[system.nodes] = positions[impacts.nodes[zones.impacts]]
    return residuals_of_zones(system, ends, multipliers[zones.impacts])


def statuses_of_zones(
    zones: Zones,
    certificate: PathCertificate,
    scaled_back: list[ScaledBack],
    judged: list[Residuals],
    options: Options,
) -> list[Status]:
    """Return how each zone ended."""
    n = len(certificate.positions)
    meeting, scaled = np.zeros(n, bool), np.zeros(n, bool)
    meeting[certificate.meeting.nodes] = True
    for part in scaled_back:
        scaled[part.vertices] = True
    statuses = []
    for zone, residuals in enumerate(judged):
        vertices = zones.vertices_of(zone)
        solved = residuals.solved(options.gap_tolerance, options.violation_tolerance)
        if meeting[vertices].any():
            statuses.append(Status.BLOCKED)
        elif scaled[vertices].any() or not solved:
            statuses.append(Status.FREE_BY_FALLBACK)
        else:
            statuses.append(Status.FREE)
    return statuses


def verdict(
    certificate: PathCertificate,
    scaled_back: list[ScaledBack],
    judged: list[Residuals],
    options: Options,
    reason: str,
) -> tuple[Status, bool, bool]:
    """Return the status, converged and feasible, from what was certified and judged.

    Args:
        certificate: Certificate of the path.
        scaled_back: What was scaled back.
        judged: The residuals of each zone.
        options: The tolerances.
        reason: What the time limit ended; empty if it ended nothing.
    """
    valid = certificate.free and not scaled_back
    converged = valid and all(
        r.solved(options.gap_tolerance, options.violation_tolerance) for r in judged
    )
    if not certificate.free:
        status = Status.BLOCKED
    elif certificate.excluded is not None:
        status = Status.FREE_EXCEPT_EXCLUDED
    else:
        status = Status.FREE if converged and not reason else Status.FREE_BY_FALLBACK
    feasible = valid and all(r.feasible(options.violation_tolerance) for r in judged)
    return status, converged, feasible
