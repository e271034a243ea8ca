"""The step of the loop on a GPU.

`step.py` says what each method does; `cpu_step.py` is the same on the CPU. The CPU only sees counts
and the zones that the GPU could not solve.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray, GpuArray, Indices, Positions
from izo_ref.base.cuda.arrays import LEAST, SUM
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.gpu_arrays import (
    as_column,
    concatenate,
    copy,
    empty,
    flatnonzero,
    full,
    last_of,
    offsets_of,
    positions_of,
    reduce,
    shared_copy,
    take,
    to_cpu,
    to_gpu,
)
from izo_ref.base.gpu_impacts import (
    concatenate_impacts,
    impacts_to_cpu,
    impacts_to_gpu,
    take_impacts,
)
from izo_ref.base.gpu_interop import shared_array
from izo_ref.base.options import LAGRANGIAN, Options
from izo_ref.base.records import DetectionCounts, Impacts, SceneArrays, no_impacts
from izo_ref.detection.cuda import frames, paths
from izo_ref.detection.gpu_detector import Detector, HostDetector
from izo_ref.loop.cpu_step import CpuStep
from izo_ref.loop.cuda import step as kernels
from izo_ref.loop.step import Step
from izo_ref.solvers.cuda import zones as zone_kernels
from izo_ref.solvers.gpu_constraints import GpuConstraints, Members
from izo_ref.solvers.gpu_solve import solve_zones
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.gpu_grouping import blocks_of, build_zones, choose_zones
from izo_ref.zones.gpu_selection import find_deep_impacts, select_impacts
from izo_ref.zones.grouping import Zones
from izo_ref.zones.system import zone_system


class GpuStep(Step):
    """A step of the outer loop, with its arrays on a GPU; its attributes are those of `Step`.

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
        self.scene, self.n_left = scene, 0
        self._thickness, self._options, self._detector = thickness, options, Detector(scene)
        self._deadline, self._n = deadline, len(scene.pinned)
        masses = np.where(scene.pinned, 0.0, scene.masses)
        self._total_mass = float(masses.sum())
        self._masses, self._pinned = to_gpu(masses), to_gpu(scene.pinned)
        inverse = np.where(scene.pinned, 0.0, 1.0 / np.sqrt(scene.masses))
        self._inverse_sqrt_masses = to_gpu(inverse)
        self._start = positions_of(scene, "positions_t0")
        self._proposed = positions_of(scene, "positions_t1")
        self.longest = (self._proposed, -1.0)
        self._seen: GpuArray = None  # positions of the last detection
        self.begin(impacts_to_gpu(no_impacts()), empty(0, np.float64))

    def begin(self, impacts: Impacts, multipliers: GpuArray) -> None:
        """Go back to the proposed positions, with some impacts and nothing solved."""
        self.positions = copy(self._proposed)
        self.impacts, self.multipliers = impacts, multipliers
        self.active = empty(self.n_impacts, np.bool_)
        kernels.flag_positive[self.n_impacts](multipliers, self.active)
        self.stuck = full(self._n, False, np.bool_)
        self.known_depths = full(self._n, 0, np.int32)

    def relinearize(self) -> None:
        """Go back to the proposed positions, and linearize the tight impacts anew."""
        own, thickness = self.impacts, self._thickness
        weights, normals = copy(own.weights), copy(own.normals)
        frames.renew_tight_frames[self.n_impacts](
            self.positions, own.nodes, own.is_edge_edge, thickness, weights, normals
        )
        self.begin(own._replace(weights=weights, normals=normals), self.multipliers)

    def save(self) -> tuple[Any, ...]:
        """Return the state that `restore` takes."""
        return self.positions, self.impacts, self.multipliers, self.active, self.stuck

    def restore(self, saved: tuple[Any, ...]) -> None:
        """Return to a saved state."""
        self.positions, self.impacts, self.multipliers, self.active, self.stuck = saved

    @property
    def n_impacts(self) -> int:
        """Number of impacts in zones."""
        return self.impacts.toi.shape[0]

    @property
    def n_active(self) -> int:
        """Number of active impacts."""
        return flatnonzero(self.active).shape[0]

    def objective(self) -> float:
        """Return the objective at the current positions [m^2]."""
        if self._total_mass == 0.0:
            return 0.0
        terms = empty(self._n, np.float64)
        kernels.compute_objective_terms[self._n](
            self.positions, self._proposed, self._masses, terms
        )
        return float(reduce(as_column(terms), SUM)) / self._total_mass

    def detect(self) -> DetectionCounts:
        """Find the impacts of the path to the current positions."""
        found = self._detector.find(self.positions)
        n = found.toi.shape[0]
        kept = empty(n, np.bool_)
        kernels.flag_impacts_to_solve[n](found.nodes, found.weights, self._pinned, kept)
        index = flatnonzero(kept)
        n_found, time_free = index.shape[0], 1.0
        self.found = found if n_found == n else take_impacts(found, index)
        if n_found:
            # the bits of floats that are not negative, read as integers, have the same order
            bits = reduce(as_column(self.found.toi.view(np.int64)), LEAST)
            time_free = float(np.int64(bits).view(np.float64))
        if time_free > self.longest[1]:
            self.longest = (copy(self.positions), time_free)
        candidates = sum(self._detector.counts.pairs.values())
        return DetectionCounts(n_found, n - n_found, self._count_moved(), candidates)

    def first_found(self, count: int) -> Impacts:
        """Return the first impacts of `found`, at most this many, on the CPU."""
        return impacts_to_cpu(Impacts._make(column[:count] for column in self.found))

    def _count_moved(self) -> int:
        """Count the vertices that moved since the last detection."""
        seen, self._seen = self._seen, copy(self.positions)
        if seen is None:
            return self._n
        moved = empty(self._n, np.bool_)
        paths.flag_moved_vertices[self._n](seen, self.positions, moved)
        return last_of(offsets_of(moved))

    def select(self) -> int:
        """Let impacts of the last detection enter the zones, and return how many did."""
        n = self.found.toi.shape[0]
        hopeful = empty(n, np.bool_)
        own = self.found.nodes, self.found.weights, self.found.normals
        kernels.flag_hopeful_impacts[n](self.positions, *own, self.stuck, self._thickness, hopeful)
        index = flatnonzero(hopeful)
        new = self.found if index.shape[0] == n else take_impacts(self.found, index)
        selection, deep = self._options.selection, None
        if selection == "independent":
            state = self.positions, self._pinned, self.known_depths
            deep = take(find_deep_impacts(self.found, self._start, *state), index)
        kept = select_impacts(new, self._pinned, selection, deep)
        new = take_impacts(new, kept)
        self.impacts = concatenate_impacts(self.impacts, new)
        return new.toi.shape[0]

    def solve(self, first_new: int) -> tuple[int, int]:
        """Solve the zones that have an impact from `first_new` on; return counts of zones."""
        zones = build_zones(self.impacts, self._pinned)
        n_zones = len(zones)
        missing = self.n_impacts - self.multipliers.shape[0]
        self.multipliers = concatenate([self.multipliers, full(missing, 0.0, np.float64)])
        self.active = concatenate([self.active, full(missing, False, np.bool_)])
        if "changed-zones" in self._options.rules:
            offsets, changed = zones.impact_offsets, empty(n_zones, np.bool_)
            kernels.flag_changed_zones[n_zones](zones.impacts, offsets, first_new, changed)
        else:
            changed = full(n_zones, True, np.bool_)
        chosen = empty(n_zones, np.bool_)
        kernels.flag_zones_to_solve[n_zones](changed, self._spread_stuck(zones), chosen)
        zones_to_solve = choose_zones(zones, chosen)
        if zones_to_solve is None:
            return n_zones, 0
        self._solve_zones(zones_to_solve)
        return n_zones, len(zones_to_solve)

    def _spread_stuck(self, zones: Zones) -> GpuArray:
        """Mark all vertices of a zone with a stuck vertex; return those zones, (n_zones,) b1."""
        n, stuck = zones.vertices.shape[0], full(len(zones), False, np.bool_)
        zone_of = blocks_of(zones.vertex_offsets, n)
        kernels.flag_stuck_zones[n](zones.vertices, zone_of, self.stuck, stuck)
        kernels.spread_stuck[n](zones.vertices, zone_of, stuck, self.stuck)
        return stuck

    def _solve_zones(self, zones: Zones) -> None:
        """Solve zones on the GPU, and those that it leaves on the CPU."""
        constraints, hopeless = self._scale_constraints(zones)
        n, m = zones.vertices.shape[0], zones.impacts.shape[0]
        zone_of_impact = blocks_of(zones.impact_offsets, m)
        zone_of_vertex = blocks_of(zones.vertex_offsets, n)
        members = Members(zone_of_impact, zone_of_vertex, zones.vertices, self._inverse_sqrt_masses)
        solution = solve_zones(constraints, members, self._thickness, self._options)
        kernels.fail_hopeless[m](hopeless, zone_of_impact, solution.solved)
        kernels.move_vertices[n](
            zones.vertices,
            zone_of_vertex,
            solution.solved,
            self._proposed,
            self._inverse_sqrt_masses,
            solution.z,
            self.positions,
        )
        kernels.keep_multipliers[m](
            zones.impacts,
            zone_of_impact,
            solution.solved,
            solution.multipliers,
            constraints.lengths,
            self.multipliers,
            self.active,
        )
        left = empty(len(zones), np.bool_)
        kernels.negate_flags[len(zones)](solution.solved, left)
        zones_left = choose_zones(zones, left)
        if zones_left is not None:
            self._solve_zones_left(zones_left)

    def _scale_constraints(self, zones: Zones) -> tuple[GpuConstraints, GpuArray]:
        """Return the constraints of zones in scaled variables, and those nothing can satisfy."""
        n = zones.impacts.shape[0]
        impacts = take_impacts(self.impacts, zones.impacts)
        unknowns, hopeless = empty((n, 4), np.int32), empty(n, np.bool_)
        coefficients, rhs, lengths = (empty(s, np.float64) for s in ((n, 4), n, n))
        zone_kernels.scale_constraints[n](
            impacts.nodes,
            impacts.weights,
            impacts.normals,
            self._proposed,
            self._inverse_sqrt_masses,
            self._thickness,
            unknowns,
            coefficients,
            rhs,
            lengths,
            hopeless,
        )
        places = empty(self._n, np.int32)
        kernels.number_vertices[zones.vertices.shape[0]](zones.vertices, places)
        kernels.number_unknowns[n](places, unknowns)
        offsets = zones.impact_offsets, zones.vertex_offsets
        return GpuConstraints(
            *offsets, unknowns, coefficients, impacts.normals, rhs, lengths
        ), hopeless

    def _solve_zones_left(self, zones: Zones) -> None:
        """Solve zones that the GPU left: the CPU states their problems and solves them.

        Methods of the augmented Lagrangian still run on the GPU, because the options name them.
        """
        self.n_left += len(zones)
        impacts = impacts_to_cpu(take_impacts(self.impacts, zones.impacts))
        # not by `_make` or `_replace`: they ask for the number of fields, and `Zones` counts zones
        on_cpu = Zones(*(to_cpu(column) for column in zones))
        local = Zones(np.arange(len(impacts.toi)), *on_cpu[1:])
        system = zone_system(self.scene, impacts, local, self._thickness)
        by_gpu = self._options.method in LAGRANGIAN or self._options.preset is not None
        start, active = (
            to_cpu(take(column, zones.impacts)) for column in (self.multipliers, self.active)
        )
        start[~active] = 0.0
        more = {"device": "cuda" if by_gpu else "cpu", "start": start, "deadline": self._deadline}
        solution = solve_system(system, self._options, **more)
        solved = np.repeat(solution.feasible, np.diff(on_cpu.vertex_offsets))
        vertices = on_cpu.vertices
        positions = solution.positions[: len(vertices)]
        _put(vertices[solved], positions[solved], self.positions)
        stuck = vertices[~solved]
        _put(stuck, np.ones((len(stuck), 1), bool), as_column(self.stuck))
        for values, values_out in (
            (solution.multipliers, self.multipliers),
            (solution.active, self.active),
        ):
            _put(on_cpu.impacts, as_column(values), as_column(values_out))

    def positions_on_gpu(self, positions: Positions, order: Indices | None = None) -> GpuArray:
        """Return end positions as an array of the GPU; `order` as in `Step.positions_on_gpu`."""
        if order is None:
            return shared_copy(positions)
        moved_back = empty((self._n, 3), np.float64)
        kernels.put_rows[self._n](to_gpu(order), self.positions, moved_back)
        return shared_array(moved_back)

    def to_cpu(self) -> CpuStep:
        """Return the same step on the CPU; its detections still run on the GPU."""
        seen = None if self._seen is None else to_cpu(self._seen)
        detector = HostDetector(self._detector, seen)
        same = CpuStep(self.scene, self._thickness, self._options, detector, self._deadline)
        same.positions = to_cpu(self.positions)
        same.impacts = impacts_to_cpu(self.impacts)
        same.multipliers, same.active = to_cpu(self.multipliers), to_cpu(self.active)
        same.stuck, same.known_depths = to_cpu(self.stuck), to_cpu(self.known_depths)
        same.longest = (to_cpu(self.longest[0]), self.longest[1])
        same.n_left = self.n_left
        return same


def _put(index: Indices, rows: AnyArray, values_out: GpuArray) -> None:
    """Write rows of an array of the CPU to the places of an index in an array of the GPU."""
    kernels.put_rows[len(index)](to_gpu(index), to_gpu(rows), values_out)
