"""The augmented-Lagrangian methods on the device, one zone a block."""

from typing import NamedTuple

import numpy as np

from izo_ref.cuda import lagrangian as kernels
from izo_ref.cuda.team import PARTS, WARP, shared_bytes
from izo_ref.descent import MEMORY, Inputs, Results, work_space
from izo_ref.gpu.arrays import (
    copied,
    empty,
    filled,
    indices_of,
    on_device,
    on_host,
    order_of,
    take,
    total_of,
    zeros,
)
from izo_ref.gpu.device import blocks_at_once
from izo_ref.methods import METHODS, PRESETS, chosen_settings

# Threads of a block: for zones of a few impacts, and for others. More than 256 would leave each
# fewer registers than the kernel has.
FEW, MANY = WARP, 256
# Impacts of a zone that one block solves, in float64: with more, each of its threads would have
# many rows, while a wait of all blocks takes as long as some of them.
LARGE = 4096
MOST = np.iinfo(np.int64).max
# For zones that one thread is too slow for: of the methods here the one that comes to 1e-9 on all
# families but one (reports/inner.html), in 4 to 88 steps.
NEWTON = {
    "method": "newton",
    "line_search": "exact",
    "multiplier_update": "inner-solve",
    "penalty": "grown",
    "max_steps": 200,
}


class Members(NamedTuple):
    """Whose the impacts and vertices of zones side by side are, on the device."""

    zone_of_impact: np.ndarray  # (n_impacts,) i8
    zone_of_vertex: np.ndarray  # (n_free,) i8
    vertices: np.ndarray  # (n_free,) i8, which of the scene's
    inverse_sqrt_masses: np.ndarray  # (n_vertices,) f8 [kg^-1/2], 0 for pinned


def solve_on_device(inputs: Inputs, results: Results, n_threads: int, timed=lambda call: call()):
    """Run the kernels on arrays of the device: a block a zone, or all blocks if it is large.

    `timed` makes the call that runs them; what it returns is returned.
    """
    is_double = inputs.curvatures.dtype == np.float64
    most = LARGE if is_double else MOST
    offsets, bounds = inputs.impact_offsets, ((0, most), (most, MOST))
    small, large = (
        take(inputs.zones, indices_of(zones_of_size(inputs.zones, offsets, *sizes)))
        for sizes in bounds
    )
    inputs, n_memory = inputs._replace(zones=small), total_of(inputs.memory_offsets)
    *shared, states = (zeros(*array) for array in work_space(inputs, n_memory, n_threads))
    n_blocks, n_bytes = blocks_at_once(), shared_bytes(n_threads)
    in_blocks = kernels.solve_lagrangian.in_blocks(small.shape[0], n_threads, n_bytes)
    by_grid = kernels.solve_lagrangian_by_grid.in_blocks(n_blocks, n_threads, n_bytes)

    def run():
        in_blocks(*inputs, *results, *shared, states)
        for i in range(large.shape[0]):
            one = inputs._replace(zones=large[i : i + 1])
            *_, own = work_space(one, n_memory, n_blocks * n_threads)
            parts = zeros((n_blocks, PARTS), np.float64)
            by_grid(*one, *results, *shared, zeros(*own), parts)

    return timed(run)


def zones_of_size(zones, impact_offsets, more_than, at_most):
    """(n,) b1, which of the zones have more impacts than one number, and at most another."""
    n = zones.shape[0]
    flags = empty(n, np.bool_)
    kernels.zones_of_size[n](zones, impact_offsets, more_than, at_most, flags)
    return flags


def solve_rows(rows, members, chosen, thickness, options, solution):
    """Solve some of the zones, and judge which are solved.

    Args:
        rows: `Rows`, of the device.
        members: `Members` of the zones.
        chosen: (n_zones,) b1, those to solve.
        thickness: [m].
        options: `Options`, with one of the methods here, or a preset.
        solution: `Solution`, written.
    """
    n_zones, zones, preset = chosen.shape[0], indices_of(chosen), PRESETS.get(options.preset)
    variables = kernels.SCALED
    if preset is not None:
        by_total = preset.by_total_mass
        variables = kernels.BY_TOTAL_MASS if by_total else kernels.BY_MEAN_INVERSE
    inputs, scales = _inputs(rows, members, zones, chosen, variables, thickness, options)
    results = Results(
        zeros((inputs.curvatures.shape[0],), np.float64),
        zeros((rows.rhs.shape[0],), np.float64),
        *(empty(n_zones, dtype) for dtype in (np.int32, np.float64, np.float64)),
        empty((n_zones, 0, 2), np.float64),
    )
    solve_on_device(inputs, results, MANY)
    n_most = max(members.zone_of_impact.shape[0], members.zone_of_vertex.shape[0])
    answers = results.x, results.multipliers
    kernels.take_answers[n_most](
        chosen, *members, rows.lengths, scales, variables, *answers, *solution[:2]
    )
    tolerances = options.gap_tolerance, options.violation_tolerance * thickness
    kernels.judge_zones[zones.shape[0]](
        zones, results.gaps, results.violations, *tolerances, solution.solved
    )


