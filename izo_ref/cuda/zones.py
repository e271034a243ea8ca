"""Zones: which impacts are of one, their rows in scaled variables, and the small ones solved.

Impacts that share an unpinned vertex, directly or through others, get one number. Each vertex
begins with its own, and the least one at an impact is handed to the roots of its vertices until
nothing changes: what is left is the least vertex of each zone, whatever the order of threads was.
"""

from numba import cuda

from izo_ref.cuda._jit import cuda_kernel
from izo_ref.serial.rows import scale_row
from izo_ref.serial.small_zone import solve_small_zone


@cuda_kernel
def join_labels(
    # In:
    nodes,  # (n_impacts, 4) i4
    pinned,  # (n_vertices,) b1
    # Out:
    labels_out,  # (n_vertices,) i8, a vertex of the same zone, not above the own number
    changed_out,  # (1,) i8, not 0 if one did
):
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        least = labels_out.shape[0]
        for k in range(4):
            if not pinned[nodes[j, k]]:
                least = min(least, labels_out[nodes[j, k]])
        for k in range(4):
            if not pinned[nodes[j, k]]:
                label = labels_out[nodes[j, k]]
                if label > least:
                    cuda.atomic.min(labels_out, label, least)
                    cuda.atomic.min(labels_out, nodes[j, k], least)
                    changed_out[0] = 1


@cuda_kernel
def shorten_labels(
    # In:
    labels,  # (n_vertices,) i8
    # Out:
    labels_out,  # (n_vertices,) i8, the end of the way from label to label
):
    v = cuda.grid(1)
    if v < labels.shape[0]:
        label = labels[v]
        while labels[label] < label:
            label = labels[label]
        labels_out[v] = label


@cuda_kernel
def components_of(
    # In:
    nodes,  # (n_impacts, 4) i4
    pinned,  # (n_vertices,) b1
    labels,  # (n_vertices,) i8
    # Out:
    components_out,  # (n_impacts,) i8, the smallest unpinned vertex joined, -1 if all pinned
    joined_out,  # (n_vertices,) b1, true for unpinned ones of impacts
):
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        components_out[j] = -1
        for k in range(4):
            if not pinned[nodes[j, k]]:
                components_out[j] = labels[nodes[j, k]]
                joined_out[nodes[j, k]] = True


@cuda_kernel
def are_free(
    # In:
    components,  # (n_impacts,) i8
    # Out:
    free_out,  # (n_impacts,) b1, has a component
):
    j = cuda.grid(1)
    if j < components.shape[0]:
        free_out[j] = components[j] >= 0


@cuda_kernel
def are_first(
    # In:
    keys,  # (n,) i8, ascending
    # Out:
    first_out,  # (n + 1,) b1, not the same as before; and behind the last
):
    i = cuda.grid(1)
    if i <= keys.shape[0]:
        first_out[i] = i == 0 or i == keys.shape[0] or keys[i] != keys[i - 1]


@cuda_kernel
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
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        rhs_out[j], lengths_out[j], hopeless_out[j] = scale_row(
            j,
            nodes,
            weights,
            normals,
            targets,
            inverse_sqrt_masses,
            thickness,
            unknowns_out,
            coefficients_out,
        )


@cuda_kernel
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
    number_starts,  # (n_slots + 1,) i8, of work space; slot k solves zones k, k + n_slots, ...
    index_starts,  # (n_slots + 1,) i8
    # Out:
    multipliers_out,  # (n_impacts,) f8  [m kg^1/2], of the unit rows
    z_out,  # (3 n_unknowns,) f8  [m kg^1/2]
    methods_out,  # (n_zones,) i1, the last that was tried
    solved_out,  # (n_zones,) b1, to the limits
    steps_out,  # (n_zones,) i4
    numbers_out,  # (number_starts[n_slots],) f8, work space, of serial/small_zone.py
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
