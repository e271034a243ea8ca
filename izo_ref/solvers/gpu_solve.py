"""Zones solved on the device: small ones one a thread, others by the threads of blocks."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from izo_ref.base.gpu_arrays import arange, empty, flatnonzero, full, last_of, offsets_of, take
from izo_ref.base.options import LAGRANGIAN, Options
from izo_ref.solvers.cuda import zones as kernels
from izo_ref.solvers.gpu_augmented_lagrangian import MOST, flag_zones_of_size, solve_chosen
from izo_ref.solvers.gpu_variables import Members
from izo_ref.solvers.interior_point import FARTHEST
from izo_ref.solvers.presets import GPU_METHOD
from izo_ref.solvers.serial.small_zone import BLOCK_PIVOT, CLOSED_FORM, Limits

# Impacts of a zone that one thread solves: with more, it would be alone for long with what has
# the cube of them as operations.
SMALL = 32


class Rows(NamedTuple):
    """Zones side by side in scaled variables (SPEC section 5), on the device."""

    impact_offsets: np.ndarray  # (n_zones + 1,) i8
    vertex_offsets: np.ndarray  # (n_zones + 1,) i8, unpinned vertices
    unknowns: np.ndarray  # (n_impacts, 4) i4, vertices of the zones; -1 for pinned
    coefficients: np.ndarray  # (n_impacts, 4) f8
    normals: np.ndarray  # (n_impacts, 3) f8
    rhs: np.ndarray  # (n_impacts,) f8 [m kg^1/2]
    lengths: np.ndarray  # (n_impacts,) f8 [kg^-1/2], of the rows before scaling


class Solution(NamedTuple):
    """Of all zones, on the device; of those that are not solved, nothing is to be used."""

    multipliers: np.ndarray  # (n_impacts,) f8 [m kg^1/2], of the unit rows
    z: np.ndarray  # (3 n_vertices,) f8 [m kg^1/2]
    solved: np.ndarray  # (n_zones,) b1


def solve_zones(rows: Rows, members: Members, thickness: float, options: Options) -> Solution:
    """Solve what the device can solve.

    Args:
        rows: `Rows`.
        members: `Members` of the zones.
        thickness: [m].
        options: `Options`.
    """
    n_zones = rows.impact_offsets.shape[0] - 1
    solution = Solution(
        full(rows.rhs.shape[0], 0.0, np.float64),
        full(3 * last_of(rows.vertex_offsets), 0.0, np.float64),
        full(n_zones, False, np.bool_),
    )
    if options.precision != "float64":
        return solution  # the processor makes its numbers
    if options.method == "auto" and options.preset is None:
        _solve_small(rows, thickness, options, n_zones, solution)
        others = flag_zones_of_size(arange(n_zones), rows.impact_offsets, SMALL, MOST)
        solve_chosen(rows, members, others, thickness, replace(options, **GPU_METHOD), solution)
    elif options.method in LAGRANGIAN or options.preset is not None:
        everything = full(n_zones, True, np.bool_)
        solve_chosen(rows, members, everything, thickness, options, solution)
        # what another method than the default comes to is taken, as on the processor
        solution = solution._replace(solved=everything)
    return solution


def _solve_small(rows, thickness, options, n_zones, solution):
    methods, small = empty(n_zones, np.int8), empty(n_zones, np.bool_)
    numbers, indices = empty(n_zones, np.int64), empty(n_zones, np.int64)
    offsets = rows.impact_offsets, rows.vertex_offsets
    largest = min(SMALL, options.small_zone)
    single = np.int8(CLOSED_FORM if "closed-form" in options.rules else BLOCK_PIVOT)
    kernels.choose_methods[n_zones](*offsets, largest, single, methods, small, numbers, indices)
    zones = flatnonzero(small)
    if zones.shape[0] == 0:
        return
    # a slot each
    number_starts, index_starts = (offsets_of(take(counts, zones)) for counts in (numbers, indices))
    violation_m = options.violation_tolerance * thickness
    kernels.solve_small_zones[zones.shape[0]](
        zones,
        take(methods, zones),
        *rows,
        Limits(options.gap_tolerance, violation_m, FARTHEST),
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
