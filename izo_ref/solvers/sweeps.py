"""Projected Gauss-Seidel on a system of zones: scale, launch, scale back."""

import numpy as np

from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.options import Options
from izo_ref.solvers.cpu import zones as kernels
from izo_ref.solvers.scaled_constraints import ScaledConstraints, SystemSolution
from izo_ref.zones.system import ZoneSystem


def sweep(
    system: ZoneSystem,
    options: Options,
    constraints: ScaledConstraints,
    trace: bool = False,
    deadline: Deadline = UNLIMITED,
) -> SystemSolution:
    """Solve every zone by sweeps over its multipliers, in the precision of the options.

    Args:
        system: The zones.
        options: The method, `pgs` or `apgs`, and the tolerances.
        constraints: The constraints of the system in scaled variables.
        trace: Whether to record the objective and the violation of the first zone.
        deadline: When the sweeps have to end.
    """
    n_unpinned, n_zones = system.vertex_offsets[-1], len(system.impact_offsets) - 1
    begin, per_impact = system.impact_offsets[:-1], np.diff(system.impact_offsets)
    # each zone is in units of its largest rhs, so that float32 has its whole range
    largest = np.maximum.reduceat(np.abs(constraints.rhs), begin)
    largest[largest == 0.0] = 1.0  # satisfied to the last bit: any unit will do
    by_impact = np.repeat(largest, per_impact)
    dtype = np.dtype(options.precision)
    z = np.zeros((n_unpinned, 3), dtype)
    multipliers = np.zeros(len(constraints.rhs), dtype)
    steps = np.zeros(n_zones, np.int32)
    traces = np.zeros((n_zones, options.max_steps if trace else 0, 2))
    kernels.solve_sweeps(
        range(n_zones),
        system.impact_offsets,
        system.vertex_offsets,
        constraints.unknowns,
        constraints.coefficients.astype(dtype),
        system.normals.astype(dtype),
        (constraints.rhs / by_impact).astype(dtype),
        by_impact * constraints.lengths,
        options.method == "apgs",
        options.max_steps,
        options.gap_tolerance,
        options.violation_tolerance * system.thickness,
        deadline.stop,
        multipliers,
        z.ravel(),
        steps,
        traces,
    )
    deadline.check()
    displacements = np.zeros_like(system.proposed)
    per_vertex = np.diff(system.vertex_offsets)
    scale = np.repeat(largest, per_vertex) / np.sqrt(system.masses[:n_unpinned])
    displacements[:n_unpinned] = scale[:, None] * z
    multipliers = by_impact / constraints.lengths * multipliers
    return SystemSolution(
        system.proposed + displacements,
        displacements,
        multipliers,
        multipliers > 0.0,
        ~np.logical_or.reduceat(constraints.hopeless, begin),
        steps,
        np.full(n_zones, options.method),
        traces[0, : steps[0]] * (largest[0] ** 2, 1.0) if trace else None,
    )
