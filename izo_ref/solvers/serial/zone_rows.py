"""Write the constraints of all zones of a step, by a thread group."""

from izo_ref.base.arrays import Indices, Ints
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.constraints import scale_constraint
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers, ZoneRows
from izo_ref.zones.serial import listed_zones as listed
from izo_ref.zones.serial.group_records import StepArrays
from izo_ref.zones.serial.listed_zones import ListedZones, all_fit


@compiled
def write_rows(
    group: ThreadGroup,
    zones: ListedZones,
    inputs: StepArrays,
    rows_out: ZoneRows,
    answers_out: ZoneAnswers,
    places_out: Ints,
    sizes_out: Indices,
    counts_out: Indices,
) -> None:
    """Write the constraints of all zones, and begin all counts anew.

    Args:
        group: The threads.
        zones: The zones, which may not fit: then nothing is to be done.
        inputs: The step, with the last solution, in which new impacts are not active.
        rows_out: The constraints are written.
        answers_out: All zones become unsolved, and get the multipliers of the last solution.
        places_out: (n_vertices,) i4, the place of each vertex in those of the zones; the entries
            of other vertices are not written.
        sizes_out: (N_SIZES,) i8, how much is to be done.
        counts_out: (N_COUNTS,) i8, what the CPU reads.
    """
    rank, size = group.rank(), group.size()
    fits = all_fit(zones, inputs.nodes.shape[0]) and _have_room(zones, rows_out, answers_out)
    if rank == 0:
        _begin_counts(zones, fits, sizes_out, counts_out)
    if fits:
        for zone in range(rank, zones.counts[listed.ZONES], size):
            answers_out.solved[zone] = False
        for i in range(rank, zones.counts[listed.VERTICES], size):
            vertex = zones.vertices[i]
            places_out[vertex] = i
            for axis in range(3):
                rows_out.positions[i, axis] = inputs.proposed[vertex, axis]
        group.wait()
        for i in range(rank, zones.counts[listed.IMPACTS], size):
            impact = zones.impacts[i]
            _write_row(i, impact, inputs, places_out, rows_out)
            last = inputs.multipliers[impact] if inputs.active[impact] else 0.0
            answers_out.multipliers[i] = last * rows_out.lengths[i]


@compiled
def _have_room(zones: ListedZones, rows: ZoneRows, answers: ZoneAnswers) -> bool:
    """Return whether the constraints and the answers have room for all zones."""
    return (
        zones.counts[listed.ZONES] <= answers.solved.shape[0]
        and zones.counts[listed.IMPACTS] <= rows.rhs.shape[0]
        and 3 * zones.counts[listed.VERTICES] <= answers.z.shape[0]
    )


@compiled
def _begin_counts(zones: ListedZones, fits: bool, sizes_out: Indices, counts_out: Indices) -> None:
    """Write how much is to be done, and begin the counts that the CPU reads."""
    for k in range(at.N_SIZES):
        sizes_out[k] = 0
    for k in range(at.N_COUNTS):
        counts_out[k] = 0
    counts_out[at.ZONES_NEEDED] = zones.counts[listed.ZONES]
    counts_out[at.IMPACTS_NEEDED] = zones.counts[listed.IMPACTS]
    counts_out[at.VERTICES_NEEDED] = zones.counts[listed.VERTICES]
    if fits:
        sizes_out[at.ZONES] = zones.counts[listed.ZONES]
        sizes_out[at.IMPACTS] = zones.counts[listed.IMPACTS]
        sizes_out[at.VERTICES] = zones.counts[listed.VERTICES]
        sizes_out[at.SMALL] = zones.counts[listed.SMALL]
        sizes_out[at.MIDDLE] = zones.counts[listed.MIDDLE]
        sizes_out[at.LARGE] = zones.counts[listed.LARGE]
        sizes_out[at.OF_STEP] = zones.counts[listed.OF_STEP]


@compiled
def _write_row(i: int, impact: int, inputs: StepArrays, places: Ints, rows_out: ZoneRows) -> None:
    """Write the constraint of an impact to row i."""
    own, row = slice(impact, impact + 1), slice(i, i + 1)
    unknowns = rows_out.unknowns[row]
    rows_out.rhs[i], rows_out.lengths[i], rows_out.hopeless[i] = scale_constraint(
        0,
        inputs.nodes[own],
        inputs.weights[own],
        inputs.normals[own],
        inputs.proposed,
        inputs.inverse_sqrt_masses,
        inputs.thickness,
        unknowns,
        rows_out.coefficients[row],
    )
    for k in range(4):
        if unknowns[0, k] >= 0:
            unknowns[0, k] = places[unknowns[0, k]]
    for axis in range(3):
        rows_out.normals[i, axis] = inputs.normals[impact, axis]
