"""Zones in scaled variables, and the small ones solved, one a thread."""

from numba import cuda

from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.solvers.serial.constraints import scale_constraint
from izo_ref.solvers.serial.small_zone import BLOCK_PIVOT, solve_small_zone, work_of_small_zone


@cuda_kernel
def scale_constraints(
    # In:
    nodes,  # (n_impacts, 4) i4
    weights,  # (n_impacts, 4) f8
    normals,  # (n_impacts, 3) f8
    proposed,  # (n_vertices, 3) f8  [m]
    inverse_sqrt_masses,  # (n_vertices,) f8  [kg^-1/2], 0 for pinned
    thickness,  # f8  [m]
    # Out:
    unknowns_out,  # (n_impacts, 4) i4, as nodes; -1 for pinned
    coefficients_out,  # (n_impacts, 4) f8, unit length in each row
    rhs_out,  # (n_impacts,) f8  [m kg^1/2]
    lengths_out,  # (n_impacts,) f8  [kg^-1/2], of the rows before scaling; 1 if there was none
    hopeless_out,  # (n_impacts,) b1, violated and without unknowns
):
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
    zones,  # (n,) i8, those to solve
    methods,  # (n,) i1, of solvers/serial/small_zone.py, to try first
    impact_offsets,  # (n_zones + 1,) i8
    vertex_offsets,  # (n_zones + 1,) i8
    unknowns,  # (n_impacts, 4) i4, into z, zone by zone; -1 for pinned
    coefficients,  # (n_impacts, 4) f8
    normals,  # (n_impacts, 3) f8
    rhs,  # (n_impacts,) f8  [m kg^1/2]
    lengths,  # (n_impacts,) f8  [kg^-1/2]
    limits,  # Limits, of solvers/serial/small_zone.py
    number_starts,  # (n_slots + 1,) i8, of work space; slot k solves zones k, k + n_slots, ...
    index_starts,  # (n_slots + 1,) i8
    # Out:
    multipliers_out,  # (n_impacts,) f8  [m kg^1/2], of the unit rows
    z_out,  # (3 n_unknowns,) f8  [m kg^1/2]
    methods_out,  # (n_zones,) i1, the last that was tried
    solved_out,  # (n_zones,) b1, to the limits
    steps_out,  # (n_zones,) i4
    numbers_out,  # (number_starts[n_slots],) f8, work space, of solvers/serial/small_zone.py
    indices_out,  # (index_starts[n_slots],) i4, work space
):
    slot, n_slots = cuda.grid(1), number_starts.shape[0] - 1
    if slot < n_slots:
        for i in range(slot, zones.shape[0], n_slots):
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
                numbers_out[number_starts[slot] : number_starts[slot + 1]],
                indices_out[index_starts[slot] : index_starts[slot + 1]],
                multipliers_out,
                z_out,
            )


@cuda_kernel
def choose_methods(
    # In:
    impact_offsets,  # (n_zones + 1,) i8
    vertex_offsets,  # (n_zones + 1,) i8
    largest,  # i8, impacts that a zone has at most to be small
    single,  # i1, method for one impact
    # Out:
    methods_out,  # (n_zones,) i1, of solvers/serial/small_zone.py, to begin with
    small_out,  # (n_zones,) b1
    numbers_out,  # (n_zones,) i8, of work space
    indices_out,  # (n_zones,) i8
):
    zone = cuda.grid(1)
    if zone < small_out.shape[0]:
        n = impact_offsets[zone + 1] - impact_offsets[zone]
        methods_out[zone] = single if n == 1 else BLOCK_PIVOT
        small_out[zone] = n <= largest
        work = work_of_small_zone(n, vertex_offsets[zone + 1] - vertex_offsets[zone])
        numbers_out[zone], indices_out[zone] = work
