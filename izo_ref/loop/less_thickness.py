"""Find free ends for vertices that have too little room for the thickness.

Source: docs/method section 6.
"""

from __future__ import annotations

import copy

import numpy as np

from izo_ref.base.arrays import Flags, Positions
from izo_ref.base.deadline import Deadline
from izo_ref.base.options import Options
from izo_ref.detection.detector import Detector
from izo_ref.loop.cpu_step import CpuStep
from izo_ref.loop.iterate import Loop
from izo_ref.loop.step import Step
from izo_ref.scene import Scene

# Fractions of the thickness that are tried, one after the other. Each costs as much as resolving
# the vertices in question, so there are few. The first leaves a layer between two walls room down
# to an eighth of what its thickness needs; with the last one the thickness is nearly gone.
FRACTIONS = (2.0**-2, 2.0**-8, 2.0**-16, 2.0**-32)
# Largest number of iterations with each of them. All four together then do not take longer than
# the main loop may take, which has failed before.
MOST_ITERATIONS = 25


def find_with_less_thickness(
    step: Step, stuck: Flags, thickness: float, options: Options, deadline: Deadline
) -> Positions | None:
    """Find ends of some vertices that keep a part of the thickness, on a free path.

    All other vertices go where the step has them, as pinned vertices do, so nothing that is
    resolved changes.

    Args:
        step: The step, whose path is free but for some pairs.
        stuck: (n_vertices,) b1, unpinned vertices without a free end; each of these pairs has one.
        thickness: Distance that impacts keep at the end [m].
        options: Choices and tolerances.
        deadline: When the search has to end.

    Returns:
        (n_vertices, 3) f8 [m], ends of all vertices; None if there are none with any of
        `FRACTIONS`.

    Raises:
        OutOfTimeError: The time of this stage of the deadline is used up.
    """
    scene: Scene = copy.copy(step.scene)  # pyright: ignore[reportAssignmentType]
    scene.positions_t1 = np.where(stuck[:, None], step.scene.positions_t1, step.positions)
    scene.pinned, scene.prescribed, scene.on_gpu = ~stuck, "exclude", {}
    for fraction in FRACTIONS:
        detector = Detector.of_scene(scene, options.rules, deadline)
        own = CpuStep(scene, fraction * thickness, options, detector, deadline)
        if Loop(own, min(options.max_iterations, MOST_ITERATIONS)).run(0):
            return own.positions
    return None
