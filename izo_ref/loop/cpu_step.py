"""The step of the outer loop on the CPU (docs/method section 6).

`step.py` says what each method does; `gpu_step.py` is the same on a GPU.
"""

from __future__ import annotations

from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from izo_ref.base.arrays import Flags, Floats, Indices, Multipliers, Positions
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.options import Options
from izo_ref.base.records import (
    DetectionCounts,
    Impacts,
    PairCounts,
    SceneArrays,
    join_impacts,
    no_impacts,
)
from izo_ref.certificate.cpu.meetings import decide_meetings
from izo_ref.detection.cpu import frames
from izo_ref.detection.serial.prescribed import prescribed_impacts
from izo_ref.loop.step import Step
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.grouping import Zones, build_zones
from izo_ref.zones.objective import objective
from izo_ref.zones.selection import find_deep_impacts, select_impacts
from izo_ref.zones.serial.selection import hopeful_impacts
from izo_ref.zones.system import zone_system

# positions, impacts, multipliers, active, stuck
State: TypeAlias = tuple[Positions, Impacts, Multipliers, Flags, Flags]


class PathDetector(Protocol):
    """What finds the impacts of a path: the detector of the CPU, or that of a GPU behind it.

    Attributes:
        counts: Counts of the last detection.
    """

    counts: PairCounts

    def find(self, positions_t1: Positions) -> Impacts:
        """Return the impacts of the path from the start to some end positions."""
        ...


