"""An orthonormal basis of the active constraints of one zone, kept up to date.

C_W has the q active constraints as its rows, in the order in which they became active. They are
C_W = L Q, with L lower triangular and the rows of Q orthonormal. A constraint that becomes active
adds a row to L and to Q: it is projected onto the rows of Q, and once more if at most half of its
length is left. For a constraint that becomes inactive, a row is taken away, and rotations make L
triangular again.

The functions take these arrays, for n constraints and size = 3 n_unknowns:

    factor     (n + 1, n + 1) f8, L
    basis      (min(n, size) + 1, size) f8, Q
    rest       (size,) f8, what the projection of a constraint leaves
    r          (n,) f8, what the projection finds
    active     (n,) i4, the active constraints, in the order of the rows of L
    is_active  (n,) i4, whether each constraint is active

Source: D. Goldfarb, A. Idnani, A numerically stable dual method for solving strictly convex
quadratic programs (1983), section 3; B. N. Parlett, The Symmetric Eigenvalue Problem (1998),
section 6.9, for projecting twice.
"""

import math

from izo_ref.base.arrays import AnyInt, Floats, Ints, Normals
from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.constraints import add_constraint, constraint_dot


@compiled
def project(
    j: AnyInt,
    first: int,
    nodes: Ints,
    coefficients: Floats,
    normals: Normals,
    basis: Floats,
    q: AnyInt,
    r: Floats,
    rest: Floats,
) -> float:
    """Split constraint c_j: r = Q c_j, rest = c_j - Q^T r; and return the length of the rest.

    This length is the distance of the constraint, which has unit length, from the span of the
    active ones. If at most half is left, the rounding of the projection counts, and the rest is
    projected once more.
    """
    for i in range(rest.shape[0]):
        rest[i] = 0.0
    add_constraint(1.0, j, first, nodes, coefficients, normals, rest)
    for k in range(q):
        r[k] = constraint_dot(j, first, nodes, coefficients, normals, basis[k])
    for k in range(q):
        for i in range(rest.shape[0]):
            rest[i] -= r[k] * basis[k, i]
    length = math.sqrt(_dot(rest, rest))
    if length > 0.5:
        return length
    for k in range(q):
        more = _dot(basis[k], rest)
        r[k] += more
        for i in range(rest.shape[0]):
            rest[i] -= more * basis[k, i]
    return math.sqrt(_dot(rest, rest))


@compiled
def _dot(a: Floats, b: Floats) -> float:
    """Return the scalar product of two vectors."""
    value = 0.0
    for i in range(a.shape[0]):
        value += a[i] * b[i]
    return value


@compiled
def solve_lower(factor: Floats, q: AnyInt, x: Floats) -> None:
    """Solve L x' = x in place, for the first q rows."""
    for i in range(q):
        value = x[i]
        for k in range(i):
            value -= factor[i, k] * x[k]
        x[i] = value / factor[i, i]


@compiled
def solve_upper(factor: Floats, q: AnyInt, x: Floats) -> None:
    """Solve L^T x' = x in place, for the first q rows."""
    for i in range(q - 1, -1, -1):
        value = x[i]
        for k in range(i + 1, q):
            value -= factor[k, i] * x[k]
        x[i] = value / factor[i, i]


@compiled
def append_constraint(
    j: AnyInt,
    distance: float,
    q: AnyInt,
    active: Ints,
    is_active: Ints,
    factor: Floats,
    basis: Floats,
    rest: Floats,
    r: Floats,
) -> AnyInt:
    """Make constraint j active, and return the new number of active ones.

    r and rest are as `project` left them, and `distance` is what it returned.
    """
    for k in range(q):
        factor[q, k] = r[k]
    factor[q, q] = distance
    for i in range(rest.shape[0]):
        basis[q, i] = rest[i] / distance
    active[q] = j
    is_active[j] = True
    return q + 1


@compiled
def remove_constraint(
    place: AnyInt, q: AnyInt, active: Ints, is_active: Ints, factor: Floats, basis: Floats
) -> AnyInt:
    """Make the active constraint at a place inactive, and return the new number of active ones."""
    is_active[active[place]] = False
    _remove_row(factor, basis, q, place)
    for k in range(place, q - 1):
        active[k] = active[k + 1]
    return q - 1


@compiled
def _remove_row(factor: Floats, basis: Floats, q: AnyInt, row: AnyInt) -> None:
    """Remove a row of L, and rotate the numbers away that are then above its diagonal."""
    for i in range(row, q - 1):
        for k in range(i + 2):
            factor[i, k] = factor[i + 1, k]
    for i in range(row, q - 1):
        a = factor[i, i]
        b = factor[i, i + 1]
        length = math.sqrt(a * a + b * b)
        c = a / length
        s = b / length
        for k in range(i, q - 1):
            a = factor[k, i]
            b = factor[k, i + 1]
            factor[k, i] = c * a + s * b
            factor[k, i + 1] = c * b - s * a
        for k in range(basis.shape[1]):
            a = basis[i, k]
            b = basis[i + 1, k]
            basis[i, k] = c * a + s * b
            basis[i + 1, k] = c * b - s * a
