"""Kernels of a step on a GPU, between detection and solvers: gathers, flags and scatters."""

from numba import cuda

from izo_ref.base.arrays import (
    AnyArray,
    Flags,
    Floats,
    Indices,
    Ints,
    Masses,
    Multipliers,
    Nodes,
    Normals,
    Offsets,
    Positions,
    Weights,
)
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.zones.serial.selection import is_hopeful, is_prescribed


@cuda_kernel
def compute_objective_terms(
    # In:
    positions: Positions,  # (n_vertices, 3) f8  [m]
    proposed: Positions,  # (n_vertices, 3) f8  [m]
    masses: Masses,  # (n_vertices,) f8  [kg], 0 for pinned vertices
    # Out:
    terms_out: Floats,  # (n_vertices,) f8  [kg m^2]
) -> None:
    """Compute m |x - y|^2 of each vertex."""
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
    nodes: Nodes,  # (n_impacts, 4) i4
    weights: Weights,  # (n_impacts, 4) f8
    pinned: Flags,  # (n_vertices,) b1
    # Out:
    kept_out: Flags,  # (n_impacts,) b1
) -> None:
    """Mark the impacts that are not between pinned points."""
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        kept_out[j] = not is_prescribed(j, nodes, weights, pinned)


@cuda_kernel
def flag_hopeful_impacts(
    # In:
    positions: Positions,  # (n_vertices, 3) f8  [m]
    nodes: Nodes,  # (n_impacts, 4) i4
    weights: Weights,  # (n_impacts, 4) f8
    normals: Normals,  # (n_impacts, 3) f8
    stuck: Flags,  # (n_vertices,) b1
    thickness: float,  # f8  [m]
    # Out:
    hopeful_out: Flags,  # (n_impacts,) b1
) -> None:
    """Mark the impacts that a solver could mend."""
    j = cuda.grid(1)
    if j < nodes.shape[0]:
        hopeful_out[j] = is_hopeful(j, positions, nodes, weights, normals, stuck, thickness)


@cuda_kernel
def flag_positive(
    # In:
    values: Floats,  # (n,) f8
    # Out:
    positive_out: Flags,  # (n,) b1
) -> None:
    """Mark the positive values."""
    i = cuda.grid(1)
    if i < values.shape[0]:
        positive_out[i] = values[i] > 0.0


@cuda_kernel
def flag_changed_zones(
    # In:
    impacts: Indices,  # (n_impacts,) i8, zone by zone, ascending in each
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    first_new: int,  # i8
    # Out:
    changed_out: Flags,  # (n_zones,) b1
) -> None:
    """Mark the zones that have the impact `first_new` or a later one."""
    zone = cuda.grid(1)
    if zone < changed_out.shape[0]:
        changed_out[zone] = impacts[impact_offsets[zone + 1] - 1] >= first_new


@cuda_kernel
def flag_stuck_zones(
    # In:
    vertices: Indices,  # (n,) i8, of zones
    zone_of: Indices,  # (n,) i8, the zone of each of these vertices
    stuck: Flags,  # (n_vertices,) b1
    # Out:
    stuck_out: Flags,  # (n_zones,) b1, false before; becomes true where a vertex is stuck
) -> None:
    """Mark the zones that have a stuck vertex."""
    i = cuda.grid(1)
    if i < vertices.shape[0] and stuck[vertices[i]]:
        stuck_out[zone_of[i]] = True


@cuda_kernel
def spread_stuck(
    # In:
    vertices: Indices,  # (n,) i8, of zones
    zone_of: Indices,  # (n,) i8, the zone of each of these vertices
    zone_stuck: Flags,  # (n_zones,) b1
    # Out:
    stuck_out: Flags,  # (n_vertices,) b1, becomes true for all vertices of stuck zones
) -> None:
    """Mark all vertices of stuck zones as stuck."""
    i = cuda.grid(1)
    if i < vertices.shape[0] and zone_stuck[zone_of[i]]:
        stuck_out[vertices[i]] = True


@cuda_kernel
def flag_zones_to_solve(
    # In:
    changed: Flags,  # (n_zones,) b1
    stuck: Flags,  # (n_zones,) b1
    # Out:
    chosen_out: Flags,  # (n_zones,) b1
) -> None:
    """Mark the zones that changed and are not stuck."""
    zone = cuda.grid(1)
    if zone < changed.shape[0]:
        chosen_out[zone] = changed[zone] and not stuck[zone]


