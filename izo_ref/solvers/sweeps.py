"""Projected Gauss-Seidel on a system of zones: launch and wrap."""

import numpy as np

from izo_ref.base.options import Options
from izo_ref.solvers.cpu import zones as kernels
from izo_ref.solvers.scaled_constraints import ScaledConstraints, SystemSolution
from izo_ref.zones.system import ZoneSystem


def sweep(
    system: ZoneSystem, options: Options, rows: ScaledConstraints, trace: bool = False
) -> SystemSolution:
    """Sweeps over the multipliers of each zone, in the precision of the options.

    With `trace` the solution has that of the first zone.
    """
    n_free, n_zones = system.vertex_offsets[-1], len(system.impact_offsets) - 1
    begin, per_impact = system.impact_offsets[:-1], np.diff(system.impact_offsets)
    # each zone in units of its largest rhs, so that float32 has its whole range
    largest = np.maximum.reduceat(np.abs(rows.rhs), begin)
    largest[largest == 0.0] = 1.0  # satisfied to the last bit: any unit will do
    by_impact = np.repeat(largest, per_impact)
    dtype = np.dtype(options.precision)
    z, multipliers = np.zeros((n_free, 3), dtype), np.zeros(len(rows.rhs), dtype)
    steps = np.zeros(n_zones, np.int32)
    traces = np.zeros((n_zones, options.max_steps if trace else 0, 2))
    kernels.solve_sweeps(
        system.impact_offsets,
        system.vertex_offsets,
        rows.unknowns,
        rows.coefficients.astype(dtype),
        system.normals.astype(dtype),
        (rows.rhs / by_impact).astype(dtype),
        by_impact * rows.lengths,
        options.method == "apgs",
        options.max_steps,
        options.gap_tolerance,
        options.violation_tolerance * system.thickness,
        multipliers,
        z.ravel(),
        steps,
        traces,
    )
    displacements = np.zeros_like(system.proposed)
    per_vertex = np.diff(system.vertex_offsets)
    scale = np.repeat(largest, per_vertex) / np.sqrt(system.masses[:n_free])
    displacements[:n_free] = scale[:, None] * z
    multipliers = by_impact / rows.lengths * multipliers
    return SystemSolution(
        system.proposed + displacements,
        displacements,
        multipliers,
        multipliers > 0.0,
        ~np.logical_or.reduceat(rows.hopeless, begin),
        steps,
        np.full(n_zones, options.method),
        traces[0, : steps[0]] * (largest[0] ** 2, 1.0) if trace else None,
    )
