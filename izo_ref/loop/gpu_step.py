"""The step of the loop on a GPU.

`step.py` says what each method does; `cpu_step.py` is the same on the CPU. The CPU sees counts, and
the zones that the GPU could not solve.
"""

import numpy as np

from izo_ref.base.cuda.arrays import LEAST, SUM
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
from izo_ref.base.options import LAGRANGIAN
from izo_ref.base.records import DetectionCounts, Impacts, no_impacts
from izo_ref.detection.cuda import frames, paths
from izo_ref.detection.gpu_detector import Detector, HostDetector
from izo_ref.loop.cpu_step import CpuStep
from izo_ref.loop.cuda import step as kernels
from izo_ref.solvers.cuda import zones
from izo_ref.solvers.gpu_solve import GpuConstraints, solve_zones
from izo_ref.solvers.gpu_variables import Members
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.gpu_grouping import build_zones
from izo_ref.zones.gpu_selection import select_impacts
from izo_ref.zones.grouping import Zones
from izo_ref.zones.system import zone_system


class GpuStep:
    """Where a step stands; attributes as of `izo_ref.loop.cpu_step.Step`, on the device.

    Args:
        scene: `Scene`.
        thickness: [m].
        options: `Options`.
    """

    def __init__(self, scene, thickness, options):
        self.scene, self.n_left = scene, 0
        self._thickness, self._options, self._detector = thickness, options, Detector(scene)
        self._n = len(scene.pinned)
        free_masses = np.where(scene.pinned, 0.0, scene.masses)
        self._total_mass = float(free_masses.sum())
        self._masses, self._pinned = to_gpu(free_masses), to_gpu(scene.pinned)
        inverse = np.where(scene.pinned, 0.0, 1.0 / np.sqrt(scene.masses))
        self._inverse_sqrt_masses = to_gpu(inverse)
        self._proposed = positions_of(scene, "positions_t1")
        self.longest = (self._proposed, -1.0)
        self._seen = None
        self.begin(impacts_to_gpu(no_impacts()), empty(0, np.float64))

    def begin(self, impacts: Impacts, multipliers):
        self.positions = copy(self._proposed)
        self.impacts, self.multipliers = impacts, multipliers
        self.active = empty(self.n_impacts, np.bool_)
        kernels.flag_positive[self.n_impacts](multipliers, self.active)
        self.stuck = full(self._n, False, np.bool_)

    def relinearize(self):
        index = flatnonzero(self.active)
        kept, n = take_impacts(self.impacts, index), index.shape[0]
        weights, normals = empty((n, 4), np.float64), empty((n, 3), np.float64)
        frames.compute_closest_frames[n](
            self.positions, kept.nodes, kept.is_edge_edge, weights, normals
        )
        kept = kept._replace(weights=weights, normals=normals)
        self.begin(kept, take(self.multipliers, index))

    def save(self):
        return self.positions, self.impacts, self.multipliers, self.active, self.stuck

    def restore(self, saved):
        self.positions, self.impacts, self.multipliers, self.active, self.stuck = saved

    @property
    def n_impacts(self) -> int:
        return self.impacts.toi.shape[0]

    @property
    def n_active(self) -> int:
        return flatnonzero(self.active).shape[0]

    def objective(self) -> float:
        if self._total_mass == 0.0:
            return 0.0
        terms = empty(self._n, np.float64)
        kernels.compute_objective_terms[self._n](
            self.positions, self._proposed, self._masses, terms
        )
        return float(reduce(as_column(terms), SUM)) / self._total_mass

    def detect(self) -> DetectionCounts:
        found = self._detector.find(self.positions)
        n, time_free = found.toi.shape[0], 1.0
        if n:
            # bits of floats that are not negative are in their order
            bits = reduce(as_column(found.toi.view(np.int64)), LEAST)
            time_free = float(np.int64(bits).view(np.float64))
        if time_free > self.longest[1]:
            self.longest = (copy(self.positions), time_free)
        kept = empty(n, np.bool_)
        kernels.flag_impacts_to_solve[n](found.nodes, found.weights, self._pinned, kept)
        index = flatnonzero(kept)
        n_found = index.shape[0]
        self.found = found if n_found == n else take_impacts(found, index)
        candidates = sum(self._detector.counts.pairs.values())
        return DetectionCounts(n_found, n - n_found, self._count_moved(), candidates)

    def _count_moved(self):
        seen, self._seen = self._seen, copy(self.positions)
        if seen is None:
            return self._n
        moved = empty(self._n, np.bool_)
        paths.flag_moved_vertices[self._n](seen, self.positions, moved)
        return last_of(offsets_of(moved))

    def select(self) -> int:
        n = self.found.toi.shape[0]
        hopeful = empty(n, np.bool_)
        kernels.flag_hopeful_impacts[n](self.found.nodes, self.stuck, hopeful)
        index = flatnonzero(hopeful)
        new = self.found if index.shape[0] == n else take_impacts(self.found, index)
        new = take_impacts(new, select_impacts(new, self._pinned, self._options.selection))
        self.impacts = concatenate_impacts(self.impacts, new)
        return new.toi.shape[0]

    def solve(self, first_new: int):
        grouped = build_zones(self.impacts, self._pinned)
        n_zones = len(grouped)
        missing = self.n_impacts - self.multipliers.shape[0]
        self.multipliers = concatenate([self.multipliers, full(missing, 0.0, np.float64)])
        self.active = concatenate([self.active, full(missing, False, np.bool_)])
        if "changed-zones" in self._options.rules:
            offsets, changed = grouped.impact_offsets, empty(n_zones, np.bool_)
            kernels.flag_changed_zones[n_zones](grouped.impacts, offsets, first_new, changed)
        else:
            changed = full(n_zones, True, np.bool_)
        chosen = empty(n_zones, np.bool_)
        kernels.flag_zones_to_solve[n_zones](changed, self._spread_stuck(grouped), chosen)
        part = _zones_of(grouped, chosen)
        if part is None:
            return n_zones, 0
        self._solve_part(part)
        return n_zones, len(part)

    def _spread_stuck(self, grouped):
        """A zone with a stuck vertex is stuck: (n_zones,) b1."""
        vertices, zone_of = grouped.vertices, _parts_of(grouped.vertex_offsets, grouped.vertices)
        n, stuck = vertices.shape[0], full(len(grouped), False, np.bool_)
        kernels.flag_stuck_zones[n](vertices, zone_of, self.stuck, stuck)
        kernels.spread_stuck[n](vertices, zone_of, stuck, self.stuck)
        return stuck

    def _solve_part(self, part):
        """Solve zones on the device, and those that it leaves on the processor."""
        rows, hopeless = self._scaled_rows(part)
        n, m = part.vertices.shape[0], part.impacts.shape[0]
        zone_of_row = _parts_of(part.impact_offsets, part.impacts)
        zone_of_vertex = _parts_of(part.vertex_offsets, part.vertices)
        members = Members(zone_of_row, zone_of_vertex, part.vertices, self._inverse_sqrt_masses)
        solution = solve_zones(rows, members, self._thickness, self._options)
        kernels.fail_hopeless[m](hopeless, zone_of_row, solution.solved)
        kernels.move_vertices[n](
            part.vertices,
            zone_of_vertex,
            solution.solved,
            self._proposed,
            self._inverse_sqrt_masses,
            solution.z,
            self.positions,
        )
        kernels.keep_multipliers[m](
            part.impacts,
            zone_of_row,
            solution.solved,
            solution.multipliers,
            rows.lengths,
            self.multipliers,
            self.active,
        )
        left = empty(len(part), np.bool_)
        kernels.negate_flags[len(part)](solution.solved, left)
        part = _zones_of(part, left)
        if part is not None:
            self._solve_on_host(part)

    def _scaled_rows(self, part):
        """`GpuConstraints` of zones, and which of them nothing can satisfy."""
        n = part.impacts.shape[0]
        own = take_impacts(self.impacts, part.impacts)
        unknowns, hopeless = empty((n, 4), np.int32), empty(n, np.bool_)
        coefficients, rhs, lengths = (empty(s, np.float64) for s in ((n, 4), n, n))
        zones.scale_constraints[n](
            own.nodes,
            own.weights,
            own.normals,
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
        kernels.number_vertices[part.vertices.shape[0]](part.vertices, places)
        kernels.number_unknowns[n](places, unknowns)
        offsets = part.impact_offsets, part.vertex_offsets
        return GpuConstraints(*offsets, unknowns, coefficients, own.normals, rhs, lengths), hopeless

    def _solve_on_host(self, part):
        self.n_left += len(part)
        own = impacts_to_cpu(take_impacts(self.impacts, part.impacts))
        grouped = Zones(*(to_cpu(column) for column in part))
        local = Zones(np.arange(len(own.toi)), *grouped[1:])
        everything = np.arange(len(part))
        system = zone_system(self.scene, own, local, everything, self._thickness)
        of_device = self._options.method in LAGRANGIAN or self._options.preset is not None
        device = "cuda" if of_device else "cpu"
        solution = solve_system(system, self._options, device=device)
        solved = np.repeat(solution.feasible, np.diff(grouped.vertex_offsets))
        vertices = grouped.vertices
        free = solution.positions[: len(vertices)]
        _put(vertices[solved], free[solved], self.positions)
        stuck = vertices[~solved]
        _put(stuck, np.ones((len(stuck), 1), bool), as_column(self.stuck))
        for own, values in (
            (solution.multipliers, self.multipliers),
            (solution.active, self.active),
        ):
            _put(grouped.impacts, as_column(own), as_column(values))

    def positions_on_gpu(self, positions, order=None):
        if order is None:
            return to_gpu(positions)
        moved_back = empty((self._n, 3), np.float64)
        kernels.put_rows[self._n](to_gpu(order), self.positions, moved_back)
        return moved_back

    def to_cpu(self):
        seen = None if self._seen is None else to_cpu(self._seen)
        detector = HostDetector(self._detector, seen)
        same = CpuStep(self.scene, self._thickness, self._options, detector)
        same.positions = to_cpu(self.positions)
        same.impacts = impacts_to_cpu(self.impacts)
        same.multipliers, same.active = to_cpu(self.multipliers), to_cpu(self.active)
        same.stuck = to_cpu(self.stuck)
        same.longest = (to_cpu(self.longest[0]), self.longest[1])
        same.n_left = self.n_left
        return same


def _parts_of(starts, members):
    """(n,) i8, the part that each of the members is in."""
    parts = empty(members.shape[0], np.int64)
    kernels.find_blocks[members.shape[0]](starts, parts)
    return parts


def _zones_of(grouped, chosen):
    """`Zones`: those chosen, (n_zones,) b1; None if there are none."""
    index = flatnonzero(chosen)
    if index.shape[0] == 0:
        return None
    if index.shape[0] == len(grouped):
        return grouped
    columns = []
    for members, starts in (grouped[:2], grouped[2:]):
        flags, sizes = empty(members.shape[0], np.bool_), empty(len(grouped), np.int64)
        kernels.flag_members[members.shape[0]](_parts_of(starts, members), chosen, flags)
        kernels.count_members[len(grouped)](starts, sizes)
        columns.append(take(members, flatnonzero(flags)))
        columns.append(offsets_of(take(sizes, index)))
    return Zones(*columns)


def _put(index, rows, values):
    """values[index] = rows, of the processor."""
    kernels.put_rows[len(index)](to_gpu(index), to_gpu(rows), values)
