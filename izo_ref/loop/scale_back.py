"""The fail-safe: scale zones back toward the start until the path is free.

Source: docs/method section 6.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Indices
from izo_ref.base.records import join_impacts, no_impacts
from izo_ref.loop.iterate import Iteration, Loop
from izo_ref.zones.grouping import Zones, build_zones

# A scale is halved this many times and then set to zero, because further halvings would gain next
# to nothing.
HALVINGS = 6


class ScaledBack(NamedTuple):
    """Vertices that go only a part of their way.

    Attributes:
        vertices: (n,) i8.
        scale: The fraction of their displacement that is left.
    """

    vertices: Indices
    scale: float


def scale_back(loop: Loop) -> list[ScaledBack]:
    """Scale the zones in trouble back until the path is free, or nothing is left to scale.

    The zones in trouble are those with a pair that still meets; they are joined with the zones
    that they meet. A displacement that is scaled evenly follows the beginning of the same path. So
    if the start is free, at some scale nothing in a group meets anything else in the group. Each
    round lowers the scale of a group or ends, so the number of rounds is finite. Pinned vertices
    are not scaled back. If they still meet a group that stays at the start, or if the group touches
    itself there, it is blocked.

    Args:
        loop: The loop; its step is on the CPU, and its positions are changed.

    Returns:
        The vertices that were scaled back, grouped by scale.
    """
    step, scene = loop.step, loop.step.scene
    full = step.positions - scene.positions_t0
    scale = np.ones(len(full))
    joined = no_impacts()
    detected = step.detect()
    rounds = 0
    while detected.found:
        loop.times.deadline.check()
        begin = time.perf_counter()
        joined = join_impacts((joined, step.found))
        groups = build_zones(scene, join_impacts((step.impacts, joined)))
        trouble = np.zeros(len(scale), bool)
        trouble[step.found.nodes] = True
        if not _lower_scales(groups, trouble, scale, loop.times.halves()):
            break
        kept = scale == 1.0
        start = scene.positions_t0
        step.positions = np.where(kept[:, None], step.positions, start + scale[:, None] * full)
        middle = time.perf_counter()
        n_found = detected.found
        detected = step.detect()
        rounds += 1
        loop.record(
            Iteration(
                -1,
                rounds,
                detected.moved,
                detected.candidates,
                n_found,
                0,
                step.n_impacts,
                len(groups),
                0,
                step.objective(),
                time.perf_counter() - middle,
                middle - begin,
            )
        )
    return [
        ScaledBack(np.flatnonzero(scale == value), float(value))
        for value in np.unique(scale[scale < 1.0])
    ]


def _lower_scales(groups: Zones, trouble: Flags, scale: Floats, halves: bool) -> bool:
    """Lower the scale of each group with a vertex in trouble.

    Args:
        groups: Vertices that are scaled together.
        trouble: (n_vertices,) b1, vertices of pairs that meet.
        scale: (n_vertices,) f8, fraction of the displacement; changed.
        halves: Whether to halve the scales; else they become 0, because time is short.

    Returns:
        False if all groups in trouble were at scale 0 already.
    """
    lowered = False
    for group in range(len(groups)):
        vertices = groups.vertices_of(group)
        least = scale[vertices].min()
        if not trouble[vertices].any() or (least == 0.0 and scale[vertices].max() == 0.0):
            continue
        scale[vertices] = least / 2.0 if halves and least > 0.5**HALVINGS else 0.0
        lowered = True
    return lowered
