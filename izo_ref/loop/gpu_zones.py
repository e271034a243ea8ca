"""The zones of a step on a GPU: solve them, and update the step, in five launches."""

from __future__ import annotations

from typing import Any

import numpy as np

from izo_ref.base.arrays import GpuArray, Indices
from izo_ref.base.gpu_arrays import empty, to_cpu
from izo_ref.base.gpu_launch import by_grid
from izo_ref.base.options import Options
from izo_ref.loop.cuda import update as kernels
from izo_ref.solvers.gpu_solve import Launch, ZoneSolver
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.zone_buffers import StepInputs, StepState
from izo_ref.zones.serial.listed_zones import ListedZones


class ZoneStage:
    """Solves the zones of lists and updates a step.

    Prepared launches keep the arrays that they were prepared for, so they are prepared anew when
    arrays of the step are replaced.

    Args:
        n_vertices: Vertices of the step.
        thickness: [m].
        options: The method and the tolerances.
        counts: (>= N_COUNTS,) i8 on the GPU, what the CPU reads.
        room: How many zones, impacts in them, and unpinned vertices in them there is room for. If
            some do not fit, no zone is solved and nothing is updated.

    Attributes:
        most_small: Most impacts of a small zone.
        most_middle: Most impacts of a middle zone.
    """

    def __init__(
        self,
        n_vertices: int,
        thickness: float,
        options: Options,
        counts: GpuArray,
        room: tuple[int, int, int],
    ) -> None:
        """Allocate all buffers."""
        self._solver = ZoneSolver(n_vertices, thickness, options, room)
        self._counts = counts, counts.view(np.float64)
        self.most_small, self.most_middle = self._solver.most_small, self._solver.most_middle
        self._left = empty(room[0], np.int64)

    def launches(self, zones: ListedZones, inputs: StepInputs, state: StepState) -> list[Launch]:
        """Return the launches that solve the zones of the lists and update the step.

        Args:
            zones: The zones, on the GPU.
            inputs: The step, on the GPU.
            state: The step, on the GPU; entries of solved zones are written.
        """
        solver, own = self._solver, (zones, inputs)
        more = solver.rows.lengths, solver.answers, solver.sizes, state, self._left
        update = by_grid(kernels.update_step, *own, *more, *self._counts)
        return [*solver.launches(*own, state, self._counts[0]), update]

    def to_measure(self, inputs: StepInputs, state: StepState) -> Launch:
        """Return the launch that measures a step again, after the CPU has changed it."""
        own = inputs, self._solver.sizes, state
        return by_grid(kernels.measure_step, *own, *self._counts)

    def left(self, counts: Any) -> Indices:
        """Return the zones that are left to the CPU, on the CPU, ascending.

        Args:
            counts: (>= N_COUNTS,) i8, what the launches counted, on the CPU.
        """
        return np.sort(to_cpu(self._left[: int(counts[at.LEFT])]))
