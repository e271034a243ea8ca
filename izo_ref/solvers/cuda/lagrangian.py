"""The augmented-Lagrangian solver: one block a zone, or all blocks of a launch for a large zone.

Source: XRTailor documentation, "Impact Zone Optimization", figure `gpu_architecture`.
"""

from numba import cuda

from izo_ref.base.arrays import AnyFloats, AnyInts, Flags, Floats, Indices, Ints, Offsets
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import block, grid
from izo_ref.solvers.serial.descent import minimise_zone
from izo_ref.solvers.serial.settings import Settings


@cuda_kernel
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
    """Solve zones, one block a zone."""
    if cuda.blockIdx.x < zones.shape[0]:
        minimise_zone(
            zones[cuda.blockIdx.x],
            states_out[cuda.blockIdx.x, cuda.threadIdx.x],
            block(),
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


@cuda_kernel
def solve_lagrangian_by_grid(
    # In:
    zones: Indices,  # (1,) i8, the zone to solve
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    unknown_offsets: Offsets,  # (n_zones + 1,) i8, into x; the last 3 of a zone are for pinned ones
    memory_offsets: Offsets,  # (n_zones + 1,) i8
    nodes: AnyInts,  # (n_impacts, 4) u4, 3 times the vertex's number in its zone
    coefficients: Floats,  # (n_impacts, 4) f8, 0 for pinned vertices
    entries: AnyInts,  # (n_entries,) u4, impacts of each vertex, by their number in the zone
    arms: Floats,  # (n_entries, 3) f8, coefficient times normal of each entry
    entry_starts: AnyInts,  # (n_unknowns / 3 + 1,) u8, where the entries of each vertex begin
    normals: Floats,  # (n_impacts, 3) f8
    starts: Floats,  # (n_impacts,) f8, constraints at x = 0
    metres: Floats,  # (n_impacts,) f8  [m], violation if a constraint is 1
    curvatures: Floats,  # (n_unknowns,) f8, w
    mus: Floats,  # (n_zones,) f8, penalty weights at the start
    mu_caps: Floats,  # (n_zones,) f8, largest penalty weights
    first_steps: Floats,  # (n_zones,) f8
    units: Floats,  # (n_zones,) f8  [kg m^2], objective in kg m^2 if the objective is 1
    settings: Settings,  # Settings
    # Out:
    x_out: Floats,  # (n_unknowns,) f8, displacements
    multipliers_out: Floats,  # (n_impacts,) f8
    steps_out: Ints,  # (n_zones,) i4
    gaps_out: Floats,  # (n_zones,) f8, relative duality gap of the answer, as the solver sees it
    violations_out: Floats,  # (n_zones,) f8  [m], largest violation of the answer
    trace_out: Floats,  # (n_zones, k, 2) f8, objective [kg m^2] and violation [m]; k = 0: none
    unknown_work_out: Floats,  # (4, n_unknowns) f8, work space
    impact_work_out: Floats,  # (3, n_impacts) f8, work space
    memory_out: Floats,  # (n_memory,) f8, work space
    states_out: Floats,  # (1, n_threads, 9) f8, zeros, work space of each thread
    parts_out: Floats,  # (n_blocks, 7) f8, zeros, work space
) -> None:
    """Solve one zone with all blocks of the launch."""
    if zones.shape[0] == 1:
        group = grid(parts_out)
        minimise_zone(
            zones[0],
            states_out[0, group.rank()],
            group,
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


@cuda_kernel
def flag_zones_of_size(
    # In:
    zones: Indices,  # (n,) i8
    impact_offsets: Offsets,  # (n_zones + 1,) i8
    more_than: int,  # i8, impacts
    at_most: int,  # i8, impacts
    # Out:
    flags_out: Flags,  # (n,) b1, whether the zone has more than one number and at most the other
) -> None:
    """Flag the zones whose number of impacts is in a range."""
    i = cuda.grid(1)
    if i < zones.shape[0]:
        size = impact_offsets[zones[i] + 1] - impact_offsets[zones[i]]
        flags_out[i] = more_than < size <= at_most


@cuda_kernel
def judge_zones(
    # In:
    zones: Indices,  # (n,) i8, zones to judge
    gaps: Floats,  # (n_zones,) f8, relative duality gap
    violations: Floats,  # (n_zones,) f8  [m]
    gap_tolerance: float,  # f8
    violation_tolerance: float,  # f8  [m]
    # Out:
    solved_out: Flags,  # (n_zones,) b1, written for these zones
) -> None:
    """Judge which zones are solved to the tolerances."""
    i = cuda.grid(1)
    if i < zones.shape[0]:
        zone = zones[i]
        holds = violations[zone] <= violation_tolerance
        solved_out[zone] = holds and gaps[zone] <= gap_tolerance
