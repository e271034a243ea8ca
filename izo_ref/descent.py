"""The augmented-Lagrangian methods on a system of zones: scale, choose parameters, launch."""

from typing import NamedTuple

import numpy as np

from izo_ref.cpu import lagrangian as kernels
from izo_ref.methods import METHODS, PRESETS, chosen_settings
from izo_ref.options import Options
from izo_ref.rows import ScaledRows, SystemSolution
from izo_ref.serial.descent import LBFGS, NEWTON
from izo_ref.serial.directions.lbfgs import PAIRS
from izo_ref.zones import ZoneSystem


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
    relative = system.targets[system.nodes] - system.targets[system.nodes[:, :1]]
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


def descend(
    system: ZoneSystem, options: Options, rows: ScaledRows, trace: bool = False
) -> SystemSolution:
    """The page's methods, in scaled variables or in those of the system a preset is from.

    With `trace` the solution has that of the first zone.
    """
    n_free, n_zones = system.vertex_offsets[-1], len(system.impact_offsets) - 1
    _, per_impact, per_vertex = _sizes(system)
    preset = PRESETS.get(options.preset)
    settings = chosen_settings(options, system.thickness)
    if preset is None:
        scaled = _own_scaling(system, rows)
        coupling = _row_coupling(rows.unknowns, rows.coefficients, system.impact_offsets, n_free)
        mus, mu_caps = METHODS[options.method].penalties(options, coupling)
        first_steps = np.ones(n_zones)
    else:
        scaled = _preset_scaling(system, rows, preset)
        mus = mu_caps = np.full(n_zones, preset.mu)
        first_steps = preset.step_per_vertex * per_vertex + preset.step
    # a zone's own numbers, and one vertex more at its end that all pinned ones share
    first = np.repeat(system.vertex_offsets[:-1], per_impact)[:, None]
    pinned = np.repeat(per_vertex, per_impact)[:, None]
    nodes = 3 * np.where(rows.unknowns < 0, pinned, rows.unknowns - first)
    row_offsets = 3 * (system.vertex_offsets + np.arange(n_zones + 1))
    place = 3 * (np.arange(n_free) + np.repeat(np.arange(n_zones), per_vertex))
    place = place[:, None] + np.arange(3)
    curvatures = np.ones(row_offsets[-1])
    curvatures[place] = scaled.curvatures[:, None]
    vectors = {LBFGS: 2 * PAIRS, NEWTON: 3}.get(settings.direction, 0)
    extra = 2 * PAIRS if settings.direction == LBFGS else 0
    memory_offsets = vectors * row_offsets + extra * np.arange(n_zones + 1)
    dtype = np.dtype(options.precision)
    x, multipliers = np.zeros(row_offsets[-1], dtype), np.zeros(len(rows.rhs), dtype)
    steps = np.zeros(n_zones, np.int32)
    traces = np.zeros((n_zones, settings.max_steps if trace else 0, 2))
    kernels.solve_lagrangian(
        system.impact_offsets,
        row_offsets,
        memory_offsets,
        nodes.astype(np.uint32),
        scaled.coefficients.astype(dtype),
        system.normals.astype(dtype),
        scaled.starts.astype(dtype),
        scaled.metres.astype(dtype),
        curvatures.astype(dtype),
        mus,
        mu_caps,
        first_steps,
        scaled.units,
        settings,
        x,
        multipliers,
        steps,
        traces,
        np.zeros((4, len(x)), dtype),
        np.zeros((3, len(multipliers)), dtype),
        np.zeros(memory_offsets[-1], dtype),
        np.zeros((n_zones, 9)),
    )
    displacements = np.zeros_like(system.targets)
    displacements[:n_free] = scaled.lengths[:, None] * x[place]
    multipliers = scaled.forces * multipliers
    return SystemSolution(
        system.targets + displacements,
        displacements,
        multipliers,
        multipliers > 0.0,
        ~np.logical_or.reduceat(rows.hopeless, system.impact_offsets[:-1]),
        steps,
        np.full(n_zones, preset.method if preset else options.method),
        traces[0, : steps[0]] if trace else None,
    )
