"""Dual active-set method for one small zone, on an orthonormal basis of its active constraints.

In scaled variables (docs/method section 5) a zone is: minimise 1/2 |z|^2 subject to C z >= s, with
constraints of unit length. The method keeps a set W of active constraints, which hold with
equality. With C_W = L Q, L lower triangular and Q orthonormal (`active_basis.py`), their
multipliers u solve L L^T u = s_W, and z = C_W^T u.

The method starts from no active constraint, or from a guess, and always adds the most violated
constraint. Its multiplier grows until it holds. An active constraint whose multiplier would become
negative on the way becomes inactive. A constraint that depends on the active ones is never added:
it either takes the place of one of them, or shows that nothing satisfies all constraints. So
redundant and duplicated constraints do no harm, and every step increases the dual objective.

The basis makes nearly parallel constraints safe. It gives the distance of a constraint from the
span of the others with an error of a few units of rounding. The Gram matrix alone would give the
square of that distance with this error, so that constraints less than 1e-7 apart would look like
one.

Source: D. Goldfarb, A. Idnani, A numerically stable dual method for solving strictly convex
quadratic programs (1983), section 3.
"""

import numpy as np

from izo_ref.base.arrays import AnyInt, Flags, Floats, Ints, Normals
from izo_ref.base.compile import compiled
from izo_ref.base.serial.views import matrix_of
from izo_ref.solvers.serial.active_basis import (
    append_constraint,
    project,
    remove_constraint,
    solve_lower,
    solve_upper,
)
from izo_ref.solvers.serial.constraints import (
    INFEASIBLE,
    NOT_CONVERGED,
    ROUNDING,
    SOLVED,
    constraint_size,
    pull,
    violations,
)

# Distance of a constraint of unit length from the span of the active ones, below which it counts as
# dependent on them. Where the distance is zero, rounding leaves some 1e-15.
DEPENDENT = 1e-13
# The same for constraints that are guessed to be active. Nearly dependent ones wait for their turn,
# because multipliers of both signs on them would spoil the guess.
GUESSED_DEPENDENT = 1e-6


@compiled
def work_of_active_set(n: int, n_vertices: int) -> tuple[int, int]:
    """Return the work space of a zone of n impacts, in f8 numbers and in i4 indices."""
    size = 3 * n_vertices
    return (n + 1) ** 2 + (min(n, size) + 2) * size + 2 * n, 2 * n


@compiled
def active_set(
    begin: int,
    end: int,
    first: int,
    last: int,
    all_nodes: Ints,
    all_coefficients: Floats,
    all_normals: Normals,
    rhs: Floats,
    stop: Flags,
    numbers: Floats,
    indices: Ints,
    multipliers_out: Floats,
    z_out: Floats,
) -> tuple[int, AnyInt]:
    """Solve the zone of the impacts begin..end and the unknowns first..last.

    Args:
        begin: The zone's first impact.
        end: Its last impact + 1.
        first: The zone's first unknown.
        last: Its last unknown + 1.
        all_nodes: (n_impacts, 4) i4, of all zones; < 0 for pinned vertices.
        all_coefficients: (n_impacts, 4) f8; with the normals, constraints of unit length.
        all_normals: (n_impacts, 3) f8.
        rhs: (n_impacts,) f8, s.
        stop: (1,) b1; no further step begins once it is set.
        numbers: f8, work space; `work_of_active_set` says how much.
        indices: i4, work space; `work_of_active_set` says how much.
        multipliers_out: (n_impacts,) f8, u; begin..end are written. On entry, positive ones are a
            guess of the active constraints.
        z_out: (3 n_unknowns,) f8; the coordinates of first..last are written.

    Returns:
        SOLVED, INFEASIBLE or NOT_CONVERGED, and how many times a constraint became active or
        inactive.
    """
    n, size = end - begin, 3 * (last - first)
    max_steps = 100 + 20 * n
    nodes, coefficients = all_nodes[begin:end], all_coefficients[begin:end]
    normals, s = all_normals[begin:end], rhs[begin:end]
    u = multipliers_out[begin:end]
    at, most = (n + 1) ** 2, min(n, size) + 1
    factor = matrix_of(numbers, n + 1, n + 1)
    basis = matrix_of(numbers[at:], most, size)
    at += most * size
    rest, violation = numbers[at : at + size], numbers[at + size : at + size + n]
    r = numbers[at + size + n : at + size + 2 * n]
    active, is_active = indices[:n], indices[n : 2 * n]
    is_active[:] = 0
    z = z_out[3 * first : 3 * last]
    q = _start(first, nodes, coefficients, normals, s, u, active, is_active, factor, basis, rest, r)
    pull(first, nodes, coefficients, normals, u, z)
    violations(first, nodes, coefficients, normals, s, z, violation)
    _move_onto_active(factor, basis, active, q, violation, r, z)
    violations(first, nodes, coefficients, normals, s, z, violation)
    steps = 0
    while True:
        p = _most_violated(first, nodes, coefficients, s, z, violation, is_active)
        if p < 0:
            for _ in range(2):
                pull(first, nodes, coefficients, normals, u, z)
                violations(first, nodes, coefficients, normals, s, z, violation)
                _refine(factor, active, q, u, violation, r)
            for _ in range(2):
                _move_onto_active(factor, basis, active, q, violation, r, z)
                violations(first, nodes, coefficients, normals, s, z, violation)
            return SOLVED, steps
        added = False
        while not added:
            steps += 1
            if steps > max_steps or stop[0]:
                return NOT_CONVERGED, steps
            distance = project(p, first, nodes, coefficients, normals, basis, q, r, rest)
            for k in range(q):
                factor[q, k] = r[k]
            solve_upper(factor, q, r)
            # u_p may grow by `full` until constraint p holds, or by `step` until another is zero
            full = violation[p] / (distance * distance) if distance > DEPENDENT else np.inf
            step, place = _blocking(active, q, u, r)
            if full == np.inf and place < 0:
                return INFEASIBLE, steps
            step = min(step, full)
            for k in range(q):
                u[active[k]] -= step * r[k]
            u[p] += step
            if step == full:
                # r holds the solution by now; what was projected is in the new row of the factor
                for k in range(q):
                    r[k] = factor[q, k]
                q = append_constraint(p, distance, q, active, is_active, factor, basis, rest, r)
                added = True
            else:
                u[active[place]] = 0.0
                q = remove_constraint(place, q, active, is_active, factor, basis)
            pull(first, nodes, coefficients, normals, u, z)
            violations(first, nodes, coefficients, normals, s, z, violation)
            _move_onto_active(factor, basis, active, q, violation, r, z)
            violations(first, nodes, coefficients, normals, s, z, violation)


