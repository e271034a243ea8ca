"""What a step on the device does between detection and solvers: gathers, flags and scatters."""

from numba import cuda

from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.serial.search import block_of
from izo_ref.zones.serial.selection import is_prescribed


@cuda_kernel
def compute_objective_terms(
    # In:
    positions,  # (n_vertices, 3) f8  [m]
    proposed,  # (n_vertices, 3) f8  [m]
    masses,  # (n_vertices,) f8  [kg], 0 for pinned
    # Out:
    terms_out,  # (n_vertices,) f8  [kg m^2], m |x - y|^2
):
    i = cuda.grid(1)
    if i < terms_out.shape[0]:
        total = 0.0
        for axis in range(3):
            offset = positions[i, axis] - proposed[i, axis]
            total += offset * offset
        terms_out[i] = masses[i] * total


@cuda_kernel
def flag_impacts_to_solve(
    # In:
    nodes,  # (n_impacts, 4) i4
    weights,  # (n_impacts, 4) f8
    pinned,  # (n_vertices,) b1
    # Out:
    kept_out,  # (n_impacts,) b1, not between pinned points
):
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        kept_out[j] = not is_prescribed(j, nodes, weights, pinned)


@cuda_kernel
def flag_hopeful_impacts(
    # In:
    nodes,  # (n_impacts, 4) i4
    stuck,  # (n_vertices,) b1
    # Out:
    hopeful_out,  # (n_impacts,) b1, no vertex of a zone that no positions satisfy
):
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        either = stuck[nodes[j, 0]] or stuck[nodes[j, 1]]
        hopeful_out[j] = not (either or stuck[nodes[j, 2]] or stuck[nodes[j, 3]])


@cuda_kernel
def flag_positive(
    # In:
    values,  # (n,) f8
    # Out:
    positive_out,  # (n,) b1
):
    i = cuda.grid(1)
    if i < values.shape[0]:
        positive_out[i] = values[i] > 0.0


@cuda_kernel
def find_blocks(
    # In:
    starts,  # (n_parts + 1,) i8
    # Out:
    parts_out,  # (starts[n_parts],) i8, the part that each is in
):
    i = cuda.grid(1)
    if i < parts_out.shape[0]:
        parts_out[i] = block_of(i, starts)


@cuda_kernel
def flag_changed_zones(
    # In:
    impacts,  # (n_impacts,) i8, zone by zone, ascending in each
    impact_offsets,  # (n_zones + 1,) i8
    first_new,  # i8
    # Out:
    changed_out,  # (n_zones,) b1, has an impact from first_new on
):
    zone = cuda.grid(1)
    if zone < changed_out.shape[0]:
        changed_out[zone] = impacts[impact_offsets[zone + 1] - 1] >= first_new


@cuda_kernel
def flag_stuck_zones(
    # In:
    vertices,  # (n,) i8, of zones
    zone_of,  # (n,) i8
    stuck,  # (n_vertices,) b1
    # Out:
    stuck_out,  # (n_zones,) b1, false; becomes true where one is
):
    i = cuda.grid(1)
    if i < vertices.shape[0] and stuck[vertices[i]]:
        stuck_out[zone_of[i]] = True


@cuda_kernel
def spread_stuck(
    # In:
    vertices,  # (n,) i8, of zones
    zone_of,  # (n,) i8
    zone_stuck,  # (n_zones,) b1
    # Out:
    stuck_out,  # (n_vertices,) b1, becomes true for all of the zone
):
    i = cuda.grid(1)
    if i < vertices.shape[0] and zone_stuck[zone_of[i]]:
        stuck_out[vertices[i]] = True


@cuda_kernel
def flag_zones_to_solve(
    # In:
    changed,  # (n_zones,) b1
    stuck,  # (n_zones,) b1
    # Out:
    chosen_out,  # (n_zones,) b1
):
    zone = cuda.grid(1)
    if zone < changed.shape[0]:
        chosen_out[zone] = changed[zone] and not stuck[zone]


