"""Augmented-Lagrangian solvers that take one zone a thread."""

from numba import prange

from izo_ref._jit import cpu_kernel
from izo_ref.serial.descent import minimise
from izo_ref.serial.lagrangian import Zone
from izo_ref.serial.team import alone


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
        zone = zones[number]
        a, b = impact_offsets[zone], impact_offsets[zone + 1]
        i, k = row_offsets[zone], row_offsets[zone + 1]
        steps_out[zone], gaps_out[zone], violations_out[zone] = minimise(
            Zone(
                nodes[a:b],
                coefficients[a:b],
                entries,
                arms,
                entry_starts[i // 3 : k // 3 + 1],
                normals[a:b],
                starts[a:b],
                metres[a:b],
                curvatures[i:k],
                x_out[i:k],
                multipliers_out[a:b],
                vectors_out[0, i:k],
                vectors_out[1, i:k],
                vectors_out[2, i:k],
                vectors_out[3, i:k],
                rows_out[0, a:b],
                rows_out[1, a:b],
                rows_out[2, a:b],
                memory_out[memory_offsets[zone] : memory_offsets[zone + 1]],
                states_out[number, 0],
                alone(),
            ),
            settings,
            mus[zone],
            mu_caps[zone],
            first_steps[zone],
            units[zone],
            trace_out[zone],
        )
