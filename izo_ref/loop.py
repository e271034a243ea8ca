"""The outer loop: detect, select, group, solve, until the path is free (SPEC section 6)."""

import time
from typing import NamedTuple

import numpy as np

from izo_ref.cpu import advance as kernels
from izo_ref.selection import select_impacts
from izo_ref.solve import solve_system
from izo_ref.types import Impacts, join_impacts, no_impacts
from izo_ref.zones import build_zones, members, zone_system

# An impact whose free vertices have less weight than this in all is between pinned points:
# a free vertex would have to move a billion times as far as the gap is to open.
NO_WEIGHT = 1e-9


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


def objective(scene, positions) -> float:
    """[m^2], sum m |x - y|^2 / sum m over the unpinned vertices (page eq. 1)."""
    free = ~scene.pinned
    if not free.any():
        return 0.0
    masses = scene.masses[free]
    offsets = (positions - scene.positions_t1)[free]
    return float((masses * (offsets**2).sum(axis=1)).sum() / masses.sum())


class Loop:
    """Where the outer loop stands.

    Args:
        scene: `Scene`.
        thickness: [m].
        options: `Options`.
        detector: `Detector` of the scene, of the processor or of a GPU.
        on_iteration: called with each `Iteration` as it ends.

    Attributes:
        positions: (n, 3) f8 [m], x.
        impacts: `Impacts`, all that entered the zones.
        multipliers: (n_impacts,) f8 [kg].
        starts: (n_impacts,) f8 [kg], multipliers from which each zone was solved.
        active: (n_impacts,) b1, impacts that hold x.
        stuck: (n,) b1, vertices of zones that no positions satisfy.
        blocked: impacts between pinned points, found on the path.
        longest: positions whose path was free for the longest time, and that time.
        history: list of `Iteration`.
    """

    def __init__(self, scene, thickness, options, detector, on_iteration=None):
        self.scene = scene
        self.thickness = thickness
        self.options = options
        self.history = []
        self._on_iteration = on_iteration
        self._detector = detector
        self.longest = (scene.positions_t1, -1.0)
        self.restart(no_impacts(), np.empty(0))

    def restart(self, impacts: Impacts, multipliers):
        """Back to the candidate positions, with these impacts and nothing solved.

        `multipliers`, (n_impacts,) f8 [kg], are those to start from.
        """
        self.positions = self.scene.positions_t1.copy()
        self.impacts = impacts
        self.multipliers, self.starts = multipliers, np.zeros(len(multipliers))
        self.active = multipliers > 0.0
        self.stuck = np.zeros(len(self.scene.pinned), bool)
        self.blocked = no_impacts()

    def save(self):
        return self.positions, self.impacts, self.multipliers, self.active, self.stuck

    def restore(self, saved):
        self.positions, self.impacts, self.multipliers, self.active, self.stuck = saved

    def run(self, round_number: int, limit: float = np.inf) -> bool:
        """Iterate until the path is free; False if it is not, after all that may be tried.

        Ends early when the objective reaches `limit` (zones only ever get more
        constraints, so it never falls), or when prescribed parts meet, which no end
        positions can mend.
        """
        if len(self.impacts.toi):
            self._solve(0)
        for iteration in range(1, self.options.max_iterations + 1):
            begin = time.perf_counter()
            found, moved = self.detect()
            if len(self.blocked.toi):
                return False
            middle = time.perf_counter()
            hopeful = found.take(~self.stuck[found.nodes].any(axis=1))
            new = hopeful.take(select_impacts(hopeful, self.scene.pinned, self.options.selection))
            n_before = len(self.impacts.toi)
            self.impacts = join_impacts((self.impacts, new))
            n_zones, n_solved = self._solve(n_before) if len(new.toi) else (0, 0)
            self.record(
                Iteration(
                    round_number,
                    iteration,
                    moved,
                    self.candidates,
                    len(found.toi),
                    len(new.toi),
                    len(self.impacts.toi),
                    n_zones,
                    n_solved,
                    objective(self.scene, self.positions),
                    middle - begin,
                    time.perf_counter() - middle,
                )
            )
            if self.history[-1].objective >= limit:
                return False
            if len(new.toi) == 0:
                return len(found.toi) == 0
        return len(self.detect()[0].toi) == 0

    @property
    def candidates(self) -> int:
        """Pairs that the last detection looked at."""
        return sum(self._detector.tally.pairs.values())

    def record(self, iteration: Iteration):
        self.history.append(iteration)
        if self._on_iteration is not None:
            self._on_iteration(iteration)

    def detect(self):
        """Impacts of the path to the positions now, but those between pinned points.

        Returns:
            `Impacts`, and how many vertices moved since the last detection.
        """
        found = self._detector.find(self.positions)
        time_free = float(found.toi.min(initial=1.0))
        if time_free > self.longest[1]:
            self.longest = (self.positions.copy(), time_free)
        if not self.scene.pinned.any():
            return found, self._detector.tally.moved
        free = ~self.scene.pinned[found.nodes]
        prescribed = (np.abs(found.weights) * free).sum(axis=1) < NO_WEIGHT
        self.blocked = found.take(prescribed)
        return found.take(~prescribed), self._detector.tally.moved

    def _solve(self, first_new: int):
        """Solve the zones with an impact from `first_new` on; others keep their solution."""
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
        dirty = changed if "changed-zones" in self.options.rules else np.ones(len(zones), bool)
        chosen = np.flatnonzero(dirty & ~stuck)
        if len(chosen) == 0:
            return len(zones), 0
        system = zone_system(self.scene, self.impacts, zones, chosen, self.thickness)
        rows, _ = members(zones.impacts, zones.impact_offsets, chosen)
        solution = solve_system(system, self.options, start=self.starts[rows])

        vertices, _ = members(zones.vertices, zones.vertex_offsets, chosen)
        solved = np.repeat(solution.feasible, np.diff(system.vertex_offsets))
        free = solution.positions[: len(vertices)]
        self.positions[vertices[solved]] = free[solved]
        self.stuck[vertices[~solved]] = True
        self.multipliers[rows] = solution.multipliers
        self.active[rows] = solution.active
        return len(zones), len(chosen)

    def relinearized(self):
        """The active impacts, with normals and weights of the closest points at x.

        Returns:
            `Impacts`, and their multipliers.
        """
        kept = self.impacts.take(self.active)
        weights, normals = np.empty_like(kept.weights), np.empty_like(kept.normals)
        kernels.closest_frames(self.positions, kept.nodes, kept.is_edge_edge, weights, normals)
        return kept._replace(weights=weights, normals=normals), self.multipliers[self.active]


def _extended(values, n):
    result = np.zeros(n, values.dtype)
    result[: len(values)] = values
    return result