@cuda_kernel
def number_vertices(
    # In:
    vertices: Indices,  # (n,) i8, each once
    # Out:
    places_out: Ints,  # (n_vertices,) i4, entries of other vertices are not written
) -> None:
    """Write the place of each vertex in a list of vertices."""
    i = cuda.grid(1)
    if i < vertices.shape[0]:
        places_out[vertices[i]] = i


@cuda_kernel
def number_unknowns(
    # In:
    places: Ints,  # (n_vertices,) i4
    # Out:
    unknowns_out: Ints,  # (n_impacts, 4) i4, vertices before, places after; -1 stays
) -> None:
    """Replace vertices by their places."""
    j = cuda.grid(1)
    if j < unknowns_out.shape[0]:
        for k in range(4):
            if unknowns_out[j, k] >= 0:
                unknowns_out[j, k] = places[unknowns_out[j, k]]


@cuda_kernel
def fail_hopeless(
    # In:
    hopeless: Flags,  # (n_impacts,) b1, violated and without unknowns
    zone_of: Indices,  # (n_impacts,) i8
    # Out:
    solved_out: Flags,  # (n_zones,) b1, becomes false where an impact is hopeless
) -> None:
    """Mark the zones with a hopeless impact as not solved."""
    j = cuda.grid(1)
    if j < hopeless.shape[0] and hopeless[j]:
        solved_out[zone_of[j]] = False


@cuda_kernel
def move_vertices(
    # In:
    vertices: Indices,  # (n,) i8, zone by zone
    zone_of: Indices,  # (n,) i8, the zone of each of these vertices
    solved: Flags,  # (n_zones,) b1
    proposed: Positions,  # (n_vertices, 3) f8  [m]
    inverse_sqrt_masses: Floats,  # (n_vertices,) f8  [kg^-1/2]
    z: Floats,  # (3 n,) f8  [m kg^1/2]
    # Out:
    positions_out: Positions,  # (n_vertices, 3) f8  [m], entries of other vertices stay
) -> None:
    """Move the vertices of solved zones to their solution."""
    i = cuda.grid(1)
    if i < vertices.shape[0] and solved[zone_of[i]]:
        vertex = vertices[i]
        for axis in range(3):
            displacement = inverse_sqrt_masses[vertex] * z[3 * i + axis]
            positions_out[vertex, axis] = proposed[vertex, axis] + displacement


@cuda_kernel
def keep_multipliers(
    # In:
    impacts: Indices,  # (n,) i8, zone by zone
    zone_of: Indices,  # (n,) i8, the zone of each of these impacts
    solved: Flags,  # (n_zones,) b1
    scaled: Floats,  # (n,) f8  [m kg^1/2], multipliers of the constraints in scaled variables
    lengths: Floats,  # (n,) f8  [kg^-1/2], by which the constraints were divided
    # Out:
    multipliers_out: Multipliers,  # (n_impacts,) f8  [kg], entries of other impacts stay
    active_out: Flags,  # (n_impacts,) b1, entries of other impacts stay
) -> None:
    """Keep the multipliers of solved zones, scaled back to the impacts."""
    i = cuda.grid(1)
    if i < impacts.shape[0] and solved[zone_of[i]]:
        multipliers_out[impacts[i]] = scaled[i] / lengths[i]
        active_out[impacts[i]] = scaled[i] > 0.0


@cuda_kernel
def put_rows(
    # In:
    index: Indices,  # (m,) i8, each once
    rows: AnyArray,  # (m, k) f8 or b1
    # Out:
    values_out: AnyArray,  # (n, k) f8 or b1
) -> None:
    """Write rows to the places of an index."""
    i = cuda.grid(1)
    if i < index.shape[0]:
        for k in range(rows.shape[1]):
            values_out[index[i], k] = rows[i, k]


@cuda_kernel
def negate_flags(
    # In:
    flags: Flags,  # (n,) b1
    # Out:
    opposite_out: Flags,  # (n,) b1
) -> None:
    """Write the opposite of each flag."""
    i = cuda.grid(1)
    if i < flags.shape[0]:
        opposite_out[i] = not flags[i]