class CpuStep(Step):
    """A step of the outer loop, with its arrays on the CPU.

    Args:
        scene: The scene, in the numbering of the loop.
        thickness: Distance that impacts keep at the end [m].
        options: Choices and tolerances.
        detector: Detector of the scene.
        deadline: When each solve has to end.

    Attributes:
        starts: (n_impacts,) f8 [kg], multipliers from which each zone was last solved. The other
            attributes are those of `Step`.
    """

    starts: Multipliers

    def __init__(
        self,
        scene: SceneArrays,
        thickness: float,
        options: Options,
        detector: PathDetector,
        deadline: Deadline = UNLIMITED,
    ) -> None:
        """Begin at the proposed positions, without impacts."""
        self.scene = scene
        self.longest, self.n_left = (scene.positions_t1, -1.0), 0
        self._thickness, self._options, self._detector = thickness, options, detector
        self._deadline = deadline
        self.begin(no_impacts(), np.empty(0))

    def begin(self, impacts: Impacts, multipliers: Multipliers) -> None:
        """Go back to the proposed positions, with some impacts and nothing solved.

        Args:
            impacts: The impacts in zones.
            multipliers: (n_impacts,) f8 [kg], from which the solvers start.
        """
        self.positions = self.scene.positions_t1.copy()
        self.impacts = impacts
        self.multipliers, self.starts = multipliers, np.zeros(len(multipliers))
        self.active = multipliers > 0.0
        self.stuck = np.zeros(len(self.scene.pinned), bool)
        self.known_depths = np.zeros(len(self.scene.pinned), np.int32)

    def relinearize(self) -> None:
        """Go back to the proposed positions, and linearize the tight impacts anew."""
        own, thickness = self.impacts, self._thickness
        weights, normals = own.weights.copy(), own.normals.copy()
        frames.renew_tight_frames(
            self.positions, own.nodes, own.is_edge_edge, thickness, weights, normals
        )
        self.begin(own._replace(weights=weights, normals=normals), self.multipliers)

    def save(self) -> State:
        """Return the state that `restore` takes."""
        return self.positions, self.impacts, self.multipliers, self.active, self.stuck

    def restore(self, saved: tuple[Any, ...]) -> None:
        """Return to a saved state."""
        self.positions, self.impacts, self.multipliers, self.active, self.stuck = saved

    @property
    def n_impacts(self) -> int:
        """Number of impacts in zones."""
        return len(self.impacts.toi)

    @property
    def n_active(self) -> int:
        """Number of active impacts."""
        return int(np.count_nonzero(self.active))

    def objective(self) -> float:
        """Return the objective at the current positions [m^2]."""
        return objective(self.scene, self.positions)

    def detect(self) -> DetectionCounts:
        """Find the impacts of the path to the current positions."""
        found = self._detector.find(self.positions)
        counts, n_blocked = self._detector.counts, 0
        if self.scene.pinned.any():
            prescribed = np.empty(len(found.toi), bool)
            prescribed_impacts(found.nodes, found.weights, self.scene.pinned, prescribed)
            n_blocked = int(np.count_nonzero(prescribed))
            found = found.take(~prescribed)
        self.found = found
        time_free = float(found.toi.min(initial=1.0))
        if time_free > self.longest[1]:
            self.longest = (self.positions.copy(), time_free)
        return DetectionCounts(len(found.toi), n_blocked, counts.moved, sum(counts.pairs.values()))

    def first_found(self, count: int) -> Impacts:
        """Return the first impacts of `found`, at most this many."""
        return Impacts._make(column[:count] for column in self.found)

    def one_meets(self, count: int) -> bool:
        """Return whether one of the first impacts of `found` certainly meets."""
        own, scene = self.first_found(count), self.scene
        meets = np.empty(len(own.toi), bool)
        pairs = own.nodes, own.is_edge_edge, own.toi
        decide_meetings(scene.positions_t0, scene.positions_t1, *pairs, meets)
        return bool(meets.any())

    def current_scene(self) -> SceneArrays:
        """Return the scene."""
        return self.scene

    def select(self) -> int:
        """Let impacts of the last detection enter the zones, and return how many did."""
        if len(self.found.toi) == 0:
            return 0
        own = self.found.nodes, self.found.weights, self.found.normals
        can_help = np.empty(len(self.found.toi), bool)
        hopeful_impacts(self.positions, *own, self.stuck, self._thickness, can_help)
        hopeful, selection, deep = self.found.take(can_help), self._options.selection, None
        if selection == "independent":
            state = self.positions, self.known_depths
            deep = find_deep_impacts(self.scene, self.found, *state)[can_help]
        kept = select_impacts(hopeful, self.scene.pinned, selection, deep)
        self.impacts = join_impacts((self.impacts, hopeful.take(kept)))
        return int(np.count_nonzero(kept))

    def solve(self, first_new: int) -> tuple[int, int]:
        """Solve the zones that have an impact from `first_new` on; return counts of zones."""
        zones = build_zones(self.scene, self.impacts)
        changed = np.maximum.reduceat(zones.impacts, zones.impact_offsets[:-1]) >= first_new
        self.multipliers = _extended(self.multipliers, len(self.impacts.toi))
        self.starts = _extended(self.starts, len(self.impacts.toi))
        self.active = _extended(self.active, len(self.impacts.toi))
        # Only changed zones get new starts: an unchanged zone that is solved again starts from
        # where it started before.
        sizes = zones.impact_offsets[1:] - zones.impact_offsets[:-1]
        own = zones.impacts[changed.repeat(sizes)]
        self.starts[own] = np.where(self.active[own], self.multipliers[own], 0.0)
        stuck = self._spread_stuck(zones)
        dirty = changed if "changed-zones" in self._options.rules else np.ones(len(zones), bool)
        chosen = (dirty & ~stuck).nonzero()[0]
        if len(chosen):
            self._solve_zones(zones.part(chosen))
        return len(zones), len(chosen)

    def _spread_stuck(self, zones: Zones) -> Flags:
        """Mark all vertices of a zone with a stuck vertex; return those zones, (n_zones,) b1."""
        stuck = np.logical_or.reduceat(self.stuck[zones.vertices], zones.vertex_offsets[:-1])
        for zone in stuck.nonzero()[0].tolist():
            self.stuck[zones.vertices_of(zone)] = True
        return stuck

    def _solve_zones(self, zones: Zones) -> None:
        own, vertices = zones.impacts, zones.vertices
        system = zone_system(self.scene, self.impacts, zones, self._thickness)
        more = {"start": self.starts[own], "deadline": self._deadline}
        solution = solve_system(system, self._options, **more)
        solved = solution.feasible.repeat(system.vertex_offsets[1:] - system.vertex_offsets[:-1])
        positions: Floats = solution.positions[: len(vertices)]
        self.positions[vertices[solved]] = positions[solved]
        self.stuck[vertices[~solved]] = True
        self.multipliers[own] = solution.multipliers
        self.active[own] = solution.active

    def to_cpu(self) -> Step:
        """Return the same step on the CPU, which this one is."""
        return self

    def positions_on_gpu(self, positions: Positions, order: Indices | None = None) -> None:
        """Return None: this step has no arrays on a GPU."""


def _extended(values: NDArray[Any], n: int) -> NDArray[Any]:
    """Return an array of n values: the given ones, then zeros."""
    result = np.zeros(n, values.dtype)
    result[: len(values)] = values
    return result
