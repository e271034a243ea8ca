"""Constraints in scaled variables, and the solvers that take one thread a zone."""

from izo_ref.base.arrays import (
    AnyFloats,
    Codes,
    Flags,
    Floats,
    Indices,
    Ints,
    Multipliers,
    Nodes,
    Normals,
    Offsets,
    Positions,
    Weights,
)
from izo_ref.base.compile import cpu_kernel, light_kernel
from izo_ref.solvers.serial.constraints import scale_constraint
from izo_ref.solvers.serial.small_zone import Limits, solve_small_zone
from izo_ref.solvers.serial.sweeps import sweeps


@light_kernel
def scale_constraints(
    # In:
    nodes: Nodes,  # (n_impacts, 4) i4
    weights: Weights,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    proposed: Positions,  # (n_vertices, 3) f8  [m]
    inverse_sqrt_masses: Floats,  # (n_vertices,) f8  [kg^-1/2], 0 for pinned vertices
    thickness: float,  # f8  [m]
    # Out:
    unknowns_out: Nodes,  # (n_impacts, 4) i4, the vertices in nodes; -1 for pinned ones
    coefficients_out: Floats,  # (n_impacts, 4) f8, with the normals, rows of unit length
    rhs_out: Floats,  # (n_impacts,) f8  [m kg^1/2]
    lengths_out: Floats,  # (n_impacts,) f8  [kg^-1/2], of the rows before scaling; 1 if it was 0
    hopeless_out: Flags,  # (n_impacts,) b1, violated, and no unpinned vertex can change it
) -> None:
    """Write the constraints of impacts in scaled variables."""
    for j in range(nodes.shape[0]):
        rhs_out[j], lengths_out[j], hopeless_out[j] = scale_constraint(
            j,
            nodes,
            weights,
            normals,
            proposed,
            inverse_sqrt_masses,
            thickness,
            unknowns_out,
            coefficients_out,
        )


@cpu_kernel
def solve_small_zones(
    # Share:
    begin: int,  # i8, the first slot of this share
    end: int,  # i8, behind the last one
    # In:
    zones: Indices,  # (n,) i8, zones to solve
    methods: Codes,  # (n,) i1, method to try first, a code of solvers/serial/small_zone.py
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    unknowns: Nodes,  # (n_impacts, 4) i4, vertices in the order of z; -1 for pinned ones
    coefficients: Floats,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    rhs: Floats,  # (n_impacts,) f8  [m kg^1/2]
    lengths: Floats,  # (n_impacts,) f8  [kg^-1/2], of the rows before scaling
    limits: Limits,  # Limits, of solvers/serial/small_zone.py
    number_starts: Offsets,  # (n_slots + 1,) i8, into numbers_out; slot k: zones k, k + n_slots ...
    index_starts: Offsets,  # (n_slots + 1,) i8, into indices_out
    # Out:
    multipliers_out: Multipliers,  # (n_impacts,) f8  [m kg^1/2], for rows of unit length
    z_out: Floats,  # (3 n_unknowns,) f8  [m kg^1/2]
    methods_out: Codes,  # (n_zones,) i1, the last method that was tried
    solved_out: Flags,  # (n_zones,) b1, whether the zone is solved to the limits
    steps_out: Ints,  # (n_zones,) i4
    numbers_out: Floats,  # (number_starts[n_slots],) f8, work space of the slots
    indices_out: Ints,  # (index_starts[n_slots],) i4, work space of the slots
) -> None:
    """Solve small zones, one thread a zone; a slot solves one zone after the other."""
    n_slots = number_starts.shape[0] - 1
    for slot in range(begin, end):
        for i in range(slot, zones.shape[0], n_slots):
            zone = int(zones[i])
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
                numbers_out[number_starts[slot] : number_starts[slot + 1]],
                indices_out[index_starts[slot] : index_starts[slot + 1]],
                multipliers_out,
                z_out,
            )


@cpu_kernel
def solve_sweeps(
    # Share:
    begin: int,  # i8, the first zone of this share
    end: int,  # i8, behind the last one
    # In:
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    unknowns: Nodes,  # (n_impacts, 4) i4, vertices in the order of z; -1 for pinned ones
    coefficients: AnyFloats,  # (n_impacts, 4) f8 or f4
    normals: AnyFloats,  # (n_impacts, 3) f8 or f4
    rhs: AnyFloats,  # (n_impacts,) f8 or f4
    metres: Floats,  # (n_impacts,) f8  [m], violation if a constraint is violated by 1
    accelerated: bool,  # b1
    max_sweeps: int,  # i8
    gap_tolerance: float,  # f8, relative
    violation_tolerance: float,  # f8  [m]
    stop: Flags,  # (1,) b1, no further sweep begins once it is set
    # Out:
    multipliers_out: AnyFloats,  # (n_impacts,) f8 or f4, of unit rows; the start on entry
    z_out: AnyFloats,  # (3 n_unknowns,) f8 or f4
    steps_out: Ints,  # (n_zones,) i4
    trace_out: Floats,  # (n_zones, k, 2) f8, 1/2 |z|^2 and violation [m] of sweeps; k = 0: none
) -> None:
    """Solve zones by projected Gauss-Seidel, one thread a zone."""
    for zone in range(begin, end):
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
            stop,
            multipliers_out,
            z_out,
            trace_out[zone],
        )
