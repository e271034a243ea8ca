"""Zones of the loop in the variables of the augmented-Lagrangian methods, on a GPU, and back.

`solvers/variables.py` does the same on the CPU. Here the arrays hold all zones side by side.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Floats, GpuArray
from izo_ref.base.cuda.thread_group import shared_bytes
from izo_ref.base.gpu_arrays import (
    arange,
    copy,
    empty,
    flatnonzero,
    full,
    last_of,
    stable_argsort,
    take,
    to_cpu,
    to_gpu,
)
from izo_ref.base.options import Options
from izo_ref.solvers.cuda import variables as kernels
from izo_ref.solvers.gpu_constraints import GpuConstraints, GpuSolution, Members
from izo_ref.solvers.presets import METHOD_PARAMETERS, Preset, choose_settings, preset_of
from izo_ref.solvers.serial.records import Inputs, Results
from izo_ref.solvers.serial.settings import Settings
from izo_ref.solvers.variables import MEMORY


class _Converted(NamedTuple):
    """Constraints in the variables of the solver."""

    nodes: GpuArray  # (n_impacts, 4) u4
    coefficients: GpuArray  # (n_impacts, 4) f8
    starts: GpuArray  # (n_impacts,) f8
    metres: GpuArray  # (n_impacts,) f8 [m]
    is_entry: GpuArray  # (4 n_impacts,) b1


class VariablesOnGpu:
    """The variables of the solver for all zones, and the way back to scaled variables.

    Args:
        constraints: The constraints of all zones.
        members: Which zones the impacts and vertices belong to.
        thickness: [m].
        options: An augmented-Lagrangian method or a preset, and the tolerances.
        n_threads: Threads of a block, for sums over a zone.

    Attributes:
        inputs: The inputs of the kernels that solve.
        settings: Parameters of the loop.
    """

    def __init__(
        self,
        constraints: GpuConstraints,
        members: Members,
        thickness: float,
        options: Options,
        n_threads: int,
    ) -> None:
        """Convert the constraints and choose the parameters."""
        self._constraints, self._members = constraints, members
        self._options, self._preset = options, preset_of(options)
        self._kind = _kind_of(self._preset)
        self._n = constraints.impact_offsets.shape[0] - 1
        self._zones = arange(self._n)
        self._n_padded = last_of(constraints.vertex_offsets) + self._n
        self._in_blocks = (self._n, n_threads, shared_bytes(n_threads))
        self._scales, first_steps = self._scale_zones()
        converted = self._convert_constraints()
        entries, entry_starts = self._sort_entries(flatnonzero(converted.is_entry))
        self.settings = settings = choose_settings(options, thickness)
        mus, caps = self._penalties(settings, converted, entries, entry_starts)
        unknown_offsets, memory_offsets = self._find_offsets(settings)
        own_impacts, arms = self._compute_arms(entries, converted.coefficients)
        self.inputs = Inputs(
            zones=self._zones,
            impact_offsets=constraints.impact_offsets,
            unknown_offsets=unknown_offsets,
            memory_offsets=memory_offsets,
            nodes=converted.nodes,
            coefficients=converted.coefficients,
            entries=own_impacts,
            arms=arms,
            entry_starts=entry_starts,
            normals=constraints.normals,
            starts=converted.starts,
            metres=converted.metres,
            curvatures=self._compute_curvatures(),
            mus=to_gpu(mus),
            mu_caps=to_gpu(caps),
            first_steps=first_steps,
            units=self._scales,  # not used, because no trace is recorded
        )

    def _scale_zones(self) -> tuple[GpuArray, GpuArray]:
        """Return the scale of the variables and the first step of each zone, (n_zones,) f8."""
        scales, first_steps = (full(self._n, 1.0, np.float64) for _ in range(2))
        preset, constraints = self._preset, self._constraints
        steps = (1.0, 0.0) if preset is None else (preset.step, preset.step_per_vertex)
        kernels.scale_zones.in_blocks(*self._in_blocks)(
            self._zones,
            constraints.impact_offsets,
            constraints.vertex_offsets,
            *self._members[2:],
            constraints.rhs,
            self._kind,
            *steps,
            scales,
            first_steps,
        )
        return scales, first_steps

    def _convert_constraints(self) -> _Converted:
        """Return the constraints in the variables of the solver."""
        constraints, m = self._constraints, self._constraints.rhs.shape[0]
        converted = _Converted(
            empty((m, 4), np.uint32),
            copy(constraints.coefficients),
            empty(m, np.float64),
            empty(m, np.float64),
            empty(4 * m, np.bool_),
        )
        kernels.convert_constraints[m](
            self._members.zone_of_impact,
            constraints.vertex_offsets,
            *self._members[2:],
            self._scales,
            self._kind,
            constraints.unknowns,
            constraints.rhs,
            constraints.lengths,
            *converted,
        )
        return converted

    def _sort_entries(self, entries: GpuArray) -> tuple[GpuArray, GpuArray]:
        """Return the entries, 4 j + k, vertex by vertex, and where those of each vertex begin."""
        n = entries.shape[0]
        vertices, starts = empty(n, np.int64), empty(self._n_padded + 1, np.uint64)
        zone_of_impact, unknowns = self._members.zone_of_impact, self._constraints.unknowns
        kernels.find_entry_vertices[n](entries, zone_of_impact, unknowns, vertices)
        order = stable_argsort(vertices)
        kernels.find_vertex_starts[self._n_padded + 1](take(vertices, order), starts)
        return take(entries, order), starts

    def _find_offsets(self, settings: Settings) -> tuple[GpuArray, GpuArray]:
        """Return where x and the memory of each zone begin, (n_zones + 1,) i8."""
        n = self._n
        unknown_offsets, memory_offsets = empty(n + 1, np.int64), empty(n + 1, np.int64)
        memory, offsets = MEMORY.get(settings.direction, (0, 0)), self._constraints.vertex_offsets
        kernels.find_zone_offsets[n + 1](offsets, *memory, unknown_offsets, memory_offsets)
        return unknown_offsets, memory_offsets

    def _compute_arms(self, entries: GpuArray, coefficients: GpuArray) -> tuple[GpuArray, GpuArray]:
        """Return the impact's number in its zone, and coefficient times normal, of each entry."""
        n, constraints = entries.shape[0], self._constraints
        own, arms = empty(n, np.uint32), empty((n, 3), np.float64)
        zone_of, offsets = self._members.zone_of_impact, constraints.impact_offsets
        kernels.compute_arms[n](
            entries, zone_of, offsets, coefficients, constraints.normals, own, arms
        )
        return own, arms

    def _compute_curvatures(self) -> GpuArray:
        """Return the curvatures w, (n_unknowns,) f8."""
        curvatures = full(3 * self._n_padded, 1.0, np.float64)
        if self._preset is not None:
            _, zone_of, *of_vertices = self._members
            kernels.compute_curvatures[zone_of.shape[0]](
                zone_of, *of_vertices, self._scales, curvatures
            )
        return curvatures

    def _penalties(
        self, settings: Settings, converted: _Converted, entries: GpuArray, entry_starts: GpuArray
    ) -> tuple[Floats, Floats]:
        """Return mu at the start and the largest mu of each zone, on the CPU."""
        if self._preset is not None:
            mus = np.full(self._n, self._preset.mu)
            return mus, mus
        coupling = np.ones(self._n)
        if settings.every_step:
            sizes, bounds = empty(self._n_padded, np.float64), full(self._n, 1.0, np.float64)
            kernels.sum_sizes_on_vertices[self._n_padded](
                entries, entry_starts, converted.coefficients, sizes
            )
            offsets = self._constraints.impact_offsets, self._constraints.vertex_offsets
            kernels.bound_couplings.in_blocks(*self._in_blocks)(
                self._zones, *offsets, converted.nodes, converted.coefficients, sizes, bounds
            )
            coupling = to_cpu(bounds)
        return METHOD_PARAMETERS[self._options.method].penalties(self._options, coupling)

    def take_answers(self, results: Results, solution: GpuSolution) -> None:
        """Write the answers to a solution, in scaled variables.

        Args:
            results: What the kernels have written.
            solution: `multipliers` and `z` are written.
        """
        members = self._members
        n_most = max(members.zone_of_impact.shape[0], members.zone_of_vertex.shape[0])
        answers = results.x, results.multipliers
        kernels.take_answers[n_most](
            *members,
            self._constraints.lengths,
            self._scales,
            self._kind,
            *answers,
            *solution[:2],
        )


def _kind_of(preset: Preset | None) -> int:
    """Return the code of the variables of a method (None) or of a preset."""
    if preset is None:
        return kernels.SCALED
    return kernels.BY_TOTAL_MASS if preset.by_total_mass else kernels.BY_MEAN_INVERSE
