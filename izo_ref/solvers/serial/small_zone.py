"""A small zone from its rows to a judged answer, by the first method that gets it right."""

import math
from typing import NamedTuple

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.active_set import active_set, work_of_active_set
from izo_ref.solvers.serial.block_pivot import block_pivot, work_of_block_pivot
from izo_ref.solvers.serial.constraints import SOLVED, add_constraint, residuals

CLOSED_FORM = 0
BLOCK_PIVOT = 1
ACTIVE_SET = 2


class Limits(NamedTuple):
    """What counts as solved."""

    gap: float  # largest relative duality gap
    violation: float  # [m], largest violation
    farthest: float  # |z| over the largest rhs: beyond, a solution is of no use to anybody


@compiled
def _is_near(rhs, farthest, z):
    largest, z_sq = 0.0, 0.0
    for j in range(rhs.shape[0]):
        largest = max(largest, rhs[j])
    for i in range(z.shape[0]):
        z_sq += z[i] * z[i]
    return math.sqrt(z_sq) <= farthest * largest


@compiled
def work_of_small_zone(n, n_vertices):
    """How many numbers and indices of work space a zone of n impacts takes."""
    of_pivot, of_set = work_of_block_pivot(n, n_vertices), work_of_active_set(n, n_vertices)
    return max(of_pivot[0], of_set[0]), max(of_pivot[1], of_set[1])


@compiled
def solve_small_zone(
    method,
    begin,
    end,
    first,
    last,
    unknowns,
    coefficients,
    normals,
    rhs,
    lengths,
    limits,
    numbers,
    indices,
    multipliers_out,
    z_out,
):
    """Solve the zone of impacts begin..end and unknowns first..last.

    One impact alone: u = max(0, s / K), and K = 1 for a unit row. Block pivoting, and where
    that gives up the active set, from its guess. Rounding can make an active set end far
    off where rows are nearly dependent, so the answer is judged.

    Args:
        method: CLOSED_FORM, BLOCK_PIVOT or ACTIVE_SET, where to begin.
        lengths: (n_impacts,) f8 [kg^-1/2], of the rows before scaling.
        limits: `Limits`.
        numbers, indices: f8 and i4, work space of `work_of_small_zone`.
        Others: as of `block_pivot`.

    Returns:
        The method that ended it, whether the zone is solved, and the steps of that method.
    """
    steps, status = 0, SOLVED
    if method == CLOSED_FORM:
        multipliers_out[begin] = max(rhs[begin], 0.0)
        z = z_out[3 * first : 3 * last]
        z[:] = 0.0
        row = slice(begin, end)
        part = unknowns[row], coefficients[row], normals[row]
        add_constraint(multipliers_out[begin], np.int64(0), first, *part, z)
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
            numbers,
            indices,
            multipliers_out,
            z_out,
        )
    if status != SOLVED:
        return method, False, steps
    rows, z = slice(begin, end), z_out[3 * first : 3 * last]
    violation, gap = residuals(
        first,
        unknowns[rows],
        coefficients[rows],
        normals[rows],
        rhs[rows],
        lengths[rows],
        multipliers_out[rows],
        z,
    )
    holds = violation <= limits.violation and gap <= limits.gap
    return method, holds and _is_near(rhs[rows], limits.farthest, z), steps
