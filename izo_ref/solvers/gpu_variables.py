"""Zones of the loop in the variables of the augmented-Lagrangian methods, and answers back.

`augmented_lagrangian.py` is the same on the CPU; of zones side by side some are chosen.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.cuda.thread_group import shared_bytes
from izo_ref.base.gpu_arrays import (
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
from izo_ref.solvers.augmented_lagrangian import MEMORY, Inputs
from izo_ref.solvers.cuda import variables as kernels
from izo_ref.solvers.presets import METHOD_PARAMETERS, PRESETS, choose_settings


class Members(NamedTuple):
    """Whose the impacts and vertices of the zones are, on the device."""

    zone_of_impact: np.ndarray  # (n_impacts,) i8
    zone_of_vertex: np.ndarray  # (n_free,) i8
    vertices: np.ndarray  # (n_free,) i8, which of the scene's
    inverse_sqrt_masses: np.ndarray  # (n_vertices,) f8 [kg^-1/2], 0 for pinned


class Variables:
    """What x and l mean.

    Args:
        rows: `Rows`.
        members: `Members`.
        chosen: (n_zones,) b1.
        zones: (n,) i8, the same.
        thickness: [m].
        options: `Options`.
        n_threads: of a block, for what is summed over a zone.

    Attributes:
        inputs: `Inputs` of the kernels that solve.
    """

    def __init__(self, rows, members, chosen, zones, thickness, options, n_threads):
        self._rows, self._members, self._chosen = rows, members, chosen
        self._options, self._preset = options, PRESETS.get(options.preset)
        self._kind, self._zones = _kind_of(self._preset), zones
        self._n = chosen.shape[0]
        self._n_padded = last_of(rows.vertex_offsets) + self._n
        self._in_blocks = (self._zones.shape[0], n_threads, shared_bytes(n_threads))
        self._scales, first_steps = self._of_zones()
        nodes, coefficients, starts, metres, is_entry = self._of_rows()
        entries, entry_starts = self._by_vertex(flatnonzero(is_entry))
        settings, n = choose_settings(options, thickness), self._n
        mus, caps = self._penalties(settings, nodes, coefficients, entries, entry_starts)
        row_offsets, memory_offsets = empty(n + 1, np.int64), empty(n + 1, np.int64)
        memory = MEMORY.get(settings.direction, (0, 0))
        kernels.find_zone_offsets[n + 1](rows.vertex_offsets, *memory, row_offsets, memory_offsets)
        self.inputs = Inputs(
            self._zones,
            rows.impact_offsets,
            row_offsets,
            memory_offsets,
            nodes,
            coefficients,
            *self._arms(entries, coefficients),
            entry_starts,
            rows.normals,
            starts,
            metres,
            self._curvatures(),
            to_gpu(mus),
            to_gpu(caps),
            first_steps,
            self._scales,  # for units, of a trace that is not asked for
            settings,
        )

    def _of_zones(self):
        scales, first_steps = (full(self._n, 1.0, np.float64) for _ in range(2))
        preset, rows = self._preset, self._rows
        steps = (1.0, 0.0) if preset is None else (preset.step, preset.step_per_vertex)
        kernels.scale_zones.in_blocks(*self._in_blocks)(
            self._zones,
            rows.impact_offsets,
            rows.vertex_offsets,
            *self._members[2:],
            rows.rhs,
            self._kind,
            *steps,
            scales,
            first_steps,
        )
        return scales, first_steps

    def _of_rows(self):
        rows, m = self._rows, self._rows.rhs.shape[0]
        scaled = (
            empty((m, 4), np.uint32),
            copy(rows.coefficients),
            empty(m, np.float64),
            empty(m, np.float64),
            empty(4 * m, np.bool_),
        )
        kernels.scale_rows[m](
            self._members.zone_of_impact,
            rows.vertex_offsets,
            *self._members[2:],
            self._scales,
            self._kind,
            self._chosen,
            rows.unknowns,
            rows.rhs,
            rows.lengths,
            *scaled,
        )
        return scaled

    def _by_vertex(self, entries):
        """Entries, 4 j + k, by vertex; and where those of each vertex begin."""
        n = entries.shape[0]
        vertices, starts = empty(n, np.int64), empty(self._n_padded + 1, np.uint64)
        zone_of_impact, unknowns = self._members.zone_of_impact, self._rows.unknowns
        kernels.find_entry_vertices[n](entries, zone_of_impact, unknowns, vertices)
        order = stable_argsort(vertices)
        kernels.find_vertex_starts[self._n_padded + 1](take(vertices, order), starts)
        return take(entries, order), starts

    def _arms(self, entries, coefficients):
        n, rows = entries.shape[0], self._rows
        own, arms = empty(n, np.uint32), empty((n, 3), np.float64)
        zone_of, offsets = self._members.zone_of_impact, rows.impact_offsets
        kernels.compute_arms[n](entries, zone_of, offsets, coefficients, rows.normals, own, arms)
        return own, arms

    def _curvatures(self):
        curvatures = full(3 * self._n_padded, 1.0, np.float64)
        if self._preset is not None:
            _, zone_of, *of_vertices = self._members
            kernels.compute_curvatures[zone_of.shape[0]](
                zone_of, *of_vertices, self._scales, curvatures
            )
        return curvatures

    def _penalties(self, settings, nodes, coefficients, entries, entry_starts):
        """(mu, largest mu) of each zone, on the processor."""
        if self._preset is not None:
            mus = np.full(self._n, self._preset.mu)
            return mus, mus
        coupling = np.ones(self._n)
        if settings.every_step:
            sizes, bounds = empty(self._n_padded, np.float64), full(self._n, 1.0, np.float64)
            kernels.sum_sizes_on_vertices[self._n_padded](
                entries, entry_starts, coefficients, sizes
            )
            offsets = self._rows.impact_offsets, self._rows.vertex_offsets
            kernels.bound_couplings.in_blocks(*self._in_blocks)(
                self._zones, *offsets, nodes, coefficients, sizes, bounds
            )
            coupling = to_cpu(bounds)
        return METHOD_PARAMETERS[self._options.method].penalties(self._options, coupling)

    def take_answers(self, results, solution):
        """Write x and l of the chosen zones to a `Solution`, in the loop's variables."""
        members = self._members
        n_most = max(members.zone_of_impact.shape[0], members.zone_of_vertex.shape[0])
        answers = results.x, results.multipliers
        of_zones = self._scales, self._kind
        kernels.take_answers[n_most](
            self._chosen, *members, self._rows.lengths, *of_zones, *answers, *solution[:2]
        )


def _kind_of(preset):
    if preset is None:
        return kernels.SCALED
    return kernels.BY_TOTAL_MASS if preset.by_total_mass else kernels.BY_MEAN_INVERSE
