"""Augmented-Lagrangian solvers: a zone a block, or a large one by all blocks of a launch.

Source: XRTailor documentation, "Impact Zone Optimization", figure `gpu_architecture`.
"""

from numba import cuda

from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.thread_group import block, grid
from izo_ref.solvers.serial.descent import minimise_zone


@cuda_kernel
def solve_lagrangian(
    # In:
    zones,  # (n,) i8, those to solve
    impact_offsets,  # (n_zones + 1,) i8
    row_offsets,  # (n_zones + 1,) i8, of a zone's unknowns; 3 for pinned vertices at the end
    memory_offsets,  # (n_zones + 1,) i8
    nodes,  # (n_impacts, 4) u4, 3 times the zone's own vertex
    coefficients,  # (n_impacts, 4) f8 or f4, 0 for pinned
    entries,  # (n_entries,) u4, impacts of each vertex, numbers in its zone
    arms,  # (n_entries, 3) f8 or f4, coefficient times normal of each
    entry_starts,  # (n_unknowns / 3 + 1,) u8
    normals,  # (n_impacts, 3) f8 or f4
    starts,  # (n_impacts,) f8 or f4, constraints at x = 0
    metres,  # (n_impacts,) f8 or f4  [m], violation of a constraint of 1
    curvatures,  # (n_unknowns,) f8 or f4, w
    mus,  # (n_zones,) f8, penalty weights at first
    mu_caps,  # (n_zones,) f8, and at most
    first_steps,  # (n_zones,) f8
    units,  # (n_zones,) f8  [kg m^2], of an objective of 1
    settings,  # Settings
    # Out:
    x_out,  # (n_unknowns,) f8 or f4, displacements
    multipliers_out,  # (n_impacts,) f8 or f4
    steps_out,  # (n_zones,) i4
    gaps_out,  # (n_zones,) f8, relative duality gap of the answer, as the solver sees it
    violations_out,  # (n_zones,) f8  [m], and its largest violation
    trace_out,  # (n_zones, k, 2) f8, objective [kg m^2] and violation [m]; k = 0: none
    vectors_out,  # (4, n_unknowns) f8 or f4, work space
    rows_out,  # (3, n_impacts) f8 or f4, work space
    memory_out,  # (n_memory,) f8 or f4, work space
    states_out,  # (n, n_threads, 9) f8, zeros, work space; as many as work on a zone
):
    if cuda.blockIdx.x < zones.shape[0]:
        minimise_zone(
            zones[cuda.blockIdx.x],
            states_out[cuda.blockIdx.x, cuda.threadIdx.x],
            block(),
            impact_offsets,
            row_offsets,
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
            vectors_out,
            rows_out,
            memory_out,
        )


@cuda_kernel
def solve_lagrangian_by_grid(
    # In:
    zones,  # (1,) i8, the one to solve
    impact_offsets,  # (n_zones + 1,) i8
    row_offsets,  # (n_zones + 1,) i8, of a zone's unknowns; 3 for pinned vertices at the end
    memory_offsets,  # (n_zones + 1,) i8
    nodes,  # (n_impacts, 4) u4, 3 times the zone's own vertex
    coefficients,  # (n_impacts, 4) f8, 0 for pinned
    entries,  # (n_entries,) u4, impacts of each vertex, numbers in its zone
    arms,  # (n_entries, 3) f8, coefficient times normal of each
    entry_starts,  # (n_unknowns / 3 + 1,) u8
    normals,  # (n_impacts, 3) f8
    starts,  # (n_impacts,) f8, constraints at x = 0
    metres,  # (n_impacts,) f8  [m], violation of a constraint of 1
    curvatures,  # (n_unknowns,) f8, w
    mus,  # (n_zones,) f8, penalty weights at first
    mu_caps,  # (n_zones,) f8, and at most
    first_steps,  # (n_zones,) f8
    units,  # (n_zones,) f8  [kg m^2], of an objective of 1
    settings,  # Settings
    # Out:
    x_out,  # (n_unknowns,) f8, displacements
    multipliers_out,  # (n_impacts,) f8
    steps_out,  # (n_zones,) i4
    gaps_out,  # (n_zones,) f8, relative duality gap of the answer, as the solver sees it
    violations_out,  # (n_zones,) f8  [m], and its largest violation
    trace_out,  # (n_zones, k, 2) f8, objective [kg m^2] and violation [m]; k = 0: none
    vectors_out,  # (4, n_unknowns) f8, work space
    rows_out,  # (3, n_impacts) f8, work space
    memory_out,  # (n_memory,) f8, work space
    states_out,  # (1, n_threads, 9) f8, zeros, work space; as many as work on a zone
    parts_out,  # (n_blocks, 7) f8, zeros, work space
):
    if zones.shape[0] == 1:
        group = grid(parts_out)
        minimise_zone(
            zones[0],
            states_out[0, group.rank()],
            group,
            impact_offsets,
            row_offsets,
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
            vectors_out,
            rows_out,
            memory_out,
        )


@cuda_kernel
def flag_zones_of_size(
    # In:
    zones,  # (n,) i8
    impact_offsets,  # (n_zones + 1,) i8
    more_than,  # i8, impacts
    at_most,  # i8
    # Out:
    flags_out,  # (n,) b1, of those with so many
):
    i = cuda.grid(1)
    if i < zones.shape[0]:
        size = impact_offsets[zones[i] + 1] - impact_offsets[zones[i]]
        flags_out[i] = more_than < size <= at_most


@cuda_kernel
def judge_zones(
    # In:
    zones,  # (n,) i8
    gaps,  # (n_zones,) f8, relative duality gap
    violations,  # (n_zones,) f8  [m]
    gap_tolerance,  # f8
    violation_tolerance,  # f8  [m]
    # Out:
    solved_out,  # (n_zones,) b1, of these zones
):
    i = cuda.grid(1)
    if i < zones.shape[0]:
        zone = zones[i]
        holds = violations[zone] <= violation_tolerance
        solved_out[zone] = holds and gaps[zone] <= gap_tolerance
