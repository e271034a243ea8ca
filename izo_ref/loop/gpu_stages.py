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
from izo_ref.base.gpu_arrays import empty, overwrite, positions_of, to_cpu, to_gpu, zeros
from izo_ref.base.options import Options
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.detection.gpu_detector import Detector
from izo_ref.detection.gpu_found import Found
from izo_ref.detection.serial import found_counts
from izo_ref.loop.gpu_zones import launch_to_measure, launches_of_zones, zones_left
from izo_ref.solvers.gpu_solve import ZoneSolver
from izo_ref.solvers.serial import zone_buffers
from izo_ref.zones.gpu_grouping import launch_of_grouping, launch_of_selection
from izo_ref.zones.group_buffers import listed_zones, zone_impacts
from izo_ref.zones.grouping import Zones
from izo_ref.zones.serial import group_counts
from izo_ref.zones.serial.group_records import StepArrays, ZoneRule

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
        step: The arrays of the step, with room for more impacts in zones; another record with more
            room may take its place.
        total_mass: Mass of the unpinned vertices [kg].
        found_counts: Counts of detection on the CPU: `detection/serial/found_counts.py`.
        group_counts: Counts of selection and grouping: `zones/serial/group_counts.py`.
        zone_counts: Counts of the solvers: `solvers/serial/zone_buffers.py`.
        zones_left: Zones that the last solution left to the CPU, on the CPU; None if there is none.
    """

    found_counts: Indices  # (N_COUNTS,) i8, and so are the other two
    group_counts: Indices
    zone_counts: Indices

    def __init__(self, scene: SceneArrays, thickness: float, options: Options) -> None:
        """Copy the scene to the GPU, and make all buffers and programs."""
        n, pinned = len(scene.pinned), scene.pinned
        masses = np.where(pinned, 0.0, scene.masses)  # those of pinned vertices do not count
        self._options, self.total_mass = options, float(masses.sum())
        self._counts = zeros((3, N_COUNTS), np.int64)
        self.found_counts, self.group_counts, self.zone_counts = np.zeros((3, N_COUNTS), np.int64)
        self.detector = Detector(scene, self._counts_of(0))
        self.step = StepArrays(
            *zone_impacts(max(int(IMPACTS_PER_VERTEX * n), LEAST_IMPACTS), empty),
            start=self.detector.start,
            proposed=positions_of(scene, "positions_t1"),
            positions=empty((n, 3), np.float64),
            pinned=to_gpu(pinned),
            stuck=empty(n, np.bool_),
            known_depths=empty(n, np.int32),
            masses=to_gpu(masses),
            inverse_sqrt_masses=to_gpu(np.where(pinned, 0.0, 1.0 / np.sqrt(scene.masses))),
            thickness=thickness,
        )
        self.zones_left: Zones | None = None
        self._found_with_cpu: Impacts | None = None
        self._prepare()

    def _counts_of(self, stage: int) -> GpuArray:
        """Return the counts of a stage on the GPU."""
        return self._counts[stage : stage + 1].reshape(N_COUNTS)

    def prepare_anew(self) -> None:
        """Prepare the programs again if the detector has made arrays since."""
        if self.detector.n_arrays_made != self._n_arrays_prepared:
            self._prepare()

    def _prepare(self) -> None:
        """Make the work space for the present buffers, and the programs.

        If memory runs out on the way, there are no programs, rather than some with old buffers.
        """
        self.__dict__.pop("_programs", None)  # the driver can have their work space first
        own, step, options = self.detector, self.step, self._options
        room, n = step.toi.shape[0], step.pinned.shape[0]
        found, grouped, solved = map(self._counts_of, range(3))
        n_found = found[found_counts.FOUND : found_counts.FOUND + 1]
        select = launch_of_selection(own.impacts, n_found, options.selection, step, grouped)
        rooms = min(room, n), room, min(4 * room, n)
        solver = ZoneSolver(n, step.thickness, options, rooms)
        every_zone = "changed-zones" not in options.rules
        rule = ZoneRule(every_zone, solver.most_small, solver.most_middle)
        self._zones, self._left = listed_zones(room, n, grouped, empty), empty(rooms[0], np.int64)
        detect = own.launches(step.positions, True)
        solve = [
            launch_of_grouping(step, rule, self._zones),
            *launches_of_zones(solver, self._zones, step, self._left, solved),
            *detect,
        ]
        self._programs = Programs(
            detection=Program(detect),
            iteration=Program([select, *solve]),
            solution=Program(solve),
            measuring=Program([launch_to_measure(solver, step, solved)]),
        )
        self._n_arrays_prepared = own.n_arrays_made

    def _run(self, program: Program) -> None:
        """Run a program, and read all counts."""
        program.run()
        self.found_counts, self.group_counts, self.zone_counts = to_cpu(self._counts)

    def detect(self) -> None:
        """Detect the impacts of the path to the current positions."""
        self._run(self._programs.detection)
        self._finish_detection()

    def select_and_solve(self) -> None:
        """Let impacts of the last detection enter the zones, solve these zones, and detect."""
        self._run(self._programs.iteration)
        while self.grow():
            self._put_found()  # the detection of the program has found other impacts
            self._run(self._programs.iteration)
        self._finish_solution()

    def grow(self) -> bool:
        """Make more room for impacts in zones if the last selection did not fit.

        Returns:
            Whether there was too little room. Then the selection has to run again.
        """
        room, needed = self.step.toi.shape[0], int(self.group_counts[group_counts.NEEDED_IMPACTS])
        if needed > room:
            larger = zone_impacts(max(needed, 2 * room), empty)
            overwrite(larger, self.step[: len(larger)])
            self.step = self.step._replace(**larger._asdict())
            self._prepare()
        return needed > room

    def solve(self) -> None:
        """Solve all zones of the impacts that there are, and detect."""
        self.set_impacts(int(self.group_counts[group_counts.IMPACTS]))
        self._run(self._programs.solution)
        self._finish_solution()

    def _finish_solution(self) -> None:
        """Take the zones that are left to the CPU; if there are none, finish the detection."""
        self.zones_left = None
        if self.zone_counts[zone_buffers.LEFT]:
            self.zones_left = zones_left(self._zones, self._left, self.zone_counts)
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
        self._counts_of(1)[:2].copy_to_device(own[:2])

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
