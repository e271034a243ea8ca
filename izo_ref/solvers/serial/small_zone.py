"""Solve one small zone on one thread, and judge the answer.

In scaled variables (docs/method section 5) a zone is: minimise 1/2 |z|^2 subject to C z >= s, with
constraints of unit length and multipliers u >= 0. Three methods solve it:

* The closed form serves zones of one impact.
* Block pivoting (`solvers/serial/block_pivot.py`) is the fastest method for the others. It gives
  up where constraints are nearly dependent.
* The active set (`solvers/serial/active_set.py`) then goes on from the guess that block pivoting
  left. It accepts dependent constraints.

No answer is accepted unchecked. Rounding can make even the active set end far off where
constraints are nearly dependent, so the residuals of the answer decide whether the zone is solved.
"""

import math
from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyInt, Codes, Flags, Floats, Indices, Ints, Normals, Offsets
from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.active_set import active_set, work_of_active_set
from izo_ref.solvers.serial.block_pivot import block_pivot, work_of_block_pivot
from izo_ref.solvers.serial.constraints import SOLVED, add_constraint, residuals

CLOSED_FORM = 0
BLOCK_PIVOT = 1
ACTIVE_SET = 2


class Limits(NamedTuple):
    """Limits that an answer must keep to count as solved."""

    gap: float  # largest relative duality gap
    violation: float  # [m], largest violation
    farthest: float  # largest |z| over the largest rhs; an answer farther off is useless
    stop: Flags  # (1,) b1, zones are left unsolved once it is set


@compiled
def work_of_small_zone(n: int, n_vertices: int) -> tuple[int, int]:
    """Return the work space of a zone of n impacts, in f8 numbers and in i4 indices."""
    of_pivot, of_set = work_of_block_pivot(n, n_vertices), work_of_active_set(n, n_vertices)
    return max(of_pivot[0], of_set[0]), max(of_pivot[1], of_set[1])


@compiled
def choose_small_zones(
    impact_offsets: Offsets, vertex_offsets: Offsets, largest: int, method: int, single: int
) -> tuple[Indices, Codes, int, int, int]:
    """Choose the zones that take one thread each.

    Args:
        impact_offsets: (n_zones + 1,) i8, where the impacts of each zone begin, and the end.
        vertex_offsets: (n_zones + 1,) i8, the same for its unpinned vertices.
        largest: Largest number of impacts of such a zone.
        method: Method to try first for zones of several impacts.
        single: Method for zones of one impact.

    Returns:
        (n,) i8, the zones; (n,) i1, the method to try first for each; how much work they are, where
        a zone of n impacts counts as n (n + 60); and the work space of the largest, in f8 numbers
        and in i4 indices.
    """
    n_zones, n, work, n_numbers, n_indices = impact_offsets.shape[0] - 1, 0, 0, 0, 0
    zones, methods = np.empty(n_zones, np.int64), np.empty(n_zones, np.int8)
    for zone in range(n_zones):
        size = impact_offsets[zone + 1] - impact_offsets[zone]
        if size > largest:
            continue
        zones[n], methods[n] = zone, single if size == 1 else method
        n, work = n + 1, work + size * (size + 60)
        needed = work_of_small_zone(size, vertex_offsets[zone + 1] - vertex_offsets[zone])
        n_numbers, n_indices = max(n_numbers, needed[0]), max(n_indices, needed[1])
    return zones[:n], methods[:n], work, n_numbers, n_indices


@compiled
def solve_small_zone(
    method: int,
    begin: int,
    end: int,
    first: int,
    last: int,
    unknowns: Ints,
    coefficients: Floats,
    normals: Normals,
    rhs: Floats,
    lengths: Floats,
    limits: Limits,
    numbers: Floats,
    indices: Ints,
    multipliers_out: Floats,
    z_out: Floats,
) -> tuple[int, bool, AnyInt]:
    """Solve the zone of the impacts begin..end and the unknowns first..last.

    Args:
        method: Method to begin with: CLOSED_FORM, BLOCK_PIVOT or ACTIVE_SET.
        begin: The zone's first impact.
        end: Its last impact + 1.
        first: The zone's first unknown.
        last: Its last unknown + 1.
        unknowns: (n_impacts, 4) i4, of all zones; < 0 for pinned vertices.
        coefficients: (n_impacts, 4) f8; with the normals, constraints of unit length.
        normals: (n_impacts, 3) f8.
        rhs: (n_impacts,) f8 [m kg^1/2], s.
        lengths: (n_impacts,) f8 [kg^-1/2], of the constraints before scaling.
        limits: What counts as solved.
        numbers: f8, work space; `work_of_small_zone` says how much.
        indices: i4, work space; `work_of_small_zone` says how much.
        multipliers_out: (n_impacts,) f8 [m kg^1/2], u; begin..end are written.
        z_out: (3 n_unknowns,) f8 [m kg^1/2]; the coordinates of first..last are written.

    Returns:
        The method that gave the answer, whether the zone is solved, and the steps of that
        method.
    """
    steps, status = 0, SOLVED
    if method == CLOSED_FORM:
        _solve_single_impact(
            begin, first, last, unknowns, coefficients, normals, rhs, multipliers_out, z_out
        )
        return method, True, steps
    if method == BLOCK_PIVOT:
        status, steps = block_pivot(
            begin,
            end,
            first,
            last,
            unknowns,
            coefficients,
            normals,
            rhs,
            numbers,
            indices,
            multipliers_out,
            z_out,
        )
    else:
        multipliers_out[begin:end] = 0.0
    if method == ACTIVE_SET or status != SOLVED:
        method = ACTIVE_SET
        status, steps = active_set(
            begin,
            end,
            first,
            last,
            unknowns,
            coefficients,
            normals,
            rhs,
            limits.stop,
            numbers,
            indices,
            multipliers_out,
            z_out,
        )
    if status != SOLVED:
        return method, False, steps
    own, z = slice(begin, end), z_out[3 * first : 3 * last]
    violation, gap = residuals(
        first,
        unknowns[own],
        coefficients[own],
        normals[own],
        rhs[own],
        lengths[own],
        multipliers_out[own],
        z,
    )
    holds = violation <= limits.violation and gap <= limits.gap
    return method, holds and _is_near(rhs[own], limits.farthest, z), steps


@compiled
def _solve_single_impact(
    impact: AnyInt,
    first: int,
    last: int,
    unknowns: Ints,
    coefficients: Floats,
    normals: Normals,
    rhs: Floats,
    multipliers_out: Floats,
    z_out: Floats,
) -> None:
    """Solve a zone of one impact: u = max(0, s / K), and K = 1 for a constraint of unit length.

    Source: docs/method section 5.
    """
    multipliers_out[impact] = max(rhs[impact], 0.0)
    z = z_out[3 * first : 3 * last]
    z[:] = 0.0
    add_constraint(multipliers_out[impact], impact, first, unknowns, coefficients, normals, z)


@compiled
def _is_near(rhs: Floats, farthest: float, z: Floats) -> bool:
    """Return whether |z| is at most `farthest` times the largest rhs."""
    largest, z_sq = 0.0, 0.0
    for j in range(rhs.shape[0]):
        largest = max(largest, rhs[j])
    for i in range(z.shape[0]):
        z_sq += z[i] * z[i]
    return math.sqrt(z_sq) <= farthest * largest
