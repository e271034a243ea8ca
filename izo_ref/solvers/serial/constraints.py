"""The rows of one zone in scaled variables (SPEC 5), and what its solvers say of it.

A row j is c_j = sum_k coefficients[j, k] normals[j] on the unknowns of nodes[j, k]; nodes < 0
are pinned. `first` is the number of the zone's first unknown, z its unknowns, flat.
"""

import math

import numpy as np

from izo_ref.base.compile import compiled

SOLVED = 0
INFEASIBLE = 1
NOT_CONVERGED = 2

# Violation that counts as none, over the sizes of the terms of s - C z: the rounding of both.
# Of each row for itself: at a mass ratio of 1e12 the rhs of rows differ by 1e6.
ROUNDING = 4e-15


@compiled
def scale_constraint(
    j,
    nodes,
    weights,
    normals,
    proposed,
    inverse_sqrt_masses,
    thickness,
    unknowns_out,
    coefficients_out,
):
    """Row j in scaled variables.

    Args:
        nodes: (n_impacts, 4) i4.
        weights: (n_impacts, 4) f8.
        normals: (n_impacts, 3) f8.
        proposed: (n_vertices, 3) f8 [m].
        inverse_sqrt_masses: (n_vertices,) f8 [kg^-1/2], 0 for pinned.
        thickness: [m].
        unknowns_out: (n_impacts, 4) i4, as nodes; -1 for pinned. Row j is written.
        coefficients_out: (n_impacts, 4) f8, unit length in row j.

    Returns:
        s [m kg^1/2]; the length before scaling [kg^-1/2], 1 if there was none; whether the
        row is violated and without unknowns.
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
            # relative to the first node: weights sum to zero
            arm = proposed[node, axis] - proposed[nodes[j, 0], axis]
            gap += weights[j, k] * normals[j, axis] * arm
    for axis in range(3):
        normal_sq += normals[j, axis] * normals[j, axis]
    length = math.sqrt(length_sq * normal_sq)
    if not length > 0.0:  # if satisfied, it is in nobody's way
        return -thickness, 1.0, length == 0.0 and gap < thickness
    for k in range(4):
        coefficients_out[j, k] /= length
    return (thickness - gap) / length, length, False


@compiled
def add_constraint(scale, row, first, nodes, coefficients, normals, z):
    """z += scale * row, the row written out in full."""
    for k in range(4):
        if nodes[row, k] >= 0:
            at = 3 * (nodes[row, k] - first)
            weight = scale * coefficients[row, k]
            z[at] += weight * normals[row, 0]
            z[at + 1] += weight * normals[row, 1]
            z[at + 2] += weight * normals[row, 2]


@compiled
def constraint_dot(row, first, nodes, coefficients, normals, z):
    value = 0.0
    for k in range(4):
        if nodes[row, k] >= 0:
            at = 3 * (nodes[row, k] - first)
            value += coefficients[row, k] * (
                normals[row, 0] * z[at] + normals[row, 1] * z[at + 1] + normals[row, 2] * z[at + 2]
            )
    return value


@compiled
def pull(first, nodes, coefficients, normals, u, z):
    """z = C^T u."""
    for i in range(z.shape[0]):
        z[i] = 0.0
    for j in range(u.shape[0]):
        if u[j] != 0.0:
            add_constraint(u[j], j, first, nodes, coefficients, normals, z)


@compiled
def products(first, nodes, coefficients, normals, z, products_out):
    """C z."""
    for j in range(products_out.shape[0]):
        products_out[j] = constraint_dot(j, first, nodes, coefficients, normals, z)


@compiled
def violations(first, nodes, coefficients, normals, rhs, z, violation):
    """violation = s - C z."""
    for j in range(rhs.shape[0]):
        violation[j] = rhs[j] - constraint_dot(j, first, nodes, coefficients, normals, z)


@compiled
def residuals(first, nodes, coefficients, normals, rhs, metres, u, z):
    """Largest violation [m] with `metres` for a row of 1, and the relative gap for z = C^T u."""
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
def constraint_size(row, first, nodes, coefficients, rhs, z):
    """Of the terms of its violation, whose rounding that of the violation is relative to."""
    size = abs(rhs[row])
    for k in range(4):
        if nodes[row, k] >= 0:
            at = 3 * (nodes[row, k] - first)
            z_sq = z[at] * z[at] + z[at + 1] * z[at + 1] + z[at + 2] * z[at + 2]
            size += abs(coefficients[row, k]) * math.sqrt(z_sq)
    return size
