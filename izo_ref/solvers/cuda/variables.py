"""From zones side by side to the variables of the augmented Lagrangian, and back.

`solvers/variables.py` does the same on the CPU. x has a row for each unpinned
vertex of a zone, and one more row at the end of the zone that all its pinned vertices share.
"""

from numba import cuda

from izo_ref.base.arrays import (
    AnyInts,
    Flags,
    Floats,
    Indices,
    Multipliers,
    Nodes,
    Normals,
    Offsets,
)
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import block
from izo_ref.base.serial.search import first_not_below
from izo_ref.base.serial.thread_group import group_maxima, group_sum

# Variables of the solver: the scaled variables of docs/method section 5 in units of the zone; or
# metres, with the objective of a system that divides by the total mass, or that takes the mean of 1
# / m.
SCALED, BY_TOTAL_MASS, BY_MEAN_INVERSE = range(3)


@cuda_kernel
def scale_zones(
    # In:
    zones: Indices,  # (n,) i8
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    vertices: Indices,  # (n_unpinned,) i8, vertices of the zones
    inverse_sqrt_masses: Floats,  # (n_vertices,) f8  [kg^-1/2]
    rhs: Floats,  # (n_impacts,) f8  [m kg^1/2]
    variables: int,  # i8, SCALED, BY_TOTAL_MASS or BY_MEAN_INVERSE
    step: float,  # f8, the first step of a zone without vertices
    step_per_vertex: float,  # f8, added to it for each unpinned vertex
    # Out:
    scales_out: Floats,  # (n_zones,) f8, scale of z [m kg^1/2], or of w [1/kg], of these zones
    first_steps_out: Floats,  # (n_zones,) f8, written for these zones
) -> None:
    """Compute the scale of the variables and the first step of each zone, one block a zone."""
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
                inverse = float(inverse_sqrt_masses[vertices[i]]) ** 2
                total += inverse if variables == BY_MEAN_INVERSE else 1.0 / inverse
            total = group_sum(group, total)
            scale = total / n if variables == BY_MEAN_INVERSE else 2.0 / total
        scales_out[zone], first_steps_out[zone] = scale, step + step_per_vertex * n


@cuda_kernel
def convert_constraints(
    # In:
    zone_of_impact: Indices,  # (n_impacts,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    vertices: Indices,  # (n_unpinned,) i8, vertices of the zones
    inverse_sqrt_masses: Floats,  # (n_vertices,) f8  [kg^-1/2]
    scales: Floats,  # (n_zones,) f8
    variables: int,  # i8
    unknowns: Nodes,  # (n_impacts, 4) i4, -1 for pinned vertices
    rhs: Floats,  # (n_impacts,) f8  [m kg^1/2]
    lengths: Floats,  # (n_impacts,) f8  [kg^-1/2]
    # Out:
    nodes_out: AnyInts,  # (n_impacts, 4) u4, 3 times the vertex's number in its zone
    coefficients_out: Floats,  # (n_impacts, 4) f8, of unit rows on entry; of x, 0 for pinned ones
    starts_out: Floats,  # (n_impacts,) f8, constraints at x = 0
    metres_out: Floats,  # (n_impacts,) f8  [m], violation if a constraint is 1
    is_entry_out: Flags,  # (4 n_impacts,) b1, an unpinned vertex
) -> None:
    """Convert constraints from scaled variables to those of the solver."""
    j = cuda.grid(1)
    if j < rhs.shape[0]:
        zone, is_scaled = zone_of_impact[j], variables == SCALED
        first, pinned = vertex_offsets[zone], vertex_offsets[zone + 1] - vertex_offsets[zone]
        starts_out[j] = rhs[j] / scales[zone] if is_scaled else rhs[j] * lengths[j]
        metres_out[j] = scales[zone] * lengths[j] if is_scaled else 1.0
        for k in range(4):
            i = unknowns[j, k]
            is_unpinned = i >= 0
            nodes_out[j, k] = 3 * (i - first if is_unpinned else pinned)
            is_entry_out[4 * j + k] = is_unpinned
            if not is_unpinned:
                coefficients_out[j, k] = 0.0
            elif not is_scaled:
                coefficients_out[j, k] *= lengths[j] / inverse_sqrt_masses[vertices[i]]


@cuda_kernel
def compute_curvatures(
    # In:
    zone_of_vertex: Indices,  # (n_unpinned,) i8
    vertices: Indices,  # (n_unpinned,) i8, vertices of the zones
    inverse_sqrt_masses: Floats,  # (n_vertices,) f8  [kg^-1/2]
    scales: Floats,  # (n_zones,) f8  [1/kg]
    # Out:
    curvatures_out: Floats,  # (n_unknowns,) f8, w, written for unpinned vertices
) -> None:
    """Compute the curvatures w of a preset's objective."""
    i = cuda.grid(1)
    if i < vertices.shape[0]:
        curvature = scales[zone_of_vertex[i]] / inverse_sqrt_masses[vertices[i]] ** 2
        for axis in range(3):
            curvatures_out[3 * (i + zone_of_vertex[i]) + axis] = curvature


