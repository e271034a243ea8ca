"""Compute with the constraints of one zone in scaled variables.

The method (docs/method section 5) measures each vertex i by z_i = sqrt(m_i) (x_i - y_i)
[m kg^1/2], where y_i is its proposed position and m_i its mass, and scales each constraint to unit
length. The zone becomes

    minimise 1/2 |z|^2   subject to   C z >= s,   with z = C^T u for multipliers u >= 0.

Constraint j is c_j . z >= s_j, and c_j is row j of C. It has entries for the four vertices of its
impact only: coefficients[j, k] normals[j] at vertex nodes[j, k]. A pinned vertex does not move, so
it has no unknown, and nodes[j, k] is negative.

Most functions take these arrays of one zone:

    first         its first unknown; unknown i is z[3 (i - first)] and the two numbers behind it
    nodes         (n, 4) i4, the unknowns of each constraint
    coefficients  (n, 4) f8
    normals       (n, 3) f8, unit vectors
    rhs           (n,) f8 [m kg^1/2], s
    u             (n,) f8 [m kg^1/2]
    z             (3 n_unknowns,) f8 [m kg^1/2], flat

Sweeps (`solvers/serial/sweeps.py`) may take f4 in place of f8.

Source: docs/method section 5.
"""

import math

import numpy as np

from izo_ref.base.arrays import AnyFloats, AnyInt, Floats, Ints, Nodes, Normals, Positions, Weights
from izo_ref.base.compile import compiled

SOLVED = 0
INFEASIBLE = 1
NOT_CONVERGED = 2

# A violation counts as none up to this many times `constraint_size`: so much is the rounding of s
# and C z. Each constraint is compared with its own size, because at a mass ratio of 1e12 the
# right-hand sides of constraints differ by a factor of 1e6.
ROUNDING = 4e-15


@compiled
def scale_constraint(
    j: int,
    nodes: Nodes,
    weights: Weights,
    normals: Normals,
    proposed: Positions,
    inverse_sqrt_masses: Floats,
    thickness: float,
    unknowns_out: Ints,
    coefficients_out: Floats,
) -> tuple[float, float, bool]:
    """Compute constraint j in scaled variables.

    Args:
        j: The impact.
        nodes: (n_impacts, 4) i4.
        weights: (n_impacts, 4) f8.
        normals: (n_impacts, 3) f8.
        proposed: (n_vertices, 3) f8 [m].
        inverse_sqrt_masses: (n_vertices,) f8 [kg^-1/2], 0 for pinned vertices.
        thickness: [m].
        unknowns_out: (n_impacts, 4) i4, the nodes, or -1 for pinned vertices. Row j is written.
        coefficients_out: (n_impacts, 4) f8; with the normal, a constraint of unit length. Row j is
            written.

    Returns:
        s [m kg^1/2]; the length of the constraint before scaling [kg^-1/2], or 1 if it has no
        unknowns; and whether it is violated and has no unknowns.

    Source: docs/method section 5.
    """
    length_sq = 0.0
    normal_sq = 0.0
    gap = 0.0
    for k in range(4):
        node = nodes[j, k]
        coefficient = weights[j, k] * inverse_sqrt_masses[node]
        unknowns_out[j, k] = node if inverse_sqrt_masses[node] > 0.0 else -1
        coefficients_out[j, k] = coefficient
        length_sq += coefficient * coefficient
        for axis in range(3):
            # relative to the first node, which changes nothing: the weights sum to zero
            arm = proposed[node, axis] - proposed[nodes[j, 0], axis]
            gap += weights[j, k] * normals[j, axis] * arm
    for axis in range(3):
        normal_sq += normals[j, axis] * normals[j, axis]
    length = math.sqrt(length_sq * normal_sq)
    if not length > 0.0:
        # with s = -thickness the constraint 0 >= s always holds, so it hinders no other
        return -thickness, 1.0, length == 0.0 and gap < thickness
    for k in range(4):
        coefficients_out[j, k] /= length
    return (thickness - gap) / length, length, False


