"""Solve the zones of a system on a GPU, by the launches of a step."""

from __future__ import annotations

from typing import Any

import numpy as np

from izo_ref.base.arrays import Multipliers
from izo_ref.base.cuda.program import Program
from izo_ref.base.gpu_arrays import overwrite, to_cpu, to_gpu
from izo_ref.base.options import Options
from izo_ref.solvers.gpu_solve import ZoneSolver
from izo_ref.solvers.scaled_constraints import ScaledConstraints
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers, ZoneRows
from izo_ref.zones.system import ZoneSystem


def solver_of_system(
    system: ZoneSystem, options: Options, constraints: ScaledConstraints
) -> ZoneSolver:
    """Return a solver whose rows are the constraints of a system."""
    n_zones, n = len(system.vertex_offsets) - 1, int(system.vertex_offsets[-1])
    solver = ZoneSolver(n, system.thickness, options, (n_zones, len(system.nodes), n))
    own = constraints.unknowns, constraints.coefficients, system.normals
    overwrite(solver.rows, ZoneRows(*own, *constraints[2:], system.proposed[:n]))
    return solver


def solve_on_gpu(
    system: ZoneSystem,
    options: Options,
    constraints: ScaledConstraints,
    start: Multipliers | None = None,
) -> ZoneAnswers:
    """Solve the zones of a system by block pivoting, as in a step.

    Args:
        system: The zones.
        options: The tolerances.
        constraints: The constraints of the system.
        start: (n_impacts,) f8 [kg], multipliers of the last solution; None if there is none.

    Returns:
        The answers, on the CPU; those of unsolved zones are invalid.
    """
    solver: Any = solver_of_system(system, options, constraints)
    n = np.diff(system.impact_offsets)
    lists = [
        np.flatnonzero(n <= solver.most_small),
        np.flatnonzero((n > solver.most_small) & (n <= solver.most_middle)),
        np.flatnonzero(n > solver.most_middle),
    ]
    sizes = np.zeros(at.N_SIZES, np.int64)
    sizes[[at.SMALL, at.MIDDLE, at.LARGE]] = list(map(len, lists))
    solver.sizes.copy_to_device(sizes)
    last = np.zeros(len(system.nodes)) if start is None else start * constraints.lengths
    solver.answers.multipliers.copy_to_device(last)
    offsets = to_gpu(system.impact_offsets), to_gpu(system.vertex_offsets)
    Program(solver.launches_of_lists(*map(to_gpu, lists), *offsets)).run()
    return to_cpu(solver.answers)
