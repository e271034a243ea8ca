"""The page's method: gradient descent on the augmented Lagrangian, zones side by side."""

import numpy as np

from izo_ref.cpu import zones as kernels
from izo_ref.options import Options
from izo_ref.rows import ScaledRows, SystemSolution
from izo_ref.serial.lagrangian import Descent
from izo_ref.zones import ZoneSystem

XRTAILOR = Descent(
    armijo=0.5, shrink=0.7, grow=1.0, smallest_step=1e-12, max_iterations=100, tolerance=0.0
)


def _row_coupling(unknowns, coefficients, impact_offsets, n_vertices):
    """(n_zones,) f8, a bound of the largest eigenvalue of C C^T: its largest row sum."""
    size = np.abs(coefficients)
    on_vertex = np.zeros(n_vertices + 1)
    np.add.at(on_vertex, unknowns.ravel(), size.ravel())
    row_sums = np.where(unknowns >= 0, size * on_vertex[unknowns], 0.0).sum(axis=1)
    # 1 is the diagonal; less only where rows have no unknowns
    return np.maximum(np.maximum.reduceat(row_sums, impact_offsets[:-1]), 1.0)


def descend(system: ZoneSystem, options: Options, rows: ScaledRows) -> SystemSolution:
    """The page's method, in scaled variables or in those of the system a preset is from."""
    n_free, n_zones = system.vertex_offsets[-1], len(system.impact_offsets) - 1
    free_masses = system.masses[:n_free]
    per_impact, per_vertex = np.diff(system.impact_offsets), np.diff(system.vertex_offsets)
    if options.preset == "xrtailor":
        # positions in metres; kappa_i = 1/2 mean(1/m) m_i over the vertices of the zone
        mean = np.add.reduceat(1.0 / free_masses, system.vertex_offsets[:-1]) / per_vertex
        curvatures = 0.5 * np.repeat(mean, per_vertex) * free_masses
        centres, coefficients = system.targets[:n_free], system.weights
        held = np.where(rows.unknowns < 0, system.weights, 0.0)
        reach = np.einsum("jk,jkx,jx->j", held, system.targets[system.nodes], system.normals)
        b = system.thickness - reach
        mus, first_steps, parameters = np.full(n_zones, 1e3), 1e-3 * per_vertex, XRTAILOR
    else:
        # each zone in units of its largest rhs, so that every tolerance is relative
        largest = np.maximum.reduceat(np.abs(rows.rhs), system.impact_offsets[:-1])
        largest[largest == 0.0] = 1.0  # satisfied to the last bit: any unit will do
        curvatures, centres = np.full(n_free, 0.5), np.zeros((n_free, 3))
        coefficients, b = rows.coefficients, rows.rhs / np.repeat(largest, per_impact)
        # The page gives mu and the line search no values that fit all scalings. With the
        # multipliers updated after every step, one row (K = 1) and a step of 1 give a
        # linear map that is stable for mu < 2/3; so half of 1 / |C C^T|.
        mus = 0.5 / _row_coupling(rows.unknowns, coefficients, system.impact_offsets, n_free)
        first_steps = np.ones(n_zones)
        parameters = Descent(
            armijo=1e-4,
            shrink=0.5,
            grow=2.0,
            smallest_step=1e-12,
            max_iterations=100_000,
            # complementarity is a product of this error with multipliers of a few units
            tolerance=0.01 * options.gap_tolerance,
        )
    found, multipliers = np.empty((n_free, 3)), np.zeros(len(b))
    steps = np.zeros(n_zones, np.int32)
    kernels.solve_lagrangian(
        system.impact_offsets,
        system.vertex_offsets,
        rows.unknowns,
        coefficients,
        system.normals,
        b,
        curvatures,
        centres,
        mus,
        first_steps,
        parameters,
        found,
        multipliers,
        steps,
    )
    positions, displacements = system.targets.copy(), np.zeros_like(system.targets)
    if options.preset == "xrtailor":
        positions[:n_free] = found
        displacements[:n_free] = found - system.targets[:n_free]
        # of mean(1/m) times 1/2 sum m |x - y|^2
        multipliers /= np.repeat(mean, per_impact)
    else:
        scale = np.repeat(largest, per_vertex) / np.sqrt(free_masses)
        displacements[:n_free] = scale[:, None] * found
        positions += displacements
        multipliers *= np.repeat(largest, per_impact) / rows.lengths
    return SystemSolution(
        positions,
        displacements,
        multipliers,
        multipliers > 0.0,
        ~np.logical_or.reduceat(rows.hopeless, system.impact_offsets[:-1]),
        steps,
        np.full(n_zones, "gradient"),
    )
