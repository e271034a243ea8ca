"""Block principal pivoting for one zone: the fast method for constraints far from dependent.

In scaled variables (docs/method section 5) the multipliers u of a zone solve a linear
complementarity problem: u >= 0, K u >= s, and u_j = 0 wherever (K u)_j > s_j. Here K = C C^T is the
Gram matrix of constraints of unit length. The method looks for the set F of active constraints:

    1. A few sweeps of Gauss-Seidel guess F.
    2. K_FF u_F = s_F is solved, with u = 0 elsewhere.
    3. Constraints with a negative multiplier leave F, and violated ones enter it, all at once.
    4. Steps 2 and 3 are repeated until no constraint leaves or enters.

This takes two to four factorisations, whereas a method that adds one constraint at a time takes a
step for each active constraint. It has two weaknesses. It may cycle. And the Gram matrix squares
how nearly dependent the constraints are. So the method answers only if every constraint holds to
rounding, with pivots far from zero. Otherwise it returns NOT_CONVERGED, and the active set
(`solvers/serial/active_set.py`), which has neither weakness, takes over.

Source: J. J. Judice, F. M. Pires, A block principal pivoting algorithm for large-scale strictly
monotone linear complementarity problems (1994); for the guess, the dual of docs/method section 5,
one multiplier after the other.
"""

import numpy as np

from izo_ref.base.arrays import AnyInt, Floats, Ints, Normals
from izo_ref.base.compile import compiled
from izo_ref.base.serial.views import matrix_of
from izo_ref.solvers.serial.constraints import (
    NOT_CONVERGED,
    ROUNDING,
    SOLVED,
    add_constraint,
    constraint_size,
    pull,
    violations,
)
from izo_ref.solvers.serial.dense import cholesky_solve, partial_cholesky, work_of_cholesky

# A pivot is the square of the distance of a constraint from the span of those before it. With this
# pivot or a smaller one, the constraint is left out. The rounding of K moves a pivot by some 1e-15,
# so an answer with larger pivots is right to 1e-9, and to the square of that after the correction.
SMALLEST_PIVOT = 1e-6
# The guess takes SWEEPS sweeps, or FEW_SWEEPS for up to FEW_CONSTRAINTS constraints. A sweep takes
# n^2 operations. A factorisation takes k^3 / 6, with k active constraints. In small zones,
# exchanging constraints is therefore cheaper than sweeping.
SWEEPS, FEW_SWEEPS, FEW_CONSTRAINTS = 8, 3, 24
# A violation up to this many times `constraint_size` cannot be improved by a correction.
LAST_DIGIT = 4e-16
# Successive exchanges that may fail to change fewer constraints than any exchange before. More mean
# that the method cycles, or is about to.
PATIENCE = 3


@compiled
def work_of_block_pivot(n: int, n_vertices: int) -> tuple[int, int]:
    """Return the work space of a zone of n impacts, in f8 numbers and in i4 indices."""
    return 2 * n * n + 2 * n + work_of_cholesky(n), 6 * n + n_vertices