@cuda_kernel
def flag_members(
    # In:
    part_of_each,  # (n,) i8
    chosen,  # (n_parts,) b1
    # Out:
    members_out,  # (n,) b1, its part is chosen
):
    i = cuda.grid(1)
    if i < part_of_each.shape[0]:
        members_out[i] = chosen[part_of_each[i]]


@cuda_kernel
def count_members(
    # In:
    starts,  # (n_parts + 1,) i8
    # Out:
    sizes_out,  # (n_parts,) i8
):
    i = cuda.grid(1)
    if i < sizes_out.shape[0]:
        sizes_out[i] = starts[i + 1] - starts[i]


@cuda_kernel
def number_vertices(
    # In:
    vertices,  # (n,) i8, each once
    # Out:
    places_out,  # (n_vertices,) i4, of each vertex among them; of others nothing
):
    i = cuda.grid(1)
    if i < vertices.shape[0]:
        places_out[vertices[i]] = i


@cuda_kernel
def number_unknowns(
    # In:
    places,  # (n_vertices,) i4
    # Out:
    unknowns_out,  # (n_impacts, 4) i4, vertices become their places, -1 stays
):
    j = cuda.grid(1)
    if j < unknowns_out.shape[0]:
        for k in range(4):
            if unknowns_out[j, k] >= 0:
                unknowns_out[j, k] = places[unknowns_out[j, k]]


@cuda_kernel
def fail_hopeless(
    # In:
    hopeless,  # (n_impacts,) b1, violated and without unknowns
    zone_of,  # (n_impacts,) i8
    # Out:
    solved_out,  # (n_zones,) b1, becomes false
):
    j = cuda.grid(1)
    if j < hopeless.shape[0] and hopeless[j]:
        solved_out[zone_of[j]] = False


@cuda_kernel
def move_vertices(
    # In:
    vertices,  # (n,) i8, zone by zone
    zone_of,  # (n,) i8
    solved,  # (n_zones,) b1
    proposed,  # (n_vertices, 3) f8  [m]
    inverse_sqrt_masses,  # (n_vertices,) f8  [kg^-1/2]
    z,  # (3 n,) f8  [m kg^1/2]
    # Out:
    positions_out,  # (n_vertices, 3) f8  [m], of those in zones that are solved
):
    i = cuda.grid(1)
    if i < vertices.shape[0] and solved[zone_of[i]]:
        vertex = vertices[i]
        for axis in range(3):
            displacement = inverse_sqrt_masses[vertex] * z[3 * i + axis]
            positions_out[vertex, axis] = proposed[vertex, axis] + displacement


@cuda_kernel
def keep_multipliers(
    # In:
    rows,  # (n,) i8, impacts
    zone_of,  # (n,) i8
    solved,  # (n_zones,) b1
    scaled,  # (n,) f8  [m kg^1/2], multipliers of the unit rows
    lengths,  # (n,) f8  [kg^-1/2]
    # Out:
    multipliers_out,  # (n_impacts,) f8  [kg], of those in zones that are solved
    active_out,  # (n_impacts,) b1
):
    i = cuda.grid(1)
    if i < rows.shape[0] and solved[zone_of[i]]:
        multipliers_out[rows[i]] = scaled[i] / lengths[i]
        active_out[rows[i]] = scaled[i] > 0.0


@cuda_kernel
def put_rows(
    # In:
    index,  # (m,) i8, each once
    rows,  # (m, k) f8 or b1
    # Out:
    values_out,  # (n, k) f8 or b1
):
    i = cuda.grid(1)
    if i < index.shape[0]:
        for k in range(rows.shape[1]):
            values_out[index[i], k] = rows[i, k]


@cuda_kernel
def negate_flags(
    # In:
    flags,  # (n,) b1
    # Out:
    opposite_out,  # (n,) b1
):
    i = cuda.grid(1)
    if i < flags.shape[0]:
        opposite_out[i] = not flags[i]