def _inputs(rows, members, zones, chosen, variables, thickness, options):
    """`Inputs` in the variables, and their scales by zone."""
    n, m, in_blocks = chosen.shape[0], rows.rhs.shape[0], (zones.shape[0], MANY, shared_bytes(MANY))
    n_padded, preset = total_of(rows.vertex_offsets) + n, PRESETS.get(options.preset)
    settings, zone_of_impact = chosen_settings(options, thickness), members.zone_of_impact
    scales, first_steps = filled(n, 1.0, np.float64), filled(n, 1.0, np.float64)
    steps = (1.0, 0.0) if preset is None else (preset.step, preset.step_per_vertex)
    of_vertices = members.vertices, members.inverse_sqrt_masses
    kernels.zone_variables.in_blocks(*in_blocks)(
        zones,
        rows.impact_offsets,
        rows.vertex_offsets,
        *of_vertices,
        rows.rhs,
        variables,
        *steps,
        scales,
        first_steps,
    )
    nodes, coefficients = empty((m, 4), np.uint32), copied(rows.coefficients)
    starts, metres = empty(m, np.float64), empty(m, np.float64)
    is_entry, curvatures = empty(4 * m, np.bool_), filled(3 * n_padded, 1.0, np.float64)
    kernels.scale_rows[m](
        zone_of_impact,
        rows.vertex_offsets,
        *of_vertices,
        scales,
        variables,
        chosen,
        rows.unknowns,
        rows.rhs,
        rows.lengths,
        nodes,
        coefficients,
        starts,
        metres,
        is_entry,
    )
    if preset is not None:
        kernels.curvatures_in_metres[members.vertices.shape[0]](
            members.zone_of_vertex, *of_vertices, scales, curvatures
        )
    entries = indices_of(is_entry)
    n_entries = entries.shape[0]
    vertices = empty(n_entries, np.int64)
    kernels.vertices_of_entries[n_entries](entries, zone_of_impact, rows.unknowns, vertices)
    order = order_of(vertices)
    entries, vertices = take(entries, order), take(vertices, order)
    own, arms = empty(n_entries, np.uint32), empty((n_entries, 3), np.float64)
    kernels.arms_of_entries[n_entries](
        entries, zone_of_impact, rows.impact_offsets, coefficients, rows.normals, own, arms
    )
    entry_starts = empty(n_padded + 1, np.uint64)
    kernels.starts_of_vertices[n_padded + 1](vertices, entry_starts)
    row_offsets, memory_offsets = empty(n + 1, np.int64), empty(n + 1, np.int64)
    memory = MEMORY.get(settings.direction, (0, 0))
    kernels.offsets_of_zones[n + 1](rows.vertex_offsets, *memory, row_offsets, memory_offsets)
    if preset is not None:
        mus = caps = np.full(n, preset.mu)
    else:
        coupling = np.ones(n)
        if settings.every_step:
            sizes, bounds = empty(n_padded, np.float64), filled(n, 1.0, np.float64)
            kernels.sizes_on_vertices[n_padded](entries, entry_starts, coefficients, sizes)
            kernels.couplings.in_blocks(*in_blocks)(
                zones, rows.impact_offsets, rows.vertex_offsets, nodes, coefficients, sizes, bounds
            )
            coupling = on_host(bounds)
        mus, caps = METHODS[options.method].penalties(options, coupling)
    inputs = Inputs(
        zones,
        rows.impact_offsets,
        row_offsets,
        memory_offsets,
        nodes,
        coefficients,
        own,
        arms,
        entry_starts,
        rows.normals,
        starts,
        metres,
        curvatures,
        on_device(mus),
        on_device(caps),
        first_steps,
        scales,  # for units, of a trace that is not asked for
        settings,
    )
    return inputs, scales


def solve_lagrangian(inputs: Inputs, results: Results, timed=lambda call: call()):
    """The same on arrays of the processor, called as the processor's own is."""
    own = Inputs(*(on_device(column) for column in inputs[:-1]), inputs.settings)
    device_results = Results(*(on_device(column) for column in results))
    largest = np.diff(inputs.impact_offsets).max()
    n_threads = FEW if largest <= FEW else MANY
    said = solve_on_device(own, device_results, n_threads, timed)
    for result, array in zip(results, device_results, strict=True):
        result[...] = on_host(array)
    return said
