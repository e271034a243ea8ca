"""Zones in the variables of the augmented-Lagrangian methods, laid out for the kernels."""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyInts, Floats, Indices, Ints, Offsets
from izo_ref.base.options import Options
from izo_ref.solvers.presets import METHOD_PARAMETERS, Preset, preset_of
from izo_ref.solvers.scaled_constraints import ScaledConstraints
from izo_ref.solvers.serial.descent import LBFGS, NEWTON
from izo_ref.solvers.serial.directions.lbfgs import PAIRS
from izo_ref.solvers.serial.records import Inputs
from izo_ref.zones.system import ZoneSystem

# Memory of the directions that keep some: vectors as long as x, and single numbers.
MEMORY = {LBFGS: (2 * PAIRS, 2 * PAIRS), NEWTON: (3, 0)}


class Variables(NamedTuple):
    """A system in the variables x of the solver, and the factors that lead back to metres and kg.

    The constraints are c = s - A x <= 0. The objective is sum_i w_i x_i^2 / 2.
    """

    coefficients: Floats  # (n_impacts, 4) f8, 0 for pinned vertices
    starts: Floats  # (n_impacts,) f8, s: the constraints at the proposed positions
    metres: Floats  # (n_impacts,) f8 [m], violation if a constraint is 1
    curvatures: Floats  # (n_unpinned,) f8, w
    lengths: Floats  # (n_unpinned,) f8 [m], displacement if an unknown is 1
    forces: Floats  # (n_impacts,) f8 [kg], multiplier in kg if a multiplier is 1
    units: Floats  # (n_zones,) f8 [kg m^2], objective in kg m^2 if the objective is 1


def choose_variables(
    system: ZoneSystem, constraints: ScaledConstraints, preset: Preset | None
) -> Variables:
    """Return a system in scaled variables, or in those of the system that a preset is from."""
    if preset is None:
        return _scaled_variables(system, constraints)
    return _preset_variables(system, constraints, preset)


def _scaled_variables(system: ZoneSystem, constraints: ScaledConstraints) -> Variables:
    """Return the scaled variables of docs/method section 5, each zone in units of its largest rhs.

    In these variables every tolerance is relative.
    """
    begin, per_impact, per_vertex = _sizes(system)
    largest = np.maximum.reduceat(np.abs(constraints.rhs), begin)
    largest[largest == 0.0] = 1.0  # satisfied to the last bit: any unit will do
    by_impact = np.repeat(largest, per_impact)
    unpinned_masses = system.masses[: system.vertex_offsets[-1]]
    return Variables(
        np.where(constraints.unknowns < 0, 0.0, constraints.coefficients),
        constraints.rhs / by_impact,
        by_impact * constraints.lengths,
        np.ones(len(unpinned_masses)),
        np.repeat(largest, per_vertex) / np.sqrt(unpinned_masses),
        by_impact / constraints.lengths,
        largest**2,
    )


def _preset_variables(
    system: ZoneSystem, constraints: ScaledConstraints, preset: Preset
) -> Variables:
    """Return displacements in metres, with the objective of a preset (docs/method section 4).

    w_i is the mass m_i times a factor, which the preset's objective defines for each zone.
    """
    _, per_impact, per_vertex = _sizes(system)
    unpinned_masses = system.masses[: system.vertex_offsets[-1]]
    begin = system.vertex_offsets[:-1]
    if preset.by_total_mass:  # sum m dx^2 / sum m
        scale = 2.0 / np.add.reduceat(unpinned_masses, begin)
    else:  # 1/2 mean(1/m) sum m dx^2
        scale = np.add.reduceat(1.0 / unpinned_masses, begin) / per_vertex
    relative = system.proposed[system.nodes] - system.proposed[system.nodes[:, :1]]
    gaps = np.einsum("jk,jkx,jx->j", system.weights, relative, system.normals)
    return Variables(
        np.where(constraints.unknowns < 0, 0.0, system.weights),
        system.thickness - gaps,
        np.ones(len(system.nodes)),
        np.repeat(scale, per_vertex) * unpinned_masses,
        np.ones(len(unpinned_masses)),
        1.0 / np.repeat(scale, per_impact),
        1.0 / scale,
    )


def _sizes(system: ZoneSystem) -> tuple[Offsets, Indices, Indices]:
    """Return the first impact, the number of impacts and of unpinned vertices of each zone."""
    begin, per_impact = system.impact_offsets[:-1], np.diff(system.impact_offsets)
    return begin, per_impact, np.diff(system.vertex_offsets)


def _bound_coupling(
    unknowns: Ints, coefficients: Floats, impact_offsets: Offsets, n_vertices: int
) -> Floats:
    """Return a bound of the largest eigenvalue of C C^T for each zone: its largest row sum."""
    size = np.abs(coefficients)
    on_vertex = np.zeros(n_vertices + 1)
    np.add.at(on_vertex, unknowns.ravel(), size.ravel())
    row_sums = np.where(unknowns >= 0, size * on_vertex[unknowns], 0.0).sum(axis=1)
    # The diagonal of C C^T is 1. Row sums are less only if all vertices of an impact are pinned.
    return np.maximum(np.maximum.reduceat(row_sums, impact_offsets[:-1]), 1.0)


