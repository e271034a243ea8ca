"""Zones in scaled variables, and the active-set solver, which takes one zone a thread."""

import math

from numba import prange

from izo_ref._jit import cpu_kernel, light_kernel
from izo_ref.serial.small_zone import solve_small_zone
from izo_ref.serial.sweeps import sweeps


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
    unknowns_out,  # (n_impacts, 4) i4, as nodes; -1 for pinned
    coefficients_out,  # (n_impacts, 4) f8, unit length in each row
    rhs_out,  # (n_impacts,) f8  [m kg^1/2]
    lengths_out,  # (n_impacts,) f8  [kg^-1/2], of the rows before scaling; 1 if there was none
    hopeless_out,  # (n_impacts,) b1, violated and without unknowns
):
    for j in prange(nodes.shape[0]):
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
                arm = targets[node, axis] - targets[nodes[j, 0], axis]
                gap += weights[j, k] * normals[j, axis] * arm
        for axis in range(3):
            normal_sq += normals[j, axis] * normals[j, axis]
        length = math.sqrt(length_sq * normal_sq)
        hopeless_out[j] = length == 0.0 and gap < thickness
        if length > 0.0:
            lengths_out[j] = length
            rhs_out[j] = (thickness - gap) / length
            for k in range(4):
                coefficients_out[j, k] /= length
        else:  # satisfied, and in nobody's way
            lengths_out[j] = 1.0
            rhs_out[j] = -thickness


@cpu_kernel
def solve_small_zones(
    # In:
    zones,  # (n,) i8, those to solve
    methods,  # (n,) i1, of serial/small_zone.py, to try first
    impact_offsets,  # (n_zones + 1,) i8
    vertex_offsets,  # (n_zones + 1,) i8
    unknowns,  # (n_impacts, 4) i4, into z, zone by zone; -1 for pinned
    coefficients,  # (n_impacts, 4) f8
    normals,  # (n_impacts, 3) f8
    rhs,  # (n_impacts,) f8  [m kg^1/2]
    lengths,  # (n_impacts,) f8  [kg^-1/2]
    limits,  # Limits, of serial/small_zone.py
    # Out:
    multipliers_out,  # (n_impacts,) f8  [m kg^1/2], of the unit rows
    z_out,  # (n_unknowns, 3) f8  [m kg^1/2]
    methods_out,  # (n_zones,) i1, the last that was tried
    solved_out,  # (n_zones,) b1, to the limits
    steps_out,  # (n_zones,) i4
):
    for i in prange(zones.shape[0]):
        zone = zones[i]
        methods_out[zone], solved_out[zone], steps_out[zone] = solve_small_zone(
            methods[i],
            impact_offsets[zone],
            impact_offsets[zone + 1],
            vertex_offsets[zone],
            vertex_offsets[zone + 1],
            unknowns,
            coefficients,
            normals,
            rhs,
            lengths,
            limits,
            multipliers_out,
            z_out,
        )


@cpu_kernel
def solve_sweeps(
    # In:
    impact_offsets,  # (n_zones + 1,) i8
    vertex_offsets,  # (n_zones + 1,) i8
    unknowns,  # (n_impacts, 4) i4, into z, zone by zone; -1 for pinned
    coefficients,  # (n_impacts, 4), of the solver's type as all that has none here
    normals,  # (n_impacts, 3)
    rhs,  # (n_impacts,)
    metres,  # (n_impacts,) f8  [m], violation of a row of 1
    accelerated,  # bool
    max_sweeps,  # i8
    gap_tolerance,  # f8, relative
    violation_tolerance,  # f8  [m]
    # Out:
    multipliers_out,  # (n_impacts,), of the unit rows; where to begin on entry
    z_out,  # (n_unknowns, 3)
    steps_out,  # (n_zones,) i4
    trace_out,  # (n_zones, k, 2) f8, 1/2 |z|^2 and violation [m] after each sweep; k = 0: none
):
    for zone in prange(impact_offsets.shape[0] - 1):
        steps_out[zone] = sweeps(
            impact_offsets[zone],
            impact_offsets[zone + 1],
            vertex_offsets[zone],
            vertex_offsets[zone + 1],
            unknowns,
            coefficients,
            normals,
            rhs,
            metres,
            accelerated,
            max_sweeps,
            gap_tolerance,
            violation_tolerance,
            multipliers_out,
            z_out,
            trace_out[zone],
        )
