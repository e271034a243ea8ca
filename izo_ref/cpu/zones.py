"""Zones in scaled variables, and the active-set solver, which takes one zone a thread."""

import math

from numba import prange

from izo_ref._jit import cpu_kernel, light_kernel
from izo_ref.serial.active_set import active_set


@light_kernel
def scaled_rows(
    # In:
    nodes,  # (n_impacts, 4) i4
    weights,  # (n_impacts, 4) f8
    normals,  # (n_impacts, 3) f8
    targets,  # (n_vertices, 3) f8  [m]
    inverse_sqrt_masses,  # (n_vertices,) f8  [kg^-1/2], 0 for pinned
    thickness,  # f8  [m]
    # Out:
    coefficients_out,  # (n_impacts, 4) f8, unit length in each row
    rhs_out,  # (n_impacts,) f8  [m kg^1/2]; thickness - gap [m] where the length is 0
    lengths_out,  # (n_impacts,) f8  [kg^-1/2], of the rows before scaling; 0: no unknowns
):
    for j in prange(nodes.shape[0]):
        length_sq = 0.0
        normal_sq = 0.0
        gap = 0.0
        for k in range(4):
            coefficient = weights[j, k] * inverse_sqrt_masses[nodes[j, k]]
            coefficients_out[j, k] = coefficient
            length_sq += coefficient * coefficient
            for axis in range(3):
                # relative to the first node: weights sum to zero
                arm = targets[nodes[j, k], axis] - targets[nodes[j, 0], axis]
                gap += weights[j, k] * normals[j, axis] * arm
        for axis in range(3):
            normal_sq += normals[j, axis] * normals[j, axis]
        lengths_out[j] = math.sqrt(length_sq * normal_sq)
        rhs_out[j] = thickness - gap
        if lengths_out[j] > 0.0:
            rhs_out[j] /= lengths_out[j]
            for k in range(4):
                coefficients_out[j, k] /= lengths_out[j]


@cpu_kernel
def solve_active_set(
    # In:
    zones,  # (n,) i8, those to solve
    impact_offsets,  # (n_zones + 1,) i8
    vertex_offsets,  # (n_zones + 1,) i8
    nodes,  # (n_impacts, 4) i4, into the unknowns, zone by zone; -1 for pinned
    coefficients,  # (n_impacts, 4) f8
    normals,  # (n_impacts, 3) f8
    rhs,  # (n_impacts,) f8  [m kg^1/2]
    # Out:
    multipliers_out,  # (n_impacts,) f8  [m kg^1/2], of the unit rows
    z_out,  # (n_unknowns, 3) f8  [m kg^1/2]
    statuses_out,  # (n_zones,) i1, of serial/active_set.py
    steps_out,  # (n_zones,) i4
):
    for i in prange(zones.shape[0]):
        zone = zones[i]
        statuses_out[zone], steps_out[zone] = active_set(
            impact_offsets[zone],
            impact_offsets[zone + 1],
            vertex_offsets[zone],
            vertex_offsets[zone + 1],
            nodes,
            coefficients,
            normals,
            rhs,
            multipliers_out,
            z_out,
        )
