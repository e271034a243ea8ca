"""The residuals that judge every solver, for zones side by side (docs/method section 8)."""

import math

import numpy as np

from izo_ref.base.arrays import (
    AnyInt,
    Floats,
    Masses,
    Multipliers,
    Nodes,
    Normals,
    Offsets,
    Positions,
    Weights,
)
from izo_ref.base.compile import compiled

# Bound of the error of a frozen gap at positions that are rounded to floats, over the largest
# coordinate X, if the exact positions satisfy the constraint with equality. Let u = 2^-53. The
# absolute weights sum to 2, and those of nodes 1 to 3 to at most 2. The errors, in units of
# u X |N|_1 and up to terms in u^2, are:
#
#     positions       each coordinate is off by u X                                    2
#     weights         their sum differs from 0 by some 2 u, times the first node       2
#     component       three differences of up to 2 X and their products: 8; two
#                     additions with results of up to 4 X: 8                          16
#     dot product     of components of up to 2 X                                       2
#     slack           the thickness is then about the gap, up to 2 X |N|_1; two
#                     additions with results of up to twice that                       8
#
# Together these are 30; the constant takes 32, and sqrt 3 for |N|_1.
GAP_ROUNDING = 32.0 * math.sqrt(3.0) * 2.0**-53
# The residuals that are infinite for a zone without numbers. The others are floors.
N_INFINITE = 6


@compiled
def residuals_of_zone(
    begin: AnyInt,
    end: AnyInt,
    first: AnyInt,
    last: AnyInt,
    nodes: Nodes,
    weights: Weights,
    normals: Normals,
    proposed: Positions,
    masses: Masses,
    thickness: float,
    positions: Positions,
    multipliers: Multipliers,
    forces: Floats,
    residuals_out: Floats,
) -> None:
    """Judge the zone of the impacts begin..end and the vertices first..last.

    Args:
        begin: The zone's first impact.
        end: Its last impact + 1.
        first: The zone's first unpinned vertex.
        last: Its last unpinned vertex + 1. Pinned vertices may be anywhere.
        nodes: (n_impacts, 4) i4, of all zones.
        weights: (n_impacts, 4) f8.
        normals: (n_impacts, 3) f8.
        proposed: (n_vertices, 3) f8 [m], y.
        masses: (n_vertices,) f8 [kg], infinite for pinned vertices.
        thickness: [m].
        positions: (n_vertices, 3) f8 [m], x.
        multipliers: (n_impacts,) f8 [kg], l.
        forces: (n_vertices, 3) f8, zeros; A^T l+ [kg m] is added.
        residuals_out: (8,) f8, the fields of `Residuals`.
    """
    products, pushes, violation, largest, negative, coordinate = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(begin, end):
        clamped, slack = max(multipliers[j], 0.0), -thickness
        for axis in range(3):
            # Positions relative to the first node give the same gap, because the weights sum to
            # zero, and far from the origin they lose less to rounding.
            component = 0.0
            for k in range(4):
                node = nodes[j, k]
                component += weights[j, k] * (positions[node, axis] - positions[nodes[j, 0], axis])
                forces[node, axis] += weights[j, k] * normals[j, axis] * clamped
                coordinate = max(coordinate, abs(positions[node, axis]))
            slack += normals[j, axis] * component
        products += clamped * abs(slack)
        pushes += clamped
        violation = max(violation, -slack)
        largest = max(largest, abs(multipliers[j]))
        negative = max(negative, -multipliers[j])
    moved_sq, error_sq = 0.0, 0.0
    for i in range(first, last):
        for axis in range(3):
            coordinate = max(coordinate, abs(positions[i, axis]))
            if masses[i] < math.inf:
                sqrt_mass = math.sqrt(masses[i])
                moved = sqrt_mass * (positions[i, axis] - proposed[i, axis])
                moved_sq += moved**2
                error_sq += (moved - forces[i, axis] / sqrt_mass) ** 2
    objective, rounding = 0.5 * moved_sq, GAP_ROUNDING * coordinate
    residuals_out[0] = violation
    residuals_out[1] = violation / thickness
    residuals_out[2] = _ratio(negative, largest)
    residuals_out[3] = math.sqrt(_ratio(error_sq, moved_sq))
    residuals_out[4] = _ratio(products, objective)
    residuals_out[5] = _ratio(0.5 * error_sq + products, objective)
    residuals_out[6] = rounding / thickness
    residuals_out[7] = _ratio(rounding * pushes, objective)


@compiled
def judge_zones(
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8, of unpinned vertices
    nodes: Nodes,  # (n_impacts, 4) i4
    weights: Weights,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    proposed: Positions,  # (n_vertices, 3) f8 [m]
    masses: Masses,  # (n_vertices,) f8 [kg], infinite for pinned vertices
    thickness: float,  # f8 [m]
    positions: Positions,  # (n_vertices, 3) f8 [m]
    multipliers: Multipliers,  # (n_impacts,) f8 [kg]
    residuals_out: Floats,  # (n_zones, 8) f8, the fields of `Residuals`
) -> None:
    """Judge zones that lie side by side; one without numbers has infinite residuals."""
    forces = np.zeros(proposed.shape)
    for zone in range(residuals_out.shape[0]):
        begin, end = impact_offsets[zone], impact_offsets[zone + 1]
        first, last = vertex_offsets[zone], vertex_offsets[zone + 1]
        if _are_finite(begin, end, first, last, positions, multipliers):
            residuals_of_zone(
                begin,
                end,
                first,
                last,
                nodes,
                weights,
                normals,
                proposed,
                masses,
                thickness,
                positions,
                multipliers,
                forces,
                residuals_out[zone],
            )
        else:
            for k in range(residuals_out.shape[1]):
                residuals_out[zone, k] = math.inf if k < N_INFINITE else 0.0


@compiled
def _are_finite(
    begin: AnyInt,
    end: AnyInt,
    first: AnyInt,
    last: AnyInt,
    positions: Positions,
    multipliers: Multipliers,
) -> bool:
    """Return whether the positions and the multipliers of a zone are finite."""
    for i in range(first, last):
        for axis in range(3):
            if not math.isfinite(positions[i, axis]):
                return False
    for j in range(begin, end):  # noqa: SIM110
        if not math.isfinite(multipliers[j]):
            return False
    return True


@compiled
def _ratio(value: float, scale: float) -> float:
    """Return value / scale; where the scale is 0, return 0 for the value 0, else infinity."""
    if scale > 0.0:
        return value / scale
    return 0.0 if value == 0.0 else math.inf
