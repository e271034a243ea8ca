"""The outer loop: detect, select, group, solve, until the path is free (docs/method section 6)."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.exact_path import first_meeting
from izo_ref.base.options import RULES
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.certificate.certify import certify_in_time
from izo_ref.loop.step import Step
from izo_ref.loop.time_plan import TimePlan

# Impacts of the first detection that are tried before the certificate is asked for all pairs. The
# filter of the certificate decides nearly every real impact, in 1 us.
SAMPLE = 64


class Iteration(NamedTuple):
    """One iteration of the outer loop, or one round of scaling back.

    Attributes:
        round: 0 in the main loop; 1, 2, ... while the normals are taken again; -1 while zones are
            scaled back.
        iteration: Number of the iteration in its round, from 1.
        moved: Vertices that moved since the previous detection.
        candidates: Candidate pairs that the detection checked.
        found: Impacts of the path.
        added: Impacts that were selected and entered the zones.
        impacts: Impacts in all zones, with those that were added.
        zones: Zones.
        solved: Zones that were solved in this iteration.
        objective: Objective after the iteration [m^2].
        detect_s: Time that the detection took [s].
        solve_s: Time that the rest of the iteration took [s].
    """

    round: int
    iteration: int
    moved: int
    candidates: int
    found: int
    added: int
    impacts: int
    zones: int
    solved: int
    objective: float
    detect_s: float
    solve_s: float


class Loop:
    """The outer loop over a step.

    Args:
        step: The step, on the CPU or on a GPU.
        max_iterations: Largest number of detections of a run, not counting the last one.
        on_iteration: Function that is called with the record of each iteration as it ends.
        times: The stages of the run; without a limit if None.

    Attributes:
        step: The step.
        history: The records of all iterations.
        times: The stages of the run.
    """

    def __init__(
        self,
        step: Step,
        max_iterations: int,
        on_iteration: Callable[[Iteration], object] | None = None,
        times: TimePlan | None = None,
    ) -> None:
        """Keep the step; nothing runs yet."""
        self.step = step
        self.times = times or TimePlan(UNLIMITED)
        self.history: list[Iteration] = []
        self._max_iterations, self._on_iteration = max_iterations, on_iteration

    def run(self, round_number: int, limit: float = np.inf) -> bool:
        """Iterate until the path is free.

        Args:
            round_number: `round` of the records.
            limit: Objective at which the run ends early [m^2]. Zones only get more constraints,
                so the objective never falls again.

        Returns:
            True if the path is free, except for impacts between pinned points, which no end
            positions of the other vertices can prevent. False if the iterations are used up, if
            the objective has reached `limit`, or if there are such impacts and the scene says that
            they block the step.

        Raises:
            OutOfTimeError: The present stage of `times` has used up its time.
        """
        step, times = self.step, self.times
        if step.n_impacts:
            step.solve(0)
        for iteration in range(1, self._max_iterations + 1):
            times.deadline.check()
            begin = time.perf_counter()
            detected = step.detect()
            times.begin_main()
            if detected.found + detected.blocked and self._proposal_is_free():
                detected = detected._replace(found=0, blocked=0)
            if detected.blocked and step.scene.prescribed == "block":
                return False
            times.deadline.check()
            middle = time.perf_counter()
            first_new = step.n_impacts
            n_new = step.select() if detected.found else 0
            n_zones, n_solved = step.solve(first_new) if n_new else (0, 0)
            self.record(
                Iteration(
                    round_number,
                    iteration,
                    detected.moved,
                    detected.candidates,
                    detected.found,
                    n_new,
                    step.n_impacts,
                    n_zones,
                    n_solved,
                    step.objective(),
                    middle - begin,
                    time.perf_counter() - middle,
                )
            )
            if self.history[-1].objective >= limit:
                return False
            if n_new == 0:
                return detected.found == 0
        times.deadline.check()
        return step.detect().found == 0

    def _proposal_is_free(self) -> bool:
        """Return whether the first detection found no pair that really meets.

        Detection calls a pair an impact if it cannot prove it apart, for example because the sides
        come closer to each other than rounding can tell. If one of some impacts meets, the
        proposed positions are not free. Floats nearly always say so; else exact arithmetic does,
        impact by impact, in a millisecond each. Only if none of them meets, which is rare, the
        certificate decides about all pairs.
        """
        step = self.step
        if self.history:
            return False
        if step.one_meets(SAMPLE):
            return False
        scene, deadline = step.current_scene(), self.times.deadline
        if _one_meets(step.first_found(SAMPLE), scene, deadline):
            return False
        end = scene.positions_t1
        return certify_in_time(scene, end, frozenset(RULES), "cpu", deadline).free

    def record(self, iteration: Iteration) -> None:
        """Append the record of an iteration to the history, and pass it on."""
        self.history.append(iteration)
        if self._on_iteration is not None:
            self._on_iteration(iteration)


def _one_meets(impacts: Impacts, scene: SceneArrays, deadline: Deadline) -> bool:
    """Return whether one of the impacts meets on the path to the proposed positions, exactly."""
    start, end = scene.positions_t0, scene.positions_t1
    return any(
        first_meeting(bool(is_edge_edge), start[nodes], end[nodes]) is not None
        for nodes, is_edge_edge in deadline.checked(
            zip(impacts.nodes, impacts.is_edge_edge, strict=True)
        )
    )
