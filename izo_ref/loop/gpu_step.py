"""The step of the loop on a GPU.

`step.py` says what each method does; `cpu_step.py` is the same on the CPU. The CPU only sees counts
and the zones that the GPU could not solve. `select` runs the whole iteration on the GPU, with the
next detection (`gpu_stages.py`); `solve` and `detect` return what it counted.
"""

from __future__ import annotations

from copy import copy as copy_object
from typing import Any, cast

import numpy as np

from izo_ref.base.arrays import GpuArray, Indices, Positions
from izo_ref.base.cuda.memory import synchronize
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.gpu_arrays import copy, empty, overwrite, put_rows, shared_copy, to_cpu, to_gpu
from izo_ref.base.gpu_interop import shared_array
from izo_ref.base.options import Options
from izo_ref.base.records import DetectionCounts, Impacts, SceneArrays
from izo_ref.certificate.gpu_filter import which_meet
from izo_ref.detection.cuda import frames
from izo_ref.detection.gpu_detector import Detector
from izo_ref.loop.cpu_step import CpuStep
from izo_ref.loop.cuda import step as kernels
from izo_ref.loop.gpu_stages import Stages
from izo_ref.loop.gpu_zones import device_of_left, solve_left
from izo_ref.loop.step import Step
from izo_ref.solvers.serial.zone_buffers import ACTIVE, SQUARES
from izo_ref.zones.grouping import Zones
from izo_ref.zones.serial.group_counts import IMPACTS, NEW, TO_SOLVE, ZONES