@compiled
def _start(
    first: int,
    nodes: Ints,
    coefficients: Floats,
    normals: Normals,
    rhs: Floats,
    u: Floats,
    active: Ints,
    is_active: Ints,
    factor: Floats,
    basis: Floats,
    rest: Floats,
    r: Floats,
) -> AnyInt:
    """Make the guessed constraints active, compute u, and return how many are active.

    Those with u > 0 are guessed. The method can go on from any set whose multipliers are positive,
    so the constraint with the lowest multiplier leaves until all are positive.
    """
    q = np.int64(0)
    for j in range(u.shape[0]):
        if u[j] > 0.0 and q < basis.shape[0] - 1:
            distance = project(j, first, nodes, coefficients, normals, basis, q, r, rest)
            if distance > GUESSED_DEPENDENT:
                q = append_constraint(j, distance, q, active, is_active, factor, basis, rest, r)
    worst = np.int64(0)  # typed, as below: else what it is passed to would be compiled twice
    while q > 0 and worst >= 0:
        for k in range(q):
            r[k] = rhs[active[k]]
        solve_lower(factor, q, r)
        solve_upper(factor, q, r)
        worst = np.int64(-1)
        for k in range(q):
            if r[k] <= 0.0 and (worst < 0 or r[k] < r[worst]):
                worst = k
        if worst >= 0:
            q = remove_constraint(worst, q, active, is_active, factor, basis)
    u[:] = 0.0
    for k in range(q):
        u[active[k]] = r[k]
    return q


@compiled
def _most_violated(
    first: int,
    nodes: Ints,
    coefficients: Floats,
    rhs: Floats,
    z: Floats,
    violation: Floats,
    is_active: Ints,
) -> int:
    """Return the constraint that is violated most, by more than its rounding; -1 if none is."""
    worst = -1
    for j in range(violation.shape[0]):
        if is_active[j] or not violation[j] > 0.0:
            continue
        if worst >= 0 and not violation[j] > violation[worst]:
            continue
        if violation[j] > ROUNDING * constraint_size(j, first, nodes, coefficients, rhs, z):
            worst = j
    return worst


@compiled
def _blocking(active: Ints, q: AnyInt, u: Floats, r: Floats) -> tuple[float, int]:
    """Return how far u can go along -r, and the place of the multiplier that is zero first there.

    The step is infinite and the place is -1 if no multiplier decreases.
    """
    step = np.inf
    place = -1
    for k in range(q):
        if r[k] > 0.0 and u[active[k]] / r[k] < step:
            step = u[active[k]] / r[k]
            place = k
    return step, place


@compiled
def _refine(
    factor: Floats, active: Ints, q: AnyInt, u: Floats, violation: Floats, r: Floats
) -> None:
    """Make one step of iterative refinement of L L^T u = s_W, unless u would become negative."""
    for k in range(q):
        r[k] = violation[active[k]]
    solve_lower(factor, q, r)
    solve_upper(factor, q, r)
    for k in range(q):
        if u[active[k]] + r[k] < 0.0:
            return
    for k in range(q):
        u[active[k]] += r[k]


@compiled
def _move_onto_active(
    factor: Floats,
    basis: Floats,
    active: Ints,
    q: AnyInt,
    violation: Floats,
    r: Floats,
    z: Floats,
) -> None:
    """Make the shortest step of z onto the active constraints: z += Q^T L^-1 (s_W - C_W z).

    C^T u has the rounding of u, which is large where constraints are nearly opposed or parallel.
    After this step, z has only its own rounding.
    """
    for k in range(q):
        r[k] = violation[active[k]]
    solve_lower(factor, q, r)
    for k in range(q):
        for i in range(z.shape[0]):
            z[i] += r[k] * basis[k, i]
