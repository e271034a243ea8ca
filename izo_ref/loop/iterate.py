"""The outer loop: detect, select, group, solve, until the path is free (SPEC section 6)."""

import time
from typing import NamedTuple

import numpy as np


class Iteration(NamedTuple):
    """One line of the history."""

    round: int  # 0: the main loop; 1, 2, ...: re-linearisation; -1: scaling back
    iteration: int
    moved: int  # vertices that moved since the last detection
    candidates: int  # pairs looked at
    found: int  # impacts of the path
    added: int  # of these selected
    impacts: int  # in all zones now
    zones: int
    solved: int  # zones solved in this iteration
    objective: float  # [m^2], after it
    detect_s: float
    solve_s: float


class Loop:
    """Iterates on a step.

    Args:
        step: `Step`, of the processor or of a GPU.
        max_iterations: detections of a run, before the last.
        on_iteration: called with each `Iteration` as it ends.

    Attributes:
        history: list of `Iteration`.
    """

    def __init__(self, step, max_iterations, on_iteration=None):
        self.step = step
        self.history = []
        self._max_iterations, self._on_iteration = max_iterations, on_iteration

    def run(self, round_number: int, limit: float = np.inf) -> bool:
        """Iterate until the path is free; False if it is not, after all that may be tried.

        Ends early when the objective reaches `limit` (zones only ever get more
        constraints, so it never falls), or when prescribed parts meet, which no end
        positions can mend.
        """
        step = self.step
        if step.n_impacts:
            step.solve(0)
        for iteration in range(1, self._max_iterations + 1):
            begin = time.perf_counter()
            detected = step.detect()
            if detected.blocked:
                return False
            middle = time.perf_counter()
            first_new = step.n_impacts
            n_new = step.select()
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
        return step.detect().found == 0

    def record(self, iteration: Iteration):
        self.history.append(iteration)
        if self._on_iteration is not None:
            self._on_iteration(iteration)