@cuda_kernel
def find_entry_vertices(
    # In:
    entries: Indices,  # (n_entries,) i8, 4 j + k
    zone_of_impact: Indices,  # (n_impacts,) i8
    unknowns: Nodes,  # (n_impacts, 4) i4
    # Out:
    vertices_out: Indices,  # (n_entries,) i8, row of x
) -> None:
    """Find the row of x of each entry."""
    e = cuda.grid(1)
    if e < entries.shape[0]:
        j, k = entries[e] // 4, entries[e] % 4
        vertices_out[e] = unknowns[j, k] + zone_of_impact[j]


@cuda_kernel
def compute_arms(
    # In:
    entries: Indices,  # (n_entries,) i8, 4 j + k, vertex by vertex
    zone_of_impact: Indices,  # (n_impacts,) i8
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    coefficients: Floats,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    # Out:
    entries_out: AnyInts,  # (n_entries,) u4, the impact's number in its zone
    arms_out: Floats,  # (n_entries, 3) f8, coefficient times normal
) -> None:
    """Compute the coefficient times the normal of each entry."""
    e = cuda.grid(1)
    if e < entries.shape[0]:
        j, k = entries[e] // 4, entries[e] % 4
        entries_out[e] = j - impact_offsets[zone_of_impact[j]]
        for axis in range(3):
            arms_out[e, axis] = coefficients[j, k] * normals[j, axis]


@cuda_kernel
def find_vertex_starts(
    # In:
    vertices: Indices,  # (n_entries,) i8, ascending
    # Out:
    starts_out: AnyInts,  # (n_vertices + 1,) u8, where the entries of each vertex begin
) -> None:
    """Find where the entries of each vertex begin."""
    vertex = cuda.grid(1)
    if vertex < starts_out.shape[0]:
        starts_out[vertex] = first_not_below(vertex, vertices)


@cuda_kernel
def sum_sizes_on_vertices(
    # In:
    entries: Indices,  # (n_entries,) i8, 4 j + k, vertex by vertex
    entry_starts: AnyInts,  # (n_vertices + 1,) u8
    coefficients: Floats,  # (n_impacts, 4) f8
    # Out:
    sizes_out: Floats,  # (n_vertices,) f8, sum of |coefficient| over the entries of each vertex
) -> None:
    """Sum the sizes of the coefficients on each vertex."""
    vertex = cuda.grid(1)
    if vertex < sizes_out.shape[0]:
        size = 0.0
        for e in range(entry_starts[vertex], entry_starts[vertex + 1]):
            size += abs(coefficients[entries[e] // 4, entries[e] % 4])
        sizes_out[vertex] = size


@cuda_kernel
def bound_couplings(
    # In:
    zones: Indices,  # (n,) i8
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    nodes: AnyInts,  # (n_impacts, 4) u4, 3 times the vertex's number in its zone
    coefficients: Floats,  # (n_impacts, 4) f8, 0 for pinned vertices
    sizes: Floats,  # (n_vertices,) f8, of each row of x
    # Out:
    couplings_out: Floats,  # (n_zones,) f8, written for these zones
) -> None:
    """Bound the largest eigenvalue of C C^T by its largest row sum, one block a zone."""
    if cuda.blockIdx.x < zones.shape[0]:
        zone, group = zones[cuda.blockIdx.x], block()
        # The diagonal of C C^T is 1. Row sums are less only if all vertices of an impact are
        # pinned.
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
    vertex_offsets: Offsets,  # (n_zones + 1,) i8
    vectors: int,  # i8, vectors in the memory of a direction, as long as x
    numbers: int,  # i8, numbers in this memory besides the vectors
    # Out:
    unknown_offsets_out: Offsets,  # (n_zones + 1,) i8, where x of each zone begins
    memory_offsets_out: Offsets,  # (n_zones + 1,) i8, where the memory of each zone begins
) -> None:
    """Find where x and the memory of each zone begin."""
    zone = cuda.grid(1)
    if zone < vertex_offsets.shape[0]:
        unknown_offsets_out[zone] = 3 * (vertex_offsets[zone] + zone)
        memory_offsets_out[zone] = vectors * unknown_offsets_out[zone] + numbers * zone


@cuda_kernel
def take_answers(
    # In:
    zone_of_impact: Indices,  # (n_impacts,) i8
    zone_of_vertex: Indices,  # (n_unpinned,) i8
    vertices: Indices,  # (n_unpinned,) i8, vertices of the zones
    inverse_sqrt_masses: Floats,  # (n_vertices,) f8  [kg^-1/2]
    lengths: Floats,  # (n_impacts,) f8  [kg^-1/2]
    scales: Floats,  # (n_zones,) f8
    variables: int,  # i8
    x: Floats,  # (n_unknowns,) f8
    multipliers: Multipliers,  # (n_impacts,) f8
    # Out:
    multipliers_out: Multipliers,  # (n_impacts,) f8  [m kg^1/2]
    z_out: Floats,  # (3 n_unpinned,) f8  [m kg^1/2]
) -> None:
    """Convert x and the multipliers back to scaled variables."""
    i = cuda.grid(1)
    if i < zone_of_impact.shape[0]:
        scale = scales[zone_of_impact[i]]
        factor = scale if variables == SCALED else lengths[i] / scale
        multipliers_out[i] = factor * multipliers[i]
    if i < zone_of_vertex.shape[0]:
        zone = zone_of_vertex[i]
        scale = scales[zone] if variables == SCALED else 1.0 / inverse_sqrt_masses[vertices[i]]
        for axis in range(3):
            z_out[3 * i + axis] = scale * x[3 * (i + zone) + axis]
