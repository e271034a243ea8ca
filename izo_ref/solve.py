"""Solve zones: pick the method, launch, wrap."""

from typing import NamedTuple

import numpy as np

from izo_ref.cpu import zones as kernels
from izo_ref.errors import OptionError
from izo_ref.interior_point import interior_point, scaled_matrix
from izo_ref.options import Options
from izo_ref.problem import ZoneProblem, ZoneSolution, residuals
from izo_ref.serial.active_set import INFEASIBLE, NOT_CONVERGED
from izo_ref.serial.lagrangian import Descent
from izo_ref.zones import ZoneSystem


class SystemSolution(NamedTuple):
    positions: np.ndarray  # (n_vertices, 3) f8 [m]
    multipliers: np.ndarray  # (n_impacts,) f8 [kg], of 1/2 sum m |x - y|^2
    active: np.ndarray  # (n_impacts,) b1, rows that hold the solution
    feasible: np.ndarray  # (n_zones,) b1
    iterations: np.ndarray  # (n_zones,) i4
    methods: list  # (n_zones,) str


def solve_system(system: ZoneSystem, options: Options) -> SystemSolution:
    """Solve every zone of a system; small ones one a thread, large ones one by one."""
    nodes = system.nodes
    inverse_sqrt_masses = 1.0 / np.sqrt(system.masses)
    coefficients, rhs = np.empty(nodes.shape), np.empty(len(nodes))
    lengths = np.empty(len(nodes))
    kernels.scaled_rows(
        nodes,
        system.weights,
        system.normals,
        system.targets,
        inverse_sqrt_masses,
        system.thickness,
        coefficients,
        rhs,
        lengths,
    )
    unknowns = np.where(nodes < system.vertex_offsets[-1], nodes, -1).astype(np.int32)
    if options.method == "gradient":
        return _descend(system, options, unknowns, coefficients, rhs, lengths)

    n_zones = len(system.impact_offsets) - 1
    sizes = np.diff(system.impact_offsets)
    scaled = np.zeros(len(nodes))
    statuses, steps = np.zeros(n_zones, np.int8), np.zeros(n_zones, np.int32)
    small = np.full(n_zones, options.method == "active-set")
    single = (sizes == 1) & (options.method == "auto")
    if options.method == "auto":
        # one impact alone: l = max(0, r / K), and K = 1 for a unit row
        rows = system.impact_offsets[:-1][single]
        scaled[rows] = np.maximum(rhs[rows], 0.0)
        small = (sizes <= options.small_zone) & ~single
    if small.any():
        kernels.solve_active_set(
            np.flatnonzero(small),
            system.impact_offsets,
            unknowns,
            coefficients,
            system.normals,
            rhs,
            scaled,
            statuses,
            steps,
        )
    methods = np.where(single, "closed-form", np.where(small, "active-set", "interior-point"))
    methods = methods.astype(object)
    # rounding can make the active set cycle; the interior point does not mind
    large = ~(small | single) | ((statuses == NOT_CONVERGED) & (options.method == "auto"))
    methods[large] = "interior-point"
    z = _pull(unknowns, coefficients, system.normals, scaled, len(system.targets))
    active = scaled > 0.0
    feasible = statuses != INFEASIBLE
    for zone in np.flatnonzero(large):
        rows = slice(*system.impact_offsets[zone : zone + 2])
        own = slice(*system.vertex_offsets[zone : zone + 2])
        local = np.where(unknowns[rows] < 0, -1, unknowns[rows] - own.start)
        matrix = scaled_matrix(
            local, coefficients[rows], system.normals[rows], own.stop - own.start
        )
        if not rhs[rows].max() > 0.0:
            z[own], scaled[rows], active[rows] = 0.0, 0.0, False
            continue
        violation = options.violation_tolerance * system.thickness / lengths[rows].max()
        zone_z, scaled[rows], steps[zone], feasible[zone] = interior_point(
            matrix, rhs[rows], options.gap_tolerance, violation
        )
        active[rows] = scaled[rows] > matrix @ zone_z - rhs[rows]
        z[own] = zone_z.reshape(-1, 3)
        if not (nodes[rows] >= system.vertex_offsets[-1]).any():
            _keep_centre(z[own], inverse_sqrt_masses[own])
    positions = system.targets + inverse_sqrt_masses[:, None] * z
    return SystemSolution(positions, scaled / lengths, active, feasible, steps, list(methods))


def _pull(unknowns, coefficients, normals, scaled, n):
    """(n, 3) f8, C^T u."""
    z = np.zeros((n + 1, 3))  # the last row takes what acts on pinned vertices
    terms = coefficients[:, :, None] * (scaled[:, None] * normals)[:, None, :]
    np.add.at(z, unknowns.ravel(), terms.reshape(-1, 3))
    return z[:n]


def _keep_centre(z, inverse_sqrt_masses):
    """Take out the translation of a zone without pinned vertices.

    Weights sum to zero, so the optimum leaves the centre of mass where it is, and a
    translation changes no gap: what the factorisation's rounding put there can go.
    """
    masses = inverse_sqrt_masses**-2
    for _ in range(2):
        moment = (z / inverse_sqrt_masses[:, None]).sum(axis=0)
        z -= (moment / masses.sum())[None, :] / inverse_sqrt_masses[:, None]


