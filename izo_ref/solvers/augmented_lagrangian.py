"""The augmented-Lagrangian methods on a system of zones: scale, choose parameters, launch."""

from typing import NamedTuple

import numpy as np

from izo_ref.base.options import Options
from izo_ref.solvers.cpu import lagrangian as kernels
from izo_ref.solvers.presets import METHOD_PARAMETERS, PRESETS, choose_settings
from izo_ref.solvers.scaled_constraints import ScaledConstraints, SystemSolution
from izo_ref.solvers.serial.descent import LBFGS, NEWTON, Settings
from izo_ref.solvers.serial.directions.lbfgs import PAIRS
from izo_ref.zones.system import ZoneSystem

# Memory of the directions that have some: vectors as long as x, and numbers.
MEMORY = {LBFGS: (2 * PAIRS, 2 * PAIRS), NEWTON: (3, 0)}


class Scaled(NamedTuple):
    """A system in the variables of the solver; `unit` by zone, the others by row or vertex."""

    coefficients: np.ndarray  # (n_impacts, 4) f8, 0 for pinned
    starts: np.ndarray  # (n_impacts,) f8, constraints at the candidate positions
    metres: np.ndarray  # (n_impacts,) f8 [m], violation of a constraint of 1
    curvatures: np.ndarray  # (n_free,) f8
    lengths: np.ndarray  # (n_free,) f8 [m], displacement of an unknown of 1
    forces: np.ndarray  # (n_impacts,) f8 [kg], multiplier of 1
    units: np.ndarray  # (n_zones,) f8 [kg m^2], objective of 1


def _own_scaling(system, rows):
    """SPEC 5, and each zone in units of its largest rhs: all tolerances are relative."""
    begin, per_impact, per_vertex = _sizes(system)
    largest = np.maximum.reduceat(np.abs(rows.rhs), begin)
    largest[largest == 0.0] = 1.0  # satisfied to the last bit: any unit will do
    by_impact = np.repeat(largest, per_impact)
    free_masses = system.masses[: system.vertex_offsets[-1]]
    return Scaled(
        np.where(rows.unknowns < 0, 0.0, rows.coefficients),
        rows.rhs / by_impact,
        by_impact * rows.lengths,
        np.ones(len(free_masses)),
        np.repeat(largest, per_vertex) / np.sqrt(free_masses),
        by_impact / rows.lengths,
        largest**2,
    )


def _preset_scaling(system, rows, preset):
    """Metres; w_i = scale m_i with the scale of the preset's objective (SPEC 4)."""
    _, per_impact, per_vertex = _sizes(system)
    free_masses = system.masses[: system.vertex_offsets[-1]]
    begin = system.vertex_offsets[:-1]
    if preset.by_total_mass:  # sum m dx^2 / sum m
        scale = 2.0 / np.add.reduceat(free_masses, begin)
    else:  # 1/2 mean(1/m) sum m dx^2
        scale = np.add.reduceat(1.0 / free_masses, begin) / per_vertex
    relative = system.proposed[system.nodes] - system.proposed[system.nodes[:, :1]]
    gaps = np.einsum("jk,jkx,jx->j", system.weights, relative, system.normals)
    n = len(system.nodes)
    return Scaled(
        np.where(rows.unknowns < 0, 0.0, system.weights),
        system.thickness - gaps,
        np.ones(n),
        np.repeat(scale, per_vertex) * free_masses,
        np.ones(len(free_masses)),
        1.0 / np.repeat(scale, per_impact),
        1.0 / scale,
    )


def _sizes(system):
    begin, per_impact = system.impact_offsets[:-1], np.diff(system.impact_offsets)
    return begin, per_impact, np.diff(system.vertex_offsets)


def _row_coupling(unknowns, coefficients, impact_offsets, n_vertices):
    """(n_zones,) f8, a bound of the largest eigenvalue of C C^T: its largest row sum."""
    size = np.abs(coefficients)
    on_vertex = np.zeros(n_vertices + 1)
    np.add.at(on_vertex, unknowns.ravel(), size.ravel())
    row_sums = np.where(unknowns >= 0, size * on_vertex[unknowns], 0.0).sum(axis=1)
    # 1 is the diagonal; less only where rows have no unknowns
    return np.maximum(np.maximum.reduceat(row_sums, impact_offsets[:-1]), 1.0)


class Layout(NamedTuple):
    """Where a zone's numbers are: its vertices, then one more that all pinned ones share."""

    nodes: np.ndarray  # (n_impacts, 4) u4, where the coordinates begin in the zone
    entries: np.ndarray  # (n_entries,) i4, 4 j + k: impact j, of all, of each vertex
    entry_starts: np.ndarray  # (n_vertices + n_zones + 1,) i8, of each vertex, pinned ones too
    row_offsets: np.ndarray  # (n_zones + 1,) i8, of unknowns
    memory_offsets: np.ndarray  # (n_zones + 1,) i8, of the directions' memory
    place: np.ndarray  # (n_free, 3) i8, unknowns of a vertex


def _layout(system, rows, direction):
    zones = np.arange(len(system.impact_offsets))
    _, per_impact, per_vertex = _sizes(system)
    first = np.repeat(system.vertex_offsets[:-1], per_impact)[:, None]
    pinned = np.repeat(per_vertex, per_impact)[:, None]
    nodes = 3 * np.where(rows.unknowns < 0, pinned, rows.unknowns - first)
    row_offsets = 3 * (system.vertex_offsets + zones)
    place = 3 * (np.arange(system.vertex_offsets[-1]) + np.repeat(zones[:-1], per_vertex))
    vectors, numbers = MEMORY.get(direction, (0, 0))
    memory_offsets = vectors * row_offsets + numbers * zones
    place = place[:, None] + np.arange(3)
    entries = _entries(system, rows, row_offsets, nodes)
    return Layout(nodes.astype(np.uint32), *entries, row_offsets, memory_offsets, place)


