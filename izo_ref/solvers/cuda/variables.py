"""Zones side by side to the variables of the augmented Lagrangian, and answers back.

`izo_ref/solvers/augmented_lagrangian.py` is the same on the processor.
"""

from numba import cuda

from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import block
from izo_ref.base.serial.search import first_not_below
from izo_ref.base.serial.thread_group import group_maxima, group_sum

# Variables of the solver: those of SPEC 5 in units of the zone, or metres with the objective of a
# system that divides by the total mass, or takes the mean of 1 / m.
SCALED, BY_TOTAL_MASS, BY_MEAN_INVERSE = range(3)


@cuda_kernel
def scale_zones(
    # In:
    zones,  # (n,) i8
    impact_offsets,  # (n_zones + 1,) i8
    vertex_offsets,  # (n_zones + 1,) i8
    vertices,  # (n_free,) i8, of the zones
    inverse_sqrt_masses,  # (n_vertices,) f8  [kg^-1/2]
    rhs,  # (n_impacts,) f8  [m kg^1/2]
    variables,  # i8, SCALED, BY_TOTAL_MASS or BY_MEAN_INVERSE
    step,  # f8, the first, and
    step_per_vertex,  # f8, so much more for each
    # Out:
    scales_out,  # (n_zones,) f8, of these zones: of z [m kg^1/2], or of w [1/kg] in metres
    first_steps_out,  # (n_zones,) f8, of these zones
):
    if cuda.blockIdx.x < zones.shape[0]:
        zone, group, largest, total = zones[cuda.blockIdx.x], block(), 0.0, 0.0
        first, n = vertex_offsets[zone], vertex_offsets[zone + 1] - vertex_offsets[zone]
        if variables == SCALED:
            for j in range(
                impact_offsets[zone] + group.rank(), impact_offsets[zone + 1], group.size()
            ):
                largest = max(largest, abs(rhs[j]))
            largest, _ = group_maxima(group, largest, 0.0)
            scale = largest if largest > 0.0 else 1.0
        else:
            for i in range(first + group.rank(), first + n, group.size()):
                inverse = inverse_sqrt_masses[vertices[i]] ** 2
                total += inverse if variables == BY_MEAN_INVERSE else 1.0 / inverse
            total = group_sum(group, total)
            scale = total / n if variables == BY_MEAN_INVERSE else 2.0 / total
        scales_out[zone], first_steps_out[zone] = scale, step + step_per_vertex * n


@cuda_kernel
def scale_rows(
    # In:
    zone_of,  # (n_impacts,) i8
    vertex_offsets,  # (n_zones + 1,) i8
    vertices,  # (n_free,) i8, of the zones
    inverse_sqrt_masses,  # (n_vertices,) f8  [kg^-1/2]
    scales,  # (n_zones,) f8
    variables,  # i8
    chosen,  # (n_zones,) b1
    unknowns,  # (n_impacts, 4) i4, -1 for pinned
    rhs,  # (n_impacts,) f8  [m kg^1/2]
    lengths,  # (n_impacts,) f8  [kg^-1/2]
    # Out:
    nodes_out,  # (n_impacts, 4) u4, 3 times the zone's own vertex
    coefficients_out,  # (n_impacts, 4) f8, of unit rows; become those of x, 0 for pinned
    starts_out,  # (n_impacts,) f8
    metres_out,  # (n_impacts,) f8  [m]
    is_entry_out,  # (4 n_impacts,) b1, of a zone that is chosen, and not pinned
):
    j = cuda.grid(1)
    if j < rhs.shape[0]:
        zone, is_scaled = zone_of[j], variables == SCALED
        first, pinned = vertex_offsets[zone], vertex_offsets[zone + 1] - vertex_offsets[zone]
        starts_out[j] = rhs[j] / scales[zone] if is_scaled else rhs[j] * lengths[j]
        metres_out[j] = scales[zone] * lengths[j] if is_scaled else 1.0
        for k in range(4):
            i = unknowns[j, k]
            is_free = i >= 0
            nodes_out[j, k] = 3 * (i - first if is_free else pinned)
            is_entry_out[4 * j + k] = is_free and chosen[zone]
            if not is_free:
                coefficients_out[j, k] = 0.0
            elif not is_scaled:
                coefficients_out[j, k] *= lengths[j] / inverse_sqrt_masses[vertices[i]]


@cuda_kernel
def compute_curvatures(
    # In:
    zone_of,  # (n_free,) i8
    vertices,  # (n_free,) i8, of the zones
    inverse_sqrt_masses,  # (n_vertices,) f8  [kg^-1/2]
    scales,  # (n_zones,) f8  [1/kg]
    # Out:
    curvatures_out,  # (n_unknowns,) f8, w of these vertices
):
    i = cuda.grid(1)
    if i < vertices.shape[0]:
        curvature = scales[zone_of[i]] / inverse_sqrt_masses[vertices[i]] ** 2
        for axis in range(3):
            curvatures_out[3 * (i + zone_of[i]) + axis] = curvature