XRTAILOR = Descent(
    armijo=0.5, shrink=0.7, grow=1.0, smallest_step=1e-12, max_iterations=100, tolerance=0.0
)


def _row_coupling(unknowns, coefficients, impact_offsets, n_vertices):
    """(n_zones,) f8, a bound of the largest eigenvalue of C C^T: its largest row sum."""
    size = np.abs(coefficients)
    on_vertex = np.zeros(n_vertices + 1)
    np.add.at(on_vertex, unknowns.ravel(), size.ravel())
    row_sums = np.where(unknowns >= 0, size * on_vertex[unknowns], 0.0).sum(axis=1)
    return np.maximum.reduceat(row_sums, impact_offsets[:-1])


def _descend(system, options, unknowns, coefficients, rhs, lengths):
    """The page's method, in scaled variables or in those of the system a preset is from."""
    n_free, n_zones = system.vertex_offsets[-1], len(system.impact_offsets) - 1
    free_masses = system.masses[:n_free]
    per_impact, per_vertex = np.diff(system.impact_offsets), np.diff(system.vertex_offsets)
    if options.preset == "xrtailor":
        # positions in metres; kappa_i = 1/2 mean(1/m) m_i over the vertices of the zone
        mean = np.add.reduceat(1.0 / free_masses, system.vertex_offsets[:-1]) / per_vertex
        curvatures = 0.5 * np.repeat(mean, per_vertex) * free_masses
        centres, rows = system.targets[:n_free], system.weights
        held = np.where(unknowns < 0, system.weights, 0.0)
        reach = np.einsum("jk,jkx,jx->j", held, system.targets[system.nodes], system.normals)
        b = system.thickness - reach
        mus, first_steps, parameters = np.full(n_zones, 1e3), 1e-3 * per_vertex, XRTAILOR
    else:
        # each zone in units of its largest rhs, so that every tolerance is relative
        largest = np.maximum.reduceat(np.abs(rhs), system.impact_offsets[:-1])
        curvatures, centres = np.full(n_free, 0.5), np.zeros((n_free, 3))
        rows, b = coefficients, rhs / np.repeat(largest, per_impact)
        # The page gives mu and the line search no values that fit all scalings. Multipliers
        # that are updated after every step converge if mu is at most 1 / |C C^T|.
        mus = 1.0 / _row_coupling(unknowns, rows, system.impact_offsets, n_free)
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
    found, multipliers = np.empty((n_free, 3)), np.zeros(len(rhs))
    steps = np.zeros(n_zones, np.int32)
    kernels.solve_lagrangian(
        system.impact_offsets,
        system.vertex_offsets,
        unknowns,
        rows,
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
    positions = system.targets.copy()
    if options.preset == "xrtailor":
        positions[:n_free] = found
        # of mean(1/m) times 1/2 sum m |x - y|^2
        multipliers /= np.repeat(mean, per_impact)
    else:
        scale = np.repeat(largest, per_vertex) / np.sqrt(free_masses)
        positions[:n_free] += scale[:, None] * found
        multipliers *= np.repeat(largest, per_impact) / lengths
    return SystemSolution(
        positions,
        multipliers,
        multipliers > 0.0,
        np.ones(n_zones, bool),
        steps,
        ["gradient"] * n_zones,
    )


def solve_zone(
    problem: ZoneProblem,
    method: str = "auto",
    line_search: str = "backtracking",
    tolerance: float = 1e-9,
    preset: str | None = None,
) -> ZoneSolution:
    """Solve one zone problem.

    Args:
        problem: `ZoneProblem`.
        method: `auto`, `active-set`, `interior-point`, `gradient`; see `Options`.
        line_search: `backtracking` (of the method `gradient`).
        tolerance: relative duality gap, and violation over the thickness.
        preset: `xrtailor`: that system's parameters for the method `gradient`.

    Returns:
        `ZoneSolution`; its residuals are computed outside the solver.

    Raises:
        OptionError.

    Source: SPEC sections 3 to 5.
    """
    options = Options(
        method=method,
        line_search=line_search,
        preset=preset,
        gap_tolerance=tolerance,
        violation_tolerance=tolerance,
    )
    if preset is not None and method != "gradient":
        raise OptionError(f"preset: {preset!r} belongs to the method 'gradient', not {method!r}")
    pinned = np.isinf(problem.masses)
    order = np.argsort(pinned, kind="stable")
    place = np.empty(len(order), np.int32)
    place[order] = np.arange(len(order))
    system = ZoneSystem(
        np.array([0, len(problem.nodes)]),
        np.array([0, np.count_nonzero(~pinned)]),
        place[problem.nodes],
        problem.weights,
        problem.normals,
        problem.targets[order],
        problem.masses[order],
        problem.thickness,
    )
    solution = solve_system(system, options)
    positions = solution.positions[place]
    return ZoneSolution(
        positions,
        solution.multipliers,
        residuals(problem, positions, solution.multipliers),
        solution.methods[0],
        int(solution.iterations[0]),
        bool(solution.feasible[0]),
    )