def _entries(system, rows, row_offsets, nodes):
    """Of each vertex that is not pinned its impacts, ascending, and where they begin."""
    _, per_impact, _ = _sizes(system)
    entry = np.flatnonzero(rows.unknowns >= 0)
    vertex = (np.repeat(row_offsets[:-1], per_impact)[:, None] + nodes).ravel()[entry] // 3
    counts = np.bincount(vertex, minlength=row_offsets[-1] // 3)
    return entry[np.argsort(vertex, kind="stable")], np.concatenate(([0], np.cumsum(counts)))


def _penalties(system, options, rows, preset):
    """(mu, largest mu, first step) of each zone."""
    ones = np.ones(len(system.impact_offsets) - 1)
    if preset is not None:
        first_steps = preset.step * ones + preset.step_per_vertex * np.diff(system.vertex_offsets)
        return preset.mu * ones, preset.mu * ones, first_steps
    n_free = system.vertex_offsets[-1]
    coupling = _row_coupling(rows.unknowns, rows.coefficients, system.impact_offsets, n_free)
    return *METHOD_PARAMETERS[options.method].penalties(options, coupling), ones


class Inputs(NamedTuple):
    """What the kernel reads; shapes and types are in its contract."""

    zones: np.ndarray
    impact_offsets: np.ndarray
    row_offsets: np.ndarray
    memory_offsets: np.ndarray
    nodes: np.ndarray
    coefficients: np.ndarray
    entries: np.ndarray
    arms: np.ndarray
    entry_starts: np.ndarray
    normals: np.ndarray
    starts: np.ndarray
    metres: np.ndarray
    curvatures: np.ndarray
    mus: np.ndarray
    mu_caps: np.ndarray
    first_steps: np.ndarray
    units: np.ndarray
    settings: Settings


class Results(NamedTuple):
    """What it writes, but for work space."""

    x: np.ndarray
    multipliers: np.ndarray
    steps: np.ndarray
    gaps: np.ndarray
    violations: np.ndarray
    trace: np.ndarray


def work_space(inputs: Inputs, n_memory, n_threads=1):
    """Shapes and types of the arrays of zeros that the kernel wants behind its results."""
    n, m, dtype = inputs.curvatures.shape[0], inputs.nodes.shape[0], inputs.curvatures.dtype
    of_threads = (inputs.zones.shape[0], n_threads, 9), np.float64
    return ((4, n), dtype), ((3, m), dtype), ((n_memory,), dtype), of_threads


def run_on_cpu(inputs: Inputs, results: Results):
    work = work_space(inputs, inputs.memory_offsets[-1])
    kernels.solve_lagrangian(*inputs, *results, *(np.zeros(*array) for array in work))


def _inputs(system, settings, scaled, layout, penalties, dtype) -> Inputs:
    rows, ks = np.divmod(layout.entries, 4)
    firsts = np.repeat(system.impact_offsets[:-1], np.diff(system.impact_offsets))
    arms = scaled.coefficients[rows, ks][:, None] * system.normals[rows]
    curvatures = np.ones(layout.row_offsets[-1], dtype)
    curvatures[layout.place] = scaled.curvatures[:, None]
    return Inputs(
        np.arange(len(scaled.units)),
        system.impact_offsets,
        layout.row_offsets,
        layout.memory_offsets,
        layout.nodes,
        scaled.coefficients.astype(dtype),
        (rows - firsts[rows]).astype(np.uint32),
        arms.astype(dtype),
        layout.entry_starts.astype(np.uint64),
        system.normals.astype(dtype),
        scaled.starts.astype(dtype),
        scaled.metres.astype(dtype),
        curvatures,
        *penalties,
        scaled.units,
        settings,
    )


def descend(
    system: ZoneSystem,
    options: Options,
    rows: ScaledConstraints,
    trace: bool = False,
    solve=run_on_cpu,
) -> SystemSolution:
    """The page's methods, in scaled variables or in those of the system a preset is from.

    With `trace` the solution has that of the first zone. `solve` runs the kernel of the
    processor, or that of a GPU.
    """
    n_zones = len(system.impact_offsets) - 1
    preset = PRESETS.get(options.preset)
    settings = choose_settings(options, system.thickness)
    scaled = _preset_scaling(system, rows, preset) if preset else _own_scaling(system, rows)
    dtype, layout = np.dtype(options.precision), _layout(system, rows, settings.direction)
    penalties = _penalties(system, options, rows, preset)
    results = Results(
        np.zeros(layout.row_offsets[-1], dtype),
        np.zeros(len(layout.nodes), dtype),
        np.zeros(n_zones, np.int32),
        np.zeros(n_zones),
        np.zeros(n_zones),
        np.zeros((n_zones, settings.max_steps if trace else 0, 2)),
    )
    solve(_inputs(system, settings, scaled, layout, penalties, dtype), results)
    x, multipliers, steps = results.x[layout.place], results.multipliers, results.steps
    displacements = np.zeros_like(system.proposed)
    displacements[: len(x)] = scaled.lengths[:, None] * x
    multipliers = scaled.forces * multipliers
    return SystemSolution(
        system.proposed + displacements,
        displacements,
        multipliers,
        multipliers > 0.0,
        ~np.logical_or.reduceat(rows.hopeless, system.impact_offsets[:-1]),
        steps,
        np.full(n_zones, preset.method if preset else options.method),
        results.trace[0, : steps[0]] if trace else None,
    )
