"""The fail-safe: scale zones back toward the start until the path is free (SPEC 6)."""

import time
from typing import NamedTuple

import numpy as np

from izo_ref.base.records import join_impacts, no_impacts
from izo_ref.loop.iterate import Iteration, Loop
from izo_ref.zones.grouping import build_zones

# Halved so often, then zero: the last steps would gain next to nothing.
HALVINGS = 6


class ScaledBack(NamedTuple):
    """Vertices that go only a part of their way."""

    vertices: np.ndarray  # (n,) i8
    scale: float  # fraction of the displacement that is left


def scale_back(loop: Loop) -> list[ScaledBack]:
    """Scale the zones in trouble back until the path is free, or nothing is left to scale.

    The zones in trouble are those whose pairs still meet, joined with what they meet. The
    start is free, and a part of a path that is scaled evenly is the beginning of that
    path, so every group is free of meetings within itself at some scale. Each round
    lowers the scale of a group or ends, so the rounds are finite. What moves on
    prescribed paths is not scaled: if it still meets a group that rests, the step is
    blocked.
    """
    step, scene = loop.step, loop.step.scene
    full = step.positions - scene.positions_t0
    scale = np.ones(len(full))
    joined = no_impacts()
    detected = step.detect()
    rounds = 0
    while detected.found:
        begin = time.perf_counter()
        joined = join_impacts((joined, step.found))
        groups = build_zones(scene, join_impacts((step.impacts, joined)))
        trouble = np.zeros(len(scale), bool)
        trouble[step.found.nodes] = True
        lowered = False
        for group in range(len(groups)):
            vertices = groups.vertices_of(group)
            least = scale[vertices].min()
            if not trouble[vertices].any() or (least == 0.0 and scale[vertices].max() == 0.0):
                continue
            least = least / 2.0 if least > 0.5**HALVINGS else 0.0
            scale[vertices] = least
            lowered = True
        if not lowered:
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
