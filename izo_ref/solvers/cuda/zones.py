"""Constraints in scaled variables, and the solver that takes one thread a zone."""

from numba import cuda

from izo_ref.base.arrays import (
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
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.solvers.serial.constraints import scale_constraint
from izo_ref.solvers.serial.small_zone import (
    BLOCK_PIVOT,
    Limits,
    solve_small_zone,
    work_of_small_zone,
)


@cuda_kernel
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
    j = cuda.grid(1)
    if j < nodes.shape[0]:
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


@cuda_kernel
def solve_small_zones(
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
    slot, n_slots = cuda.grid(1), number_starts.shape[0] - 1
    if slot < n_slots:
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


@cuda_kernel
def choose_methods(
    # In:
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    largest: int,  # i8, most impacts of a small zone
    single: int,  # i1, method for a zone of one impact
    # Out:
    methods_out: Codes,  # (n_zones,) i1, method to try first, of solvers/serial/small_zone.py
    small_out: Flags,  # (n_zones,) b1
    numbers_out: Indices,  # (n_zones,) i8, numbers of work space
    indices_out: Indices,  # (n_zones,) i8, indices of work space
) -> None:
    """Choose the method to try first for each zone, and measure its work space."""
    zone = cuda.grid(1)
    if zone < small_out.shape[0]:
        n = impact_offsets[zone + 1] - impact_offsets[zone]
        methods_out[zone] = single if n == 1 else BLOCK_PIVOT
        small_out[zone] = n <= largest
        work = work_of_small_zone(n, vertex_offsets[zone + 1] - vertex_offsets[zone])
        numbers_out[zone], indices_out[zone] = work


@cuda_kernel
def flag_zones_of_size(
    # In:
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    more_than: int,  # i8, impacts
    at_most: int,  # i8, impacts
    # Out:
    flags_out: Flags,  # (n_zones,) b1, zones with more than one number and at most the other
) -> None:
    """Flag the zones whose number of impacts is in a range."""
    zone = cuda.grid(1)
    if zone < flags_out.shape[0]:
        size = impact_offsets[zone + 1] - impact_offsets[zone]
        flags_out[zone] = more_than < size <= at_most