@compiled
def block_pivot(
    begin: int,
    end: int,
    first: int,
    last: int,
    all_nodes: Ints,
    all_coefficients: Floats,
    all_normals: Normals,
    rhs: Floats,
    numbers: Floats,
    indices: Ints,
    multipliers_out: Floats,
    z_out: Floats,
) -> tuple[int, int]:
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
        numbers: f8, work space; `work_of_block_pivot` says how much.
        indices: i4, work space; `work_of_block_pivot` says how much.
        multipliers_out: (n_impacts,) f8, u; begin..end are written.
        z_out: (3 n_unknowns,) f8; the coordinates of first..last are written.

    Returns:
        SOLVED or NOT_CONVERGED, and the number of factorisations. If the zone is not solved,
        positive multipliers are a guess of the active constraints, and z is invalid.
    """
    n = end - begin
    nodes, coefficients = all_nodes[begin:end], all_coefficients[begin:end]
    normals, s = all_normals[begin:end], rhs[begin:end]
    u, z = multipliers_out[begin:end], z_out[3 * first : 3 * last]
    gram, factor = matrix_of(numbers, n, n), matrix_of(numbers[n * n :], n, n)
    at = 2 * n * n
    violation, step, tiles = (
        numbers[at : at + n],
        numbers[at + n : at + 2 * n],
        numbers[at + 2 * n :],
    )
    chain, active, is_active = indices[: 4 * n], indices[4 * n : 5 * n], indices[5 * n : 6 * n]
    head = indices[6 * n : 6 * n + last - first]
    _compute_gram(first, nodes, coefficients, normals, head, chain, gram)
    largest = _guess_active(gram, s, u, violation, is_active)
    fewest, patience, factorizations = n + 1, PATIENCE, 0
    while True:
        q = _solve_active(gram, s, is_active, active, factor, tiles, step, u, violation)
        factorizations += 1
        changed = _exchange(u, violation, ROUNDING * largest, is_active)
        if changed == 0:
            break
        patience = PATIENCE if changed < fewest else patience - 1
        fewest = min(fewest, changed)
        if patience < 0:
            return NOT_CONVERGED, factorizations
    pull(first, nodes, coefficients, normals, u, z)
    violations(first, nodes, coefficients, normals, s, z, violation)
    if _holds(LAST_DIGIT, first, nodes, coefficients, s, z, violation, is_active):
        return SOLVED, factorizations
    # u has the rounding of K, and s - C z has not. So z is corrected, and need not be C^T u.
    for a in range(q):
        step[a] = violation[active[a]]
    cholesky_solve(factor, q, step)
    for a in range(q):
        u[active[a]] = max(u[active[a]] + step[a], 0.0)
        add_constraint(step[a], np.int64(active[a]), first, nodes, coefficients, normals, z)
    violations(first, nodes, coefficients, normals, s, z, violation)
    holds = _holds(ROUNDING, first, nodes, coefficients, s, z, violation, is_active)
    return (SOLVED if holds else NOT_CONVERGED), factorizations


@compiled
def _compute_gram(
    first: int,
    nodes: Ints,
    coefficients: Floats,
    normals: Normals,
    head: Ints,
    chain: Ints,
    gram: Floats,
) -> None:
    """Compute K = C C^T, with the help of linked lists of the constraints at each unknown.

    Entry 4 i + k stands for node k of constraint i. `head` (n_unknowns,) holds the last entry of
    each unknown, and `chain` (4 n,) the entry before each entry, or -1.
    """
    n = nodes.shape[0]
    for i in range(head.shape[0]):
        head[i] = -1
    for i in range(n):
        row = gram[i]
        for j in range(n):
            row[j] = 0.0
    for i in range(n):
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        for k in range(4):
            if nodes[i, k] < 0:
                continue
            at, own = nodes[i, k] - first, coefficients[i, k]
            entry = head[at]
            while entry >= 0:
                j = entry >> 2
                cosine = x * normals[j, 0] + y * normals[j, 1] + z * normals[j, 2]
                gram[i, j] += own * coefficients[j, entry & 3] * cosine
                entry = chain[entry]
            gram[i, i] += own * own * (x * x + y * y + z * z)
            chain[4 * i + k] = head[at]
            head[at] = 4 * i + k
    for i in range(n):
        for j in range(i):
            gram[j, i] = gram[i, j]


@compiled
def _guess_active(gram: Floats, s: Floats, u: Floats, violation: Floats, is_active: Ints) -> float:
    """Guess the active constraints by some sweeps from u = 0, and return the largest |s|."""
    n, largest = s.shape[0], 0.0
    for j in range(n):
        u[j] = 0.0
        violation[j] = s[j]
        largest = max(largest, abs(s[j]))
    for _ in range(SWEEPS if n > FEW_CONSTRAINTS else FEW_SWEEPS):
        _sweep(gram, u, violation)
    for j in range(n):
        is_active[j] = u[j] > 0.0
    return largest


@compiled
def _sweep(gram: Floats, u: Floats, violation: Floats) -> None:
    """Do one sweep of Gauss-Seidel over u >= 0, and keep violation = s - K u up to date."""
    for i in range(u.shape[0]):
        row = gram[i]
        if row[i] > 0.0:
            step = max(violation[i] / row[i], -u[i])
            if step != 0.0:
                u[i] += step
                for j in range(violation.shape[0]):
                    violation[j] -= step * row[j]


@compiled
def _solve_active(
    gram: Floats,
    s: Floats,
    is_active: Ints,
    active: Ints,
    factor: Floats,
    tiles: Floats,
    u_active: Floats,
    u: Floats,
    violation: Floats,
) -> AnyInt:
    """Solve K_FF u_F = s_F for the active constraints F, and compute violation = s - K u.

    A constraint that depends on those before it is left out. It is then inactive: it may have
    slack, and it enters again if it is violated.

    Returns:
        The number of constraints in F. `active` lists them, `factor` is the Cholesky factor of
        K_FF, and `u_active` is u_F.
    """
    n = s.shape[0]
    q = np.int64(0)  # typed: with a constant, what is called below would be compiled once more
    for j in range(n):
        if is_active[j]:
            active[q] = j
            u_active[q] = s[j]
            q += 1
    for a in range(q):
        row, out = gram[active[a]], factor[a]
        for b in range(a, q):
            out[b] = row[active[b]]
    partial_cholesky(factor, q, q, SMALLEST_PIVOT, tiles)
    cholesky_solve(factor, q, u_active)
    for j in range(n):
        u[j] = 0.0
        violation[j] = s[j]
    for a in range(q):
        is_active[active[a]] = factor[a, a] > 0.0
        row, value = gram[active[a]], u_active[a]
        u[active[a]] = value
        for j in range(n):
            violation[j] -= value * row[j]
    return q


@compiled
def _exchange(u: Floats, violation: Floats, rounding: float, is_active: Ints) -> int:
    """Exchange constraints between active and inactive, and return how many changed.

    Those with a negative multiplier become inactive. Those that are violated by more than
    `rounding` become active.
    """
    changed = 0
    for j in range(u.shape[0]):
        if is_active[j]:
            if u[j] < 0.0:
                is_active[j] = False
                changed += 1
        elif violation[j] > rounding:
            is_active[j] = True
            changed += 1
    return changed


@compiled
def _holds(
    rounding: float,
    first: int,
    nodes: Ints,
    coefficients: Floats,
    rhs: Floats,
    z: Floats,
    violation: Floats,
    is_active: Ints,
) -> bool:
    """Return whether every constraint holds to rounding, and with equality if it is active.

    `rounding` is relative to `constraint_size`.
    """
    for j in range(rhs.shape[0]):
        off = abs(violation[j]) if is_active[j] else violation[j]
        if off <= rounding * abs(rhs[j]):  # the size is at least this, so it need not be computed
            continue
        if off > rounding * constraint_size(j, first, nodes, coefficients, rhs, z):
            return False
    return True