class GpuStep(Step):
    """A step of the outer loop, with its arrays on a GPU.

    Its attributes are those of `Step`; `proposed`, (n_vertices, 3) f8 [m], the proposed end
    positions on the GPU; and `n_blocked`, the impacts between pinned points that the last detection
    left out.

    Args:
        scene: The scene, in the numbering of the loop.
        thickness: Distance that impacts keep at the end [m].
        options: Choices and tolerances.
        deadline: When each solve on the CPU has to end; the loop checks between the calls of a GPU.
    """

    def __init__(
        self,
        scene: SceneArrays,
        thickness: float,
        options: Options,
        deadline: Deadline = UNLIMITED,
    ) -> None:
        """Copy the scene to the GPU, and begin at the proposed positions, without impacts."""
        self._options = options
        self._stages = Stages(scene, thickness, options)
        own = self._stages.step
        self.positions, self.proposed = own.positions, own.proposed
        self.stuck, self.known_depths = own.stuck, own.known_depths
        self._longest = empty((len(scene.pinned), 3), np.float64)
        self._begin(scene, deadline)

    def _begin(self, scene: SceneArrays, deadline: Deadline) -> None:
        """Begin without impacts."""
        self.scene, self.n_left, self._deadline = scene, 0, deadline
        self._is_scene_old = False
        self.longest = (self.proposed, -1.0)
        self._start_again(0)

    def _start_again(self, n_impacts: int) -> None:
        """Go back to the proposed positions, with the first impacts of the buffer."""
        own = self._stages.step
        kernels.begin_step[max(len(self.scene.pinned), n_impacts)](
            own.proposed,
            own.multipliers[:n_impacts],
            own.positions,
            own.stuck,
            own.known_depths,
            own.active[:n_impacts],
        )
        self._stages.set_impacts(n_impacts)
        self._show_impacts()
        self._squares, self._n_active = 0.0, None
        self._is_solved = self._is_detected = False

    def _show_impacts(self) -> None:
        """Let the attributes show the impacts that there are in the buffer."""
        n, own = self.n_impacts, self._stages.step
        self.impacts = Impacts._make(column[:n] for column in own[:5])
        self.multipliers, self.active = own.multipliers[:n], own.active[:n]

    def relinearize(self) -> None:
        """Go back to the proposed positions, and linearize the tight impacts anew."""
        own, thickness = self.impacts, self._stages.step.thickness
        frames.renew_tight_frames[self.n_impacts](
            self.positions, own.nodes, own.is_edge_edge, thickness, own.weights, own.normals
        )
        self._start_again(self.n_impacts)

    def save(self) -> tuple[Any, ...]:
        """Return the state that `restore` takes."""
        own = *self.impacts, self.multipliers, self.active, self.positions, self.stuck
        return tuple(map(copy, own)), self.n_impacts, self._squares, self.n_active

    def restore(self, saved: tuple[Any, ...]) -> None:
        """Return to a saved state."""
        own, n_impacts, self._squares, self._n_active = saved
        overwrite((*self._stages.step[:7], self.positions, self.stuck), own)
        self._stages.set_impacts(n_impacts)
        self._show_impacts()
        self._is_solved = self._is_detected = False

    @property
    def n_impacts(self) -> int:
        """Number of impacts in zones."""
        return int(self._stages.group_counts[IMPACTS])

    @property
    def n_active(self) -> int:
        """Number of active impacts."""
        if self._n_active is None:
            self._n_active = int(np.count_nonzero(to_cpu(self.active)))
        return self._n_active

    def objective(self) -> float:
        """Return the objective at the current positions [m^2]."""
        total = self._stages.total_mass
        return self._squares / total if total > 0.0 else 0.0

    def detect(self) -> DetectionCounts:
        """Find the impacts of the path to the current positions."""
        own = self._stages
        detector = own.detector
        if not self._is_detected:
            own.detect()
        self._is_detected = False
        found = detector.found(own.found_counts, self.positions, True)
        self.found = found.impacts
        own.take_found(found)
        if found.time_free > self.longest[1]:
            self._longest.copy_to_device(self.positions)
            self.longest = (self._longest, found.time_free)
        self.n_blocked = found.n_blocked
        detector.remember(self.positions)
        n_found, counts = self.found.toi.shape[0], detector.counts
        return DetectionCounts(n_found, found.n_blocked, counts.moved, sum(counts.pairs.values()))

    def first_found(self, count: int) -> Impacts:
        """Return the first impacts of `found`, at most this many, on the CPU."""
        return to_cpu(Impacts._make(column[:count] for column in self.found))

    def one_meets(self, count: int) -> bool:
        """Return whether one of the first impacts of `found` certainly meets."""
        own = Impacts._make(column[:count] for column in self.found)
        return bool(which_meet(self._stages.step.start, self.proposed, own).any())

    def current_scene(self) -> SceneArrays:
        """Return the scene with its positions on the CPU."""
        if self._is_scene_old:
            own, scene = self._stages.step, cast(Any, copy_object(self.scene))
            scene.positions_t0, scene.positions_t1 = to_cpu(own.start), to_cpu(own.proposed)
            self.scene, self._is_scene_old = scene, False
        return self.scene

    def go_on(self, start: GpuArray, deadline: Deadline = UNLIMITED) -> None:
        """Take the next step of a simulation on the GPU.

        `proposed` has its proposed positions already. Nothing is copied to the CPU.

        Args:
            start: (n_vertices, 3) f8 [m], on the GPU, where it begins: where this one ends, or
                elsewhere, free of intersections.
            deadline: As for a new step.
        """
        self.detector.go_on(start)
        self.begin_again(deadline)

    def begin_again(self, deadline: Deadline = UNLIMITED) -> None:
        """Begin with the same start and what `proposed` has now; `deadline` as for a new step."""
        self._stages.prepare_anew()
        self._begin(self.scene, deadline)
        self._is_scene_old = True

    @property
    def has_failed(self) -> bool:
        """Whether no positions satisfy a zone; only the CPU, which tried last, can say so."""
        return self.n_left > 0 and bool(to_cpu(self.stuck).any())

    def select(self) -> int:
        """Let impacts of the last detection enter the zones, and return how many did.

        The zones are solved and the next impacts are detected at once; `solve` and `detect` return
        what was counted.
        """
        self._stages.select_and_solve()
        self._show_impacts()
        n_new = int(self._stages.group_counts[NEW])
        self._is_solved = n_new > 0
        return n_new

    def solve(self, first_new: int) -> tuple[int, int]:
        """Solve the zones that have an impact from `first_new` on; return counts of zones."""
        own = self._stages
        if not self._is_solved:
            own.solve()
        self._is_solved, self._is_detected = False, own.zones_left is None
        if own.zones_left is not None:
            self._solve_left(own.zones_left)
        self._squares = float(own.zone_counts[SQUARES : SQUARES + 1].view(np.float64)[0])
        self._n_active = int(own.zone_counts[ACTIVE])
        return int(own.group_counts[ZONES]), int(own.group_counts[TO_SOLVE])

    def _solve_left(self, zones: Zones) -> None:
        """Solve the zones that the launches left, and measure the step again."""
        own = self._stages
        if device_of_left(self._options) == "cpu":
            self.n_left += len(zones)
        scene, given = self.current_scene(), (self._options, self._deadline)
        solve_left(zones, scene, self.impacts, *given, own.step)
        own.measure()

    @property
    def detector(self) -> Detector:
        """The detector, on the GPU."""
        return self._stages.detector

    def positions_on_gpu(self, positions: Positions, order: Indices | None = None) -> GpuArray:
        """Return end positions as an array of the GPU; `order` as in `Step.positions_on_gpu`."""
        if order is None:
            return shared_copy(positions)
        return self.positions_back(to_gpu(order))

    def positions_back(self, order: GpuArray) -> GpuArray:
        """Return a copy of the positions in the order of the caller, as an array of the GPU.

        Args:
            order: (n_vertices,) i8, on the GPU, the caller's vertex at each place.
        """
        positions = empty(self.positions.shape, np.float64)
        put_rows(order, self.positions, positions)
        synchronize()  # other libraries may read the positions on streams of their own
        return shared_array(positions)

    def to_cpu(self) -> CpuStep:
        """Return the same step on the CPU; its detections still run on the GPU.

        They use the buffers of this step, so it can only begin again afterwards.
        """
        thickness, detector = self._stages.step.thickness, self._stages.detector
        own = self.current_scene(), thickness, self._options, detector, self._deadline
        same = CpuStep(*own)
        same.positions = to_cpu(self.positions)
        same.impacts = to_cpu(self.impacts)
        same.multipliers, same.active = to_cpu(self.multipliers), to_cpu(self.active)
        same.stuck, same.known_depths = to_cpu(self.stuck), to_cpu(self.known_depths)
        same.longest = (to_cpu(self.longest[0]), self.longest[1])
        same.n_left = self.n_left
        return same
