"""The stages of a step on a GPU: buffers that are made once, and programs of launches.

An iteration is one program: select, group, write the constraints, solve small zones, solve middle
zones, update the step, and detect again in five launches. All counts stay on the GPU. The CPU reads
them once, after the program, to know whether to go on, and whether a list was too short: then it
makes the list longer and runs again what did not fit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import GpuArray, Indices
from izo_ref.base.cuda.program import Program
from izo_ref.base.gpu_arrays import copy_positions, empty, full, positions_of, to_cpu
from izo_ref.base.options import Options
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.detection.gpu_detector import Detector
from izo_ref.detection.gpu_found import Found
from izo_ref.detection.serial import found_counts
from izo_ref.loop.gpu_left import zones_to_cpu
from izo_ref.loop.gpu_zones import ZoneStage
from izo_ref.solvers.serial import zone_buffers
from izo_ref.solvers.serial.zone_buffers import StepInputs, StepState
from izo_ref.zones.gpu_grouping import GroupingStage
from izo_ref.zones.gpu_selection import SELECTIONS, SelectionStage
from izo_ref.zones.group_buffers import zone_impacts
from izo_ref.zones.grouping import Zones
from izo_ref.zones.serial import group_counts
from izo_ref.zones.serial.group_records import SelectionRule, StepArrays, ZoneRule
from izo_ref.zones.serial.listed_zones import listed_zones

# Impacts in zones for which there is room at first, for each vertex, and the least room.
IMPACTS_PER_VERTEX, LEAST_IMPACTS = 0.25, 1024

N_COUNTS = 16  # of each stage: detection, selection and grouping, zones


class Programs(NamedTuple):
    """The programs of a step."""

    detection: Program
    iteration: Program  # select, solve and detect
    solution: Program  # solve and detect
    measuring: Program  # of the objective and the active impacts


class Stages:
    """The buffers and the programs of a step on a GPU.

    Args:
        scene: The scene, in the numbering of the loop.
        thickness: Distance that impacts keep at the end [m].
        options: Choices and tolerances.

    Attributes:
        detector: The detector.
        proposed: (n_vertices, 3) f8 [m], proposed end positions.
        positions: (n_vertices, 3) f8 [m], end positions of the current path.
        stuck: (n_vertices,) b1, vertices of zones that no positions satisfy.
        known_depths: (n_vertices,) i4, of `zones/serial/deep_selection.py`.
        impacts: The impacts in zones, with room for more.
        counts: (3 N_COUNTS,) i8, a copy of the counts of all stages on the CPU.
        zones_left: Zones that the last solution left to the CPU, on the CPU; None if there is none.
    """

    def __init__(self, scene: SceneArrays, thickness: float, options: Options) -> None:
        """Copy the scene to the GPU, and make all buffers and programs."""
        n = len(scene.pinned)
        self._thickness, self._options, self._n = thickness, options, n
        self._counts = full(3 * N_COUNTS, 0, np.int64)
        self.counts: Indices = np.zeros(3 * N_COUNTS, np.int64)
        self.detector = Detector(scene, self._part(0))
        self.proposed = positions_of(scene, "positions_t1")
        self.positions = empty((n, 3), np.float64)
        self.stuck, self.known_depths = empty(n, np.bool_), empty(n, np.int32)
        self._masses, self._inverse_sqrt_masses = (empty(n, np.float64) for _ in range(2))
        self._pinned = empty(n, np.bool_)
        self.impacts = zone_impacts(max(int(IMPACTS_PER_VERTEX * n), LEAST_IMPACTS), empty)
        self.zones_left: Zones | None = None
        self._found_with_cpu: Impacts | None = None
        self._take_masses(scene)
        self._prepare()

    def restart(self, scene: SceneArrays) -> None:
        """Take the next step of the same mesh: another start, other ends, masses, pinned vertices.

        Args:
            scene: A scene with the same vertices, edges and faces.
        """
        copy_positions(scene, "positions_t1", self.proposed)
        self._take_masses(scene)
        self._found_with_cpu = None
        self.detector.restart(scene)
        self.prepare_anew()

    def prepare_anew(self) -> None:
        """Prepare the programs again if the detector has made arrays since."""
        if self.detector.n_arrays_made != self._n_arrays_prepared:
            self._prepare()

    def _take_masses(self, scene: SceneArrays) -> None:
        """Copy the masses and what follows from them; those of pinned vertices do not count."""
        masses = np.where(scene.pinned, 0.0, scene.masses)
        self.total_mass = float(masses.sum())
        self._masses.copy_to_device(masses)
        self._pinned.copy_to_device(np.ascontiguousarray(scene.pinned))
        inverse = np.where(scene.pinned, 0.0, 1.0 / np.sqrt(scene.masses))
        self._inverse_sqrt_masses.copy_to_device(inverse)

    def _part(self, stage: int) -> GpuArray:
        """Return the counts of a stage on the GPU."""
        return self._counts[N_COUNTS * stage : N_COUNTS * (stage + 1)]

    @property
    def found_counts(self) -> Indices:
        """Counts of detection, (N_COUNTS,) i8: `detection/serial/found_counts.py`."""
        return self.counts[:N_COUNTS]

    @property
    def group_counts(self) -> Indices:
        """Counts of selection and grouping, (N_COUNTS,) i8: `zones/serial/group_counts.py`."""
        return self.counts[N_COUNTS : 2 * N_COUNTS]

    @property
    def zone_counts(self) -> Indices:
        """Counts of the solvers, (N_COUNTS,) i8: `solvers/serial/zone_buffers.py`."""
        return self.counts[2 * N_COUNTS :]

    @property
    def state(self) -> StepState:
        """What solving zones changes, on the GPU."""
        return StepState(self.positions, self.impacts.multipliers, self.impacts.active)

    def _prepare(self) -> None:
        """Make the stages for the present buffers, and their programs.

        If memory runs out on the way, there are no programs, rather than some with old buffers.
        """
        self.__dict__.pop("_programs", None)  # their work space goes back to the pool first
        options, n, room = self._options, self._n, self.impacts.toi.shape[0]
        found, at = self.detector.impacts, found_counts.FOUND
        step = StepArrays(
            self.detector.start, self.positions, self._pinned, self.stuck, self.known_depths
        )
        rule = SelectionRule(self._thickness, SELECTIONS[options.selection])
        own = self._part(1)
        self._selection = SelectionStage(
            found, self._part(0)[at : at + 1], step, rule, self.impacts, own
        )
        rooms = min(room, n), room, min(4 * room, n)
        self._zones = zones = ZoneStage(n, self._thickness, options, self._part(2), rooms)
        every_zone = "changed-zones" not in options.rules
        sizes = ZoneRule(every_zone, zones.most_small, zones.most_middle)
        own_zones = self.impacts.nodes, self._pinned, self.stuck, sizes, own
        grouping = GroupingStage(*own_zones)
        self.zones, state = listed_zones(grouping.lists, own), self.state
        inputs = StepInputs(
            self.impacts.nodes,
            self.impacts.weights,
            self.impacts.normals,
            self.proposed,
            self._inverse_sqrt_masses,
            self._masses,
            self._thickness,
        )
        detect = self.detector.launches(self.positions, True)
        solve = [*grouping.launches(), *zones.launches(self.zones, inputs, state), *detect]
        self._programs = Programs(
            detection=Program(detect),
            iteration=Program([*self._selection.launches(), *solve]),
            solution=Program(solve),
            measuring=Program([zones.to_measure(inputs, state)]),
        )
        self._n_arrays_prepared = self.detector.n_arrays_made

    def _run(self, program: Program) -> None:
        """Run a program, and read all counts."""
        program.run()
        self.counts = to_cpu(self._counts)

    def detect(self) -> None:
        """Detect the impacts of the path to the current positions."""
        self._run(self._programs.detection)
        self._finish_detection()

    def select_and_solve(self) -> None:
        """Let impacts of the last detection enter the zones, solve these zones, and detect."""
        self._run(self._programs.iteration)
        while self._selection.grow(self.group_counts):
            self.impacts = self._selection.impacts
            self._prepare()
            self._put_found()  # the detection of the program has found other impacts
            self._run(self._programs.iteration)
        self._finish_solution()

    def solve(self) -> None:
        """Solve all zones of the impacts that there are, and detect."""
        self.set_impacts(int(self.group_counts[group_counts.IMPACTS]))
        self._run(self._programs.solution)
        self._finish_solution()

    def _finish_solution(self) -> None:
        """Take the zones that are left to the CPU; if there are none, finish the detection."""
        self.zones_left = None
        if self.zone_counts[zone_buffers.LEFT]:
            left = self._zones.left(self.zone_counts)
            self.zones_left = zones_to_cpu(self.zones, self.zone_counts).part(left)
        else:
            self._finish_detection()

    def _finish_detection(self) -> None:
        """Detect again with more room until all pairs and contacts fit."""
        while self.detector.grow(self.found_counts):
            self._prepare()
            self._run(self._programs.detection)

    def measure(self) -> None:
        """Measure the step again, after the CPU has changed it."""
        self._run(self._programs.measuring)

    def set_impacts(self, n: int) -> None:
        """Say that the first n impacts of the buffer are those in zones, and that all are new.

        Args:
            n: Number of impacts.
        """
        own = self.group_counts
        own[group_counts.FIRST_NEW], own[group_counts.IMPACTS] = 0, n
        self._part(1)[:2].copy_to_device(own[:2])

    def take_found(self, found: Found) -> None:
        """Let the selection take the impacts of a detection, also if the CPU took part.

        Args:
            found: What the last detection found.
        """
        self._found_with_cpu = None if found.in_place else found.impacts
        self._put_found()

    def _put_found(self) -> None:
        """Put the impacts where the launches look for them, if the CPU took part."""
        if self._found_with_cpu is not None and self.detector.put(self._found_with_cpu):
            self._prepare()
