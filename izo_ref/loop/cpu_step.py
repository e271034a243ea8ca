"""Where a step stands, and what the outer loop does to it (SPEC section 6), on the processor.

`izo_ref/loop/gpu_step.py` is the same on a device.
"""

import numpy as np

from izo_ref.base.ranges import members
from izo_ref.base.records import DetectionCounts, Impacts, join_impacts, no_impacts
from izo_ref.detection.cpu import frames as kernels
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.grouping import build_zones
from izo_ref.zones.objective import objective
from izo_ref.zones.selection import select_impacts
from izo_ref.zones.serial.selection import prescribed_impacts
from izo_ref.zones.system import zone_system


class CpuStep:
    """Where a step stands.

    Args:
        scene: `Scene`.
        thickness: [m].
        options: `Options`.
        detector: `Detector` of the scene, or what is called as it is.

    Attributes:
        positions: (n, 3) f8 [m], x.
        impacts: `Impacts`, all that entered the zones.
        multipliers: (n_impacts,) f8 [kg].
        starts: (n_impacts,) f8 [kg], multipliers from which each zone was solved.
        active: (n_impacts,) b1, impacts that hold x.
        stuck: (n,) b1, vertices of zones that no positions satisfy.
        found: `Impacts` of the last detection, but those between pinned points.
        longest: positions whose path was free for the longest time, and that time.
        n_left: zones that a GPU left to the processor.
    """

    def __init__(self, scene, thickness, options, detector):
        self.scene = scene
        self.longest, self.n_left = (scene.positions_t1, -1.0), 0
        self._thickness, self._options, self._detector = thickness, options, detector
        self.begin(no_impacts(), np.empty(0))

    def begin(self, impacts: Impacts, multipliers):
        """Back to the candidate positions, with these impacts and nothing solved.

        `multipliers`, (n_impacts,) f8 [kg], are those to start from.
        """
        self.positions = self.scene.positions_t1.copy()
        self.impacts = impacts
        self.multipliers, self.starts = multipliers, np.zeros(len(multipliers))
        self.active = multipliers > 0.0
        self.stuck = np.zeros(len(self.scene.pinned), bool)

    def relinearize(self):
        """The same with the active impacts, and normals and weights of the closest points at x."""
        kept = self.impacts.take(self.active)
        weights, normals = np.empty_like(kept.weights), np.empty_like(kept.normals)
        kernels.compute_closest_frames(
            self.positions, kept.nodes, kept.is_edge_edge, weights, normals
        )
        self.begin(kept._replace(weights=weights, normals=normals), self.multipliers[self.active])

    def save(self):
        return self.positions, self.impacts, self.multipliers, self.active, self.stuck

    def restore(self, saved):
        self.positions, self.impacts, self.multipliers, self.active, self.stuck = saved

    @property
    def n_impacts(self) -> int:
        """Impacts in zones."""
        return len(self.impacts.toi)

    @property
    def n_active(self) -> int:
        """Of these, those that hold x."""
        return int(np.count_nonzero(self.active))

    def objective(self) -> float:
        return objective(self.scene, self.positions)

    def detect(self) -> DetectionCounts:
        """Find the impacts of the path to the positions now."""
        found = self._detector.find(self.positions)
        time_free = float(found.toi.min(initial=1.0))
        if time_free > self.longest[1]:
            self.longest = (self.positions.copy(), time_free)
        counts, n_blocked = self._detector.counts, 0
        if self.scene.pinned.any():
            prescribed = np.empty(len(found.toi), bool)
            prescribed_impacts(found.nodes, found.weights, self.scene.pinned, prescribed)
            n_blocked = int(np.count_nonzero(prescribed))
            found = found.take(~prescribed)
        self.found = found
        return DetectionCounts(len(found.toi), n_blocked, counts.moved, sum(counts.pairs.values()))

    def select(self) -> int:
        """Let impacts of the last detection enter the zones; returns how many."""
        hopeful = self.found.take(~self.stuck[self.found.nodes].any(axis=1))
        kept = select_impacts(hopeful, self.scene.pinned, self._options.selection)
        self.impacts = join_impacts((self.impacts, hopeful.take(kept)))
        return int(np.count_nonzero(kept))

    def solve(self, first_new: int):
        """Solve the zones with an impact from `first_new` on; others keep their solution.

        Returns:
            How many zones there are, and how many of them were solved.
        """
        zones = build_zones(self.scene, self.impacts)
        changed = np.maximum.reduceat(zones.impacts, zones.impact_offsets[:-1]) >= first_new
        # a zone that did not change starts, if it is solved again, where it did
        self.multipliers = _extended(self.multipliers, len(self.impacts.toi))
        self.starts = _extended(self.starts, len(self.impacts.toi))
        self.active = _extended(self.active, len(self.impacts.toi))
        rows, _ = members(zones.impacts, zones.impact_offsets, np.flatnonzero(changed))
        self.starts[rows] = np.where(self.active[rows], self.multipliers[rows], 0.0)
        stuck = np.logical_or.reduceat(self.stuck[zones.vertices], zones.vertex_offsets[:-1])
        for zone in np.flatnonzero(stuck):
            self.stuck[zones.vertices_of(zone)] = True
        dirty = changed if "changed-zones" in self._options.rules else np.ones(len(zones), bool)
        chosen = np.flatnonzero(dirty & ~stuck)
        if len(chosen) == 0:
            return len(zones), 0
        system = zone_system(self.scene, self.impacts, zones, chosen, self._thickness)
        rows, _ = members(zones.impacts, zones.impact_offsets, chosen)
        solution = solve_system(system, self._options, start=self.starts[rows])

        vertices, _ = members(zones.vertices, zones.vertex_offsets, chosen)
        solved = np.repeat(solution.feasible, np.diff(system.vertex_offsets))
        free = solution.positions[: len(vertices)]
        self.positions[vertices[solved]] = free[solved]
        self.stuck[vertices[~solved]] = True
        self.multipliers[rows] = solution.multipliers
        self.active[rows] = solution.active
        return len(zones), len(chosen)

    def to_cpu(self):
        """The same on the processor."""
        return self

    def positions_on_gpu(self, positions, order=None):
        """(n, 3) f8 [m], positions on the device of a step that is there, else None.

        Args:
            positions: (n, 3) f8 [m], on the processor.
            order: (n,) i8, vertex of each place, if they are the step's own, put back so.
        """


def _extended(values, n):
    result = np.zeros(n, values.dtype)
    result[: len(values)] = values
    return result
