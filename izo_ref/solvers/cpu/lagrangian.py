"""The augmented-Lagrangian solver: one thread a zone."""

from numba import prange

from izo_ref.base.arrays import AnyFloats, AnyInts, Floats, Indices, Ints, Offsets
from izo_ref.base.compile import cpu_kernel
from izo_ref.base.serial.thread_group import alone
from izo_ref.solvers.serial.descent import minimise_zone
from izo_ref.solvers.serial.settings import Settings


@cpu_kernel
def solve_lagrangian(
    # In:
    zones: Indices,  # (n,) i8, zones to solve
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    unknown_offsets: Offsets,  # (n_zones + 1,) i8, into x; the last 3 of a zone are for pinned ones
    memory_offsets: Offsets,  # (n_zones + 1,) i8
    nodes: AnyInts,  # (n_impacts, 4) u4, 3 times the vertex's number in its zone
    coefficients: AnyFloats,  # (n_impacts, 4) f8 or f4, 0 for pinned vertices
    entries: AnyInts,  # (n_entries,) u4, impacts of each vertex, by their number in the zone
    arms: AnyFloats,  # (n_entries, 3) f8 or f4, coefficient times normal of each entry
    entry_starts: AnyInts,  # (n_unknowns / 3 + 1,) u8, where the entries of each vertex begin
    normals: AnyFloats,  # (n_impacts, 3) f8 or f4
    starts: AnyFloats,  # (n_impacts,) f8 or f4, constraints at x = 0
    metres: AnyFloats,  # (n_impacts,) f8 or f4  [m], violation if a constraint is 1
    curvatures: AnyFloats,  # (n_unknowns,) f8 or f4, w
    mus: Floats,  # (n_zones,) f8, penalty weights at the start
    mu_caps: Floats,  # (n_zones,) f8, largest penalty weights
    first_steps: Floats,  # (n_zones,) f8
    units: Floats,  # (n_zones,) f8  [kg m^2], objective in kg m^2 if the objective is 1
    settings: Settings,  # Settings
    # Out:
    x_out: AnyFloats,  # (n_unknowns,) f8 or f4, displacements
    multipliers_out: AnyFloats,  # (n_impacts,) f8 or f4
    steps_out: Ints,  # (n_zones,) i4
    gaps_out: Floats,  # (n_zones,) f8, relative duality gap of the answer, as the solver sees it
    violations_out: Floats,  # (n_zones,) f8  [m], largest violation of the answer
    trace_out: Floats,  # (n_zones, k, 2) f8, objective [kg m^2] and violation [m]; k = 0: none
    unknown_work_out: AnyFloats,  # (4, n_unknowns) f8 or f4, work space
    impact_work_out: AnyFloats,  # (3, n_impacts) f8 or f4, work space
    memory_out: AnyFloats,  # (n_memory,) f8 or f4, work space
    states_out: Floats,  # (n, n_threads, 9) f8, zeros, work space of each thread of a zone
) -> None:
    """Solve zones, one thread a zone."""
    for number in prange(zones.shape[0]):
        minimise_zone(
            zones[number],
            states_out[number, 0],
            alone(),
            impact_offsets,
            unknown_offsets,
            memory_offsets,
            nodes,
            coefficients,
            entries,
            arms,
            entry_starts,
            normals,
            starts,
            metres,
            curvatures,
            mus,
            mu_caps,
            first_steps,
            units,
            settings,
            x_out,
            multipliers_out,
            steps_out,
            gaps_out,
            violations_out,
            trace_out,
            unknown_work_out,
            impact_work_out,
            memory_out,
        )
