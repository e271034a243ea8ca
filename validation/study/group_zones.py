"""What a thread group does to solve a zone: solves, waits and operations, counted on the CPU."""

import math
from typing import NamedTuple

import numpy as np

from izo_ref import Options
from izo_ref.base.serial.group_sort import RUN
from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.interior_point import FARTHEST
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial.envelope import SIDE, count_tiles, dense_tiles
from izo_ref.solvers.serial.group_guess import GUESS_STEPS
from izo_ref.solvers.serial.group_memory import memory_of, work_of_group_pivot
from izo_ref.solvers.serial.group_pivot import group_pivot
from izo_ref.solvers.serial.small_zone import Limits
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.system import problem_system

# Waits of a solve beside those of its factor: three number the active constraints, two write the
# matrix, one the right-hand side, one ends the triangular solves, two give u and z, one counts what
# is on the wrong side, and three let constraints change sides.
WAITS_OF_A_SOLVE = 13


class GroupZone(NamedTuple):
    """What a group does to solve a zone without a last solution."""

    impacts: int
    active: int  # at the solution
    solves: int
    tile_rows: int  # of the last factor
    tiles: int
    operations: float  # of one factor, in float64
    solved: bool


def solve_by_one(problem: ZoneProblem) -> GroupZone:
    """Solve a zone by a group of one thread, and return what it did."""
    system, _ = problem_system([problem])
    rows, n, n_vertices = scale_constraints(system), len(problem.nodes), system.vertex_offsets[1]
    options = Options()
    violation_m = options.violation_tolerance * problem.thickness
    limits = Limits(options.gap_tolerance, violation_m, FARTHEST, np.zeros(1, bool))
    n_numbers, n_indices = work_of_group_pivot(n, n_vertices, dense_tiles(n))
    numbers, indices = np.zeros(n_numbers), np.zeros(n_indices, np.int32)
    u, z = np.zeros(n), np.zeros(3 * n_vertices)
    own = rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths
    more = system.proposed[:n_vertices], limits, np.empty(0), numbers, indices, u, z
    solved, solves = group_pivot(ALONE, 0, n, 0, n_vertices, *own, *more)
    memory = memory_of(n, n_vertices, numbers, indices[n_vertices + 4 * n :])
    active = int(np.count_nonzero(u))
    tile_rows = count_tiles(active)
    below = memory.lasts_of_tiles[:tile_rows] - np.arange(tile_rows)  # tiles of each tile column
    # a square off the diagonal, and half of one on it, in each product, solution and factor
    products = below * (below - 1) + below
    operations = SIDE**3 * float((products + below + 1.0 / 3.0).sum())
    tiles = int(memory.starts[tile_rows])
    return GroupZone(n, active, solves, tile_rows, tiles, operations, solved)


def count_waits(own: GroupZone) -> int:
    """Return how often all threads of a group wait to solve a zone, at most.

    All factors count as the last one, which is one of the largest.
    """
    passes = max(math.ceil(math.log2(own.impacts / RUN)), 0)
    before = 2 + 3 + 1 + (1 + passes) + 1 + (2 + 2 * GUESS_STEPS)
    of_tiles = 1 + 2 * (own.tile_rows - 1)
    return before + own.solves * (WAITS_OF_A_SOLVE + of_tiles) + 3