class Layout(NamedTuple):
    """Where the numbers of each zone are.

    x has a row for each unpinned vertex of a zone, and one more row at the end of the zone that
    all its pinned vertices share.
    """

    nodes: AnyInts  # (n_impacts, 4) u4, where the coordinates of a vertex begin in its zone
    entries: Indices  # (n_entries,) i8, 4 j + k for impact j of the system, vertex by vertex
    entry_starts: Offsets  # (n_unpinned + n_zones + 1,) i8, where those of each row of x begin
    unknown_offsets: Offsets  # (n_zones + 1,) i8, where x of each zone begins
    memory_offsets: Offsets  # (n_zones + 1,) i8, where the memory of each zone's direction begins
    place: Indices  # (n_unpinned, 3) i8, where the coordinates of a vertex are in x


def lay_out(system: ZoneSystem, constraints: ScaledConstraints, direction: int) -> Layout:
    """Return where the numbers of each zone are.

    Args:
        system: The zones.
        constraints: Their constraints in scaled variables.
        direction: The descent direction, a code of `solvers/serial/descent.py`.
    """
    zones = np.arange(len(system.impact_offsets))
    _, per_impact, per_vertex = _sizes(system)
    first = np.repeat(system.vertex_offsets[:-1], per_impact)[:, None]
    pinned = np.repeat(per_vertex, per_impact)[:, None]
    nodes = 3 * np.where(constraints.unknowns < 0, pinned, constraints.unknowns - first)
    unknown_offsets = 3 * (system.vertex_offsets + zones)
    place = 3 * (np.arange(system.vertex_offsets[-1]) + np.repeat(zones[:-1], per_vertex))
    vectors, numbers = MEMORY.get(direction, (0, 0))
    memory_offsets = vectors * unknown_offsets + numbers * zones
    place = place[:, None] + np.arange(3)
    entries = _list_entries(system, constraints, unknown_offsets, nodes)
    return Layout(nodes.astype(np.uint32), *entries, unknown_offsets, memory_offsets, place)


def _list_entries(
    system: ZoneSystem, constraints: ScaledConstraints, unknown_offsets: Offsets, nodes: Indices
) -> tuple[Indices, Offsets]:
    """Return the impacts of each unpinned vertex, ascending, and where those of each begin."""
    _, per_impact, _ = _sizes(system)
    entry = np.flatnonzero(constraints.unknowns >= 0)
    vertex = (np.repeat(unknown_offsets[:-1], per_impact)[:, None] + nodes).ravel()[entry] // 3
    counts = np.bincount(vertex, minlength=unknown_offsets[-1] // 3)
    return entry[np.argsort(vertex, kind="stable")], np.concatenate(([0], np.cumsum(counts)))


def _penalties(
    system: ZoneSystem, options: Options, constraints: ScaledConstraints
) -> tuple[Floats, Floats, Floats]:
    """Return mu at the start, the largest mu and the first step of each zone."""
    preset = preset_of(options)
    ones = np.ones(len(system.impact_offsets) - 1)
    if preset is not None:
        first_steps = preset.step * ones + preset.step_per_vertex * np.diff(system.vertex_offsets)
        return preset.mu * ones, preset.mu * ones, first_steps
    coupling = _bound_coupling(
        constraints.unknowns,
        constraints.coefficients,
        system.impact_offsets,
        system.vertex_offsets[-1],
    )
    return *METHOD_PARAMETERS[options.method].penalties(options, coupling), ones


def make_inputs(
    system: ZoneSystem,
    options: Options,
    constraints: ScaledConstraints,
    variables: Variables,
    layout: Layout,
) -> Inputs:
    """Return the inputs of the kernels, in the precision of the options."""
    dtype = np.dtype(options.precision)
    impacts, ks = np.divmod(layout.entries, 4)
    firsts = np.repeat(system.impact_offsets[:-1], np.diff(system.impact_offsets))
    arms = variables.coefficients[impacts, ks][:, None] * system.normals[impacts]
    curvatures = np.ones(layout.unknown_offsets[-1], dtype)
    curvatures[layout.place] = variables.curvatures[:, None]
    return Inputs(
        np.arange(len(variables.units)),
        system.impact_offsets,
        layout.unknown_offsets,
        layout.memory_offsets,
        layout.nodes,
        variables.coefficients.astype(dtype),
        (impacts - firsts[impacts]).astype(np.uint32),
        arms.astype(dtype),
        layout.entry_starts.astype(np.uint64),
        system.normals.astype(dtype),
        variables.starts.astype(dtype),
        variables.metres.astype(dtype),
        curvatures,
        *_penalties(system, options, constraints),
        variables.units,
    )