@cuda_kernel
def find_entry_vertices(
    # In:
    entries,  # (n_entries,) i8, 4 j + k
    zone_of,  # (n_impacts,) i8
    unknowns,  # (n_impacts, 4) i4
    # Out:
    vertices_out,  # (n_entries,) i8, with one more in each zone that pinned ones share
):
    e = cuda.grid(1)
    if e < entries.shape[0]:
        j, k = entries[e] // 4, entries[e] % 4
        vertices_out[e] = unknowns[j, k] + zone_of[j]


@cuda_kernel
def compute_arms(
    # In:
    entries,  # (n_entries,) i8, 4 j + k, by vertex
    zone_of,  # (n_impacts,) i8
    impact_offsets,  # (n_zones + 1,) i8
    coefficients,  # (n_impacts, 4) f8
    normals,  # (n_impacts, 3) f8
    # Out:
    entries_out,  # (n_entries,) u4, the zone's own impact
    arms_out,  # (n_entries, 3) f8, coefficient times normal
):
    e = cuda.grid(1)
    if e < entries.shape[0]:
        j, k = entries[e] // 4, entries[e] % 4
        entries_out[e] = j - impact_offsets[zone_of[j]]
        for axis in range(3):
            arms_out[e, axis] = coefficients[j, k] * normals[j, axis]


@cuda_kernel
def find_vertex_starts(
    # In:
    vertices,  # (n_entries,) i8, ascending
    # Out:
    starts_out,  # (n_vertices + 1,) u8, where the entries of each begin
):
    vertex = cuda.grid(1)
    if vertex < starts_out.shape[0]:
        starts_out[vertex] = first_not_below(vertex, vertices)


@cuda_kernel
def sum_sizes_on_vertices(
    # In:
    entries,  # (n_entries,) i8, 4 j + k, by vertex
    entry_starts,  # (n_vertices + 1,) u8
    coefficients,  # (n_impacts, 4) f8
    # Out:
    sizes_out,  # (n_vertices,) f8, sum of |coefficient| over the entries of each
):
    vertex = cuda.grid(1)
    if vertex < sizes_out.shape[0]:
        size = 0.0
        for e in range(entry_starts[vertex], entry_starts[vertex + 1]):
            size += abs(coefficients[entries[e] // 4, entries[e] % 4])
        sizes_out[vertex] = size


@cuda_kernel
def bound_couplings(
    # In:
    zones,  # (n,) i8
    impact_offsets,  # (n_zones + 1,) i8
    vertex_offsets,  # (n_zones + 1,) i8
    nodes,  # (n_impacts, 4) u4, 3 times the zone's own vertex
    coefficients,  # (n_impacts, 4) f8, 0 for pinned
    sizes,  # (n_vertices,) f8, with one more in each zone that pinned ones share
    # Out:
    couplings_out,  # (n_zones,) f8, of these zones: a bound of the largest eigenvalue of C C^T
):
    if cuda.blockIdx.x < zones.shape[0]:
        zone, group = zones[cuda.blockIdx.x], block()
        # the diagonal; less only where rows have no unknowns
        largest, first = 1.0, vertex_offsets[zone] + zone
        for j in range(impact_offsets[zone] + group.rank(), impact_offsets[zone + 1], group.size()):
            row_sum = 0.0
            for k in range(4):
                row_sum += abs(coefficients[j, k]) * sizes[first + nodes[j, k] // 3]
            largest = max(largest, row_sum)
        couplings_out[zone], _ = group_maxima(group, largest, 1.0)


@cuda_kernel
def find_zone_offsets(
    # In:
    vertex_offsets,  # (n_zones + 1,) i8
    vectors,  # i8, of memory, as long as x
    numbers,  # i8, of memory beside these
    # Out:
    row_offsets_out,  # (n_zones + 1,) i8, of unknowns
    memory_offsets_out,  # (n_zones + 1,) i8
):
    zone = cuda.grid(1)
    if zone < vertex_offsets.shape[0]:
        row_offsets_out[zone] = 3 * (vertex_offsets[zone] + zone)
        memory_offsets_out[zone] = vectors * row_offsets_out[zone] + numbers * zone


@cuda_kernel
def take_answers(
    # In:
    chosen,  # (n_zones,) b1
    zone_of_impact,  # (n_impacts,) i8
    zone_of_vertex,  # (n_free,) i8
    vertices,  # (n_free,) i8, of the zones
    inverse_sqrt_masses,  # (n_vertices,) f8  [kg^-1/2]
    lengths,  # (n_impacts,) f8  [kg^-1/2]
    scales,  # (n_zones,) f8
    variables,  # i8
    x,  # (n_unknowns,) f8
    multipliers,  # (n_impacts,) f8
    # Out:
    multipliers_out,  # (n_impacts,) f8  [m kg^1/2]
    z_out,  # (3 n_free,) f8  [m kg^1/2]
):
    i = cuda.grid(1)
    if i < zone_of_impact.shape[0] and chosen[zone_of_impact[i]]:
        scale = scales[zone_of_impact[i]]
        factor = scale if variables == SCALED else lengths[i] / scale
        multipliers_out[i] = factor * multipliers[i]
    if i < zone_of_vertex.shape[0] and chosen[zone_of_vertex[i]]:
        zone = zone_of_vertex[i]
        scale = scales[zone] if variables == SCALED else 1.0 / inverse_sqrt_masses[vertices[i]]
        for axis in range(3):
            z_out[3 * i + axis] = scale * x[3 * (i + zone) + axis]
