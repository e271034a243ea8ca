"""Augmented-Lagrangian solvers that take one zone a thread."""

from numba import prange

from izo_ref.base.compile import cpu_kernel
from izo_ref.base.serial.thread_group import alone
from izo_ref.solvers.serial.descent import minimise_zone


@cpu_kernel
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
    for number in prange(zones.shape[0]):
        minimise_zone(
            zones[number],
            states_out[number, 0],
            alone(),
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
