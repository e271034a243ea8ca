"""Solve the zones of a step on a GPU: by one thread each, by one block each, or by all blocks.

All buffers are made once. How many zones there are is known on the GPU alone, so all launches are
prepared once, too.
"""

import numpy as np

from izo_ref.base.arrays import GpuArray
from izo_ref.base.devices import fixed_launch
from izo_ref.base.gpu_arrays import empty, full
from izo_ref.base.gpu_launch import by_grid
from izo_ref.base.options import Options
from izo_ref.solvers import gpu_pivoting
from izo_ref.solvers.cuda import listed_zones as kernels
from izo_ref.solvers.gpu_pivoting import Launch
from izo_ref.solvers.interior_point import FARTHEST
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.listed_zones import most_vertices
from izo_ref.solvers.serial.small_zone import (
    BLOCK_PIVOT,
    CLOSED_FORM,
    Limits,
    work_of_small_zone,
)
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers, ZoneRows
from izo_ref.zones.serial.group_records import StepArrays
from izo_ref.zones.serial.listed_zones import ListedZones

# Most impacts of a zone that one thread solves. It takes n^3 operations for n impacts, so with more
# impacts all others would wait for this one thread for long.
SMALL = 16
# Threads of a multiprocessor that solve small zones. Each has work space for the largest of them:
# 24 KB, so 205 MB are needed for 132 multiprocessors. With zones of 32 impacts it would be 89 KB.
SLOTS = 64


class ZoneSolver:
    """Solves zones on a GPU; small, middle and large zones are lists of their own.

    Args:
        n_vertices: Vertices of the step.
        thickness: [m].
        options: The method and the tolerances.
        room: How many zones, impacts in them, and unpinned vertices in them there is room for.

    Attributes:
        rows: The constraints of all zones.
        answers: Their solutions.
        sizes: (N_SIZES,) i8, how much is to be done.
        most_small: Most impacts of a small zone.
        most_middle: Most impacts of a middle zone.
    """

    def __init__(
        self, n_vertices: int, thickness: float, options: Options, room: tuple[int, int, int]
    ) -> None:
        """Allocate the buffers; a launch has its work space."""
        self._options, (n_zones, m, n) = options, room
        self.most_small, self.most_middle = min(SMALL, options.small_zone), gpu_pivoting.LARGEST
        self._places = empty(n_vertices, np.int32)
        self.sizes = full(at.N_SIZES, 0, np.int64)
        violation_m, never = options.violation_tolerance * thickness, full(1, False, np.bool_)
        self._limits = Limits(options.gap_tolerance, violation_m, FARTHEST, never)
        self.rows = ZoneRows(
            empty((m, 4), np.int32),
            empty((m, 4), np.float64),
            empty((m, 3), np.float64),
            empty(m, np.float64),
            empty(m, np.float64),
            empty(m, np.bool_),
            empty((n, 3), np.float64),
        )
        self.answers = ZoneAnswers(
            empty(m, np.float64),
            empty(3 * n, np.float64),
            empty(n_zones, np.bool_),
            empty(n_zones, np.int32),
        )

    def launches(self, zones: ListedZones, inputs: StepArrays, counts: GpuArray) -> list[Launch]:
        """Return the launches that write the constraints and solve the zones of the lists.

        Args:
            zones: The zones, on the GPU.
            inputs: The step, on the GPU.
            counts: (>= N_COUNTS,) i8, is begun anew.
        """
        own = self.rows, self.answers, self._places, self.sizes, counts
        write = by_grid(kernels.write_rows, zones, inputs, *own)
        if not self._options.is_default_method:
            return [write]
        own = zones.small, zones.middle, zones.large, zones.impact_offsets, zones.vertex_offsets
        return [write, *self.launches_of_lists(*own)]

    def launches_of_lists(
        self,
        small: GpuArray,
        middle: GpuArray,
        large: GpuArray,
        impact_offsets: GpuArray,
        vertex_offsets: GpuArray,
    ) -> list[Launch]:
        """Return the launches that solve the zones of lists, whose lengths are in `sizes`."""
        own = impact_offsets, vertex_offsets, self.sizes, self.rows, self._limits
        single = CLOSED_FORM if "closed-form" in self._options.rules else BLOCK_PIVOT
        n_blocks, n_threads = fixed_launch(1, SLOTS)
        n_numbers, n_indices = work_of_small_zone(SMALL, most_vertices(SMALL))
        numbers = empty((n_blocks * n_threads, n_numbers), np.float64)
        indices = empty((n_blocks * n_threads, n_indices), np.int32)
        more = single, self.answers, numbers, indices
        return [
            kernels.solve_list_in_slots.prepare(n_blocks, n_threads, small, *own, *more),
            *gpu_pivoting.launches_of_pivoting(middle, large, *own, self.answers),
        ]
