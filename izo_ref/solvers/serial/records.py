"""Records of what the kernels of the augmented-Lagrangian methods read and write.

The arrays of all zones lie side by side. All arrays whose type is stated as `f8 or f4` have the
same type in one call, which is the precision of the options.
"""

from typing import NamedTuple

from izo_ref.base.arrays import AnyFloats, AnyInts, Flags, Floats, Indices, Ints, Offsets


class Inputs(NamedTuple):
    """What the kernels read, except the settings."""

    zones: Indices  # (n,) i8, zones to solve
    impact_offsets: Offsets  # (n_zones + 1,) i8
    unknown_offsets: Offsets  # (n_zones + 1,) i8, into x; the last 3 of a zone are for pinned ones
    memory_offsets: Offsets  # (n_zones + 1,) i8
    nodes: AnyInts  # (n_impacts, 4) u4, 3 times the vertex's number in its zone
    coefficients: AnyFloats  # (n_impacts, 4) f8 or f4, 0 for pinned vertices
    entries: AnyInts  # (n_entries,) u4, impacts of each vertex, by their number in the zone
    arms: AnyFloats  # (n_entries, 3) f8 or f4, coefficient times normal of each entry
    entry_starts: AnyInts  # (n_unknowns / 3 + 1,) u8, where the entries of each vertex begin
    normals: AnyFloats  # (n_impacts, 3) f8 or f4
    starts: AnyFloats  # (n_impacts,) f8 or f4, constraints at x = 0
    metres: AnyFloats  # (n_impacts,) f8 or f4 [m], violation if a constraint is 1
    curvatures: AnyFloats  # (n_unknowns,) f8 or f4, w
    mus: Floats  # (n_zones,) f8, penalty weights at the start
    mu_caps: Floats  # (n_zones,) f8, largest penalty weights
    first_steps: Floats  # (n_zones,) f8
    units: Floats  # (n_zones,) f8 [kg m^2], objective in kg m^2 if the objective is 1


class Results(NamedTuple):
    """What the kernels write, except the work space."""

    x: AnyFloats  # (n_unknowns,) f8 or f4, displacements; zeros on entry
    multipliers: AnyFloats  # (n_impacts,) f8 or f4; zeros on entry
    steps: Ints  # (n_zones,) i4
    gaps: Floats  # (n_zones,) f8, relative duality gap of the answer, as the solver sees it
    violations: Floats  # (n_zones,) f8 [m], largest violation of the answer
    trace: Floats  # (n_zones, k, 2) f8, objective [kg m^2] and violation [m]; k = 0: none


class WorkSpace(NamedTuple):
    """Work space of the kernels; all zeros on entry."""

    unknowns: AnyFloats  # (4, n_unknowns) f8 or f4
    impacts: AnyFloats  # (3, n_impacts) f8 or f4
    memory: AnyFloats  # (n_memory,) f8 or f4, what the directions keep
    states: Floats  # (n, n_threads, 9) f8, the numbers of each thread of a zone
    stop: Flags  # (1,) b1, no further step begins once it is set; the threads of a GPU never set it