@compiled
def add_constraint(
    scale: float,
    j: AnyInt,
    first: int,
    nodes: Ints,
    coefficients: AnyFloats,
    normals: AnyFloats,
    z: AnyFloats,
) -> None:
    """Add a multiple of constraint j: z += scale * c_j."""
    for k in range(4):
        if nodes[j, k] >= 0:
            at = 3 * (nodes[j, k] - first)
            weight = scale * coefficients[j, k]
            z[at] += weight * normals[j, 0]
            z[at + 1] += weight * normals[j, 1]
            z[at + 2] += weight * normals[j, 2]


@compiled
def constraint_dot(
    j: AnyInt, first: int, nodes: Ints, coefficients: AnyFloats, normals: AnyFloats, z: AnyFloats
) -> float:
    """Return the scalar product c_j . z."""
    value = 0.0
    for k in range(4):
        if nodes[j, k] >= 0:
            at = 3 * (nodes[j, k] - first)
            value += coefficients[j, k] * (
                normals[j, 0] * z[at] + normals[j, 1] * z[at + 1] + normals[j, 2] * z[at + 2]
            )
    return value


@compiled
def pull(
    first: int, nodes: Ints, coefficients: AnyFloats, normals: AnyFloats, u: AnyFloats, z: AnyFloats
) -> None:
    """Compute z = C^T u, where the multipliers u pull the vertices."""
    for i in range(z.shape[0]):
        z[i] = 0.0
    for j in range(u.shape[0]):
        if u[j] != 0.0:
            add_constraint(u[j], j, first, nodes, coefficients, normals, z)


@compiled
def products(
    first: int,
    nodes: Ints,
    coefficients: AnyFloats,
    normals: AnyFloats,
    z: AnyFloats,
    products_out: AnyFloats,
) -> None:
    """Compute C z."""
    for j in range(products_out.shape[0]):
        products_out[j] = constraint_dot(j, first, nodes, coefficients, normals, z)


@compiled
def violations(
    first: int,
    nodes: Ints,
    coefficients: AnyFloats,
    normals: AnyFloats,
    rhs: AnyFloats,
    z: AnyFloats,
    violations_out: AnyFloats,
) -> None:
    """Compute s - C z; positive entries are violations."""
    for j in range(rhs.shape[0]):
        violations_out[j] = rhs[j] - constraint_dot(j, first, nodes, coefficients, normals, z)


@compiled
def residuals(
    first: int,
    nodes: Ints,
    coefficients: AnyFloats,
    normals: AnyFloats,
    rhs: AnyFloats,
    metres: AnyFloats,
    u: AnyFloats,
    z: AnyFloats,
) -> tuple[float, float]:
    """Return the largest violation [m] and the relative duality gap, for z = C^T u.

    The gap is sum_j u_j |s - C z|_j over the objective 1/2 |z|^2. `metres` (n,) says what a
    violation of 1 is in metres.
    """
    violation, products, z_sq = 0.0, 0.0, 0.0
    for i in range(z.shape[0]):
        z_sq += z[i] * z[i]
    for j in range(rhs.shape[0]):
        missing = rhs[j] - constraint_dot(j, first, nodes, coefficients, normals, z)
        violation = max(violation, missing * metres[j])
        products += u[j] * abs(missing)
    gap = products / (0.5 * z_sq) if z_sq > 0.0 else (0.0 if products == 0.0 else np.inf)
    return violation, gap


@compiled
def constraint_size(
    j: AnyInt, first: int, nodes: Ints, coefficients: Floats, rhs: Floats, z: Floats
) -> float:
    """Return the size of the terms of s_j - c_j . z, against which its rounding is measured."""
    size = abs(rhs[j])
    for k in range(4):
        if nodes[j, k] >= 0:
            at = 3 * (nodes[j, k] - first)
            z_sq = z[at] * z[at] + z[at + 1] * z[at + 1] + z[at + 2] * z[at + 2]
            size += abs(coefficients[j, k]) * math.sqrt(z_sq)
    return size
