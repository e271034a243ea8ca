"""Solve zones on a GPU: small zones one a thread, larger ones one a block."""

import numpy as np

from izo_ref.base.gpu_arrays import empty, flatnonzero, full, last_of, offsets_of, take
from izo_ref.base.options import LAGRANGIAN, Options
from izo_ref.solvers.cuda import zones as kernels
from izo_ref.solvers.gpu_augmented_lagrangian import solve_all
from izo_ref.solvers.gpu_constraints import GpuConstraints, GpuSolution, Members
from izo_ref.solvers.gpu_pivoting import solve_in_blocks
from izo_ref.solvers.interior_point import FARTHEST
from izo_ref.solvers.serial.small_zone import BLOCK_PIVOT, CLOSED_FORM, Limits

# Most impacts of a zone that one thread solves. It takes n^3 operations for n impacts, so with more
# impacts all others would wait for this one thread for long.
SMALL = 32


def solve_zones(
    constraints: GpuConstraints, members: Members, thickness: float, options: Options
) -> GpuSolution:
    """Solve the zones that a GPU can solve.

    Args:
        constraints: The constraints of the zones.
        members: Which zones the impacts and vertices belong to.
        thickness: [m].
        options: The method and the tolerances.

    Returns:
        Solutions of all zones; the entries of unsolved zones are invalid.
    """
    n_zones = constraints.impact_offsets.shape[0] - 1
    solution = GpuSolution(
        full(constraints.rhs.shape[0], 0.0, np.float64),
        full(3 * last_of(constraints.vertex_offsets), 0.0, np.float64),
        full(n_zones, False, np.bool_),
    )
    if options.precision != "float64":
        return solution  # the CPU converts the arrays to float32
    if options.method == "auto" and options.preset is None:
        violation_m = options.violation_tolerance * thickness
        never = full(1, False, np.bool_)
        limits = Limits(options.gap_tolerance, violation_m, FARTHEST, never)
        solve_small(constraints, limits, options, solution)
        solve_in_blocks(constraints, min(SMALL, options.small_zone), limits, solution)
    elif options.method in LAGRANGIAN or options.preset is not None:
        solve_all(constraints, members, thickness, options, solution)
        # Accept the answer of any method that was asked for by name, as the CPU does.
        solution = solution._replace(solved=full(n_zones, True, np.bool_))
    return solution


def solve_small(
    constraints: GpuConstraints, limits: Limits, options: Options, solution: GpuSolution
) -> None:
    """Solve the small zones, one thread and one slot of work space a zone.

    Args:
        constraints: The constraints of all zones.
        limits: What counts as solved, with its array on the GPU.
        options: Its largest small zone, and its rules.
        solution: Its entries of these zones are written.
    """
    n_zones = solution.solved.shape[0]
    methods, small = empty(n_zones, np.int8), empty(n_zones, np.bool_)
    numbers, indices = empty(n_zones, np.int64), empty(n_zones, np.int64)
    offsets = constraints.impact_offsets, constraints.vertex_offsets
    largest = min(SMALL, options.small_zone)
    single = np.int8(CLOSED_FORM if "closed-form" in options.rules else BLOCK_PIVOT)
    kernels.choose_methods[n_zones](*offsets, largest, single, methods, small, numbers, indices)
    zones = flatnonzero(small)
    if zones.shape[0] == 0:
        return
    number_starts, index_starts = (offsets_of(take(counts, zones)) for counts in (numbers, indices))
    kernels.solve_small_zones[zones.shape[0]](
        zones,
        take(methods, zones),
        *constraints,
        limits,
        number_starts,
        index_starts,
        solution.multipliers,
        solution.z,
        methods,
        solution.solved,
        empty(n_zones, np.int32),
        empty(last_of(number_starts), np.float64),
        empty(last_of(index_starts), np.int32),
    )
