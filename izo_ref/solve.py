"""Solve zones: pick the method, launch, wrap."""

from typing import NamedTuple

import numpy as np

from izo_ref.cpu import zones as kernels
from izo_ref.errors import OptionError
from izo_ref.interior_point import FARTHEST, interior_point, scaled_matrix
from izo_ref.options import Options
from izo_ref.problem import ZoneProblem, ZoneSolution, residuals
from izo_ref.serial.active_set import INFEASIBLE, SOLVED
from izo_ref.serial.lagrangian import Descent
from izo_ref.zones import ZoneSystem


class SystemSolution(NamedTuple):
    positions: np.ndarray  # (n_vertices, 3) f8 [m]
    multipliers: np.ndarray  # (n_impacts,) f8 [kg], of 1/2 sum m |x - y|^2
    active: np.ndarray  # (n_impacts,) b1, rows that hold the solution
    feasible: np.ndarray  # (n_zones,) b1
    iterations: np.ndarray  # (n_zones,) i4
    methods: np.ndarray  # (n_zones,) str


class _Rows(NamedTuple):
    """The system in scaled variables: C z >= s with rows of unit length."""

    unknowns: np.ndarray  # (n_impacts, 4) i4, as nodes; -1 for pinned
    coefficients: np.ndarray  # (n_impacts, 4) f8
    rhs: np.ndarray  # (n_impacts,) f8 [m kg^1/2], s
    lengths: np.ndarray  # (n_impacts,) f8 [kg^-1/2], of the rows before scaling
    hopeless: np.ndarray  # (n_impacts,) b1, violated and without unknowns


def solve_system(system: ZoneSystem, options: Options) -> SystemSolution:
    """Solve every zone of a system; small ones one a thread, large ones one by one."""
    rows = _scaled_rows(system)
    if options.method == "gradient":
        return _descend(system, options, rows)
    n_zones = len(system.impact_offsets) - 1
    sizes = np.diff(system.impact_offsets)
    auto = options.method == "auto"
    single = (sizes == 1) & auto
    small = ~single & ((sizes <= options.small_zone) if auto else options.method == "active-set")

    scaled, steps = np.zeros(len(rows.rhs)), np.zeros(n_zones, np.int32)
    # one impact alone: l = max(0, r / K), and K = 1 for a unit row
    alone = system.impact_offsets[:-1][single]
    scaled[alone] = np.maximum(rows.rhs[alone], 0.0)
    statuses = _solve_small(system, rows, small, scaled, steps)
    z = _pull(rows, system.normals, scaled, len(system.targets))
    # Rounding can make an active set cycle, or end far off where rows are nearly dependent;
    # the interior point minds neither, and judges better what is infeasible.
    met = _meets_tolerances(system, options, rows, scaled, z)
    large = ~(small | single) | (~((statuses == SOLVED) & met) & auto)
    methods = np.where(single, "closed-form", np.where(large, "interior-point", "active-set"))
    active = scaled > 0.0
    feasible = (statuses != INFEASIBLE) & met
    for zone in np.flatnonzero(large):
        feasible[zone] = _solve_large(system, options, rows, zone, z, scaled, active, steps)
    feasible &= ~np.logical_or.reduceat(rows.hopeless, system.impact_offsets[:-1])
    positions = system.targets + (1.0 / np.sqrt(system.masses))[:, None] * z
    return SystemSolution(positions, scaled / rows.lengths, active, feasible, steps, methods)


def _scaled_rows(system):
    n = len(system.nodes)
    coefficients, rhs, lengths = np.empty((n, 4)), np.empty(n), np.empty(n)
    kernels.scaled_rows(
        system.nodes,
        system.weights,
        system.normals,
        system.targets,
        1.0 / np.sqrt(system.masses),
        system.thickness,
        coefficients,
        rhs,
        lengths,
    )
    empty = lengths == 0.0
    hopeless = empty & (rhs > 0.0)
    rhs[empty] = -system.thickness  # satisfied, and in nobody's way
    lengths[empty] = 1.0
    unknowns = np.where(system.nodes < system.vertex_offsets[-1], system.nodes, -1)
    return _Rows(unknowns.astype(np.int32), coefficients, rhs, lengths, hopeless)


def _solve_small(system, rows, small, scaled, steps):
    """Active set for the zones marked; writes multipliers and steps, returns statuses."""
    statuses = np.full(len(small), SOLVED, np.int8)
    if small.any():
        kernels.solve_active_set(
            np.flatnonzero(small),
            system.impact_offsets,
            rows.unknowns,
            rows.coefficients,
            system.normals,
            rows.rhs,
            scaled,
            statuses,
            steps,
        )
    return statuses


def _meets_tolerances(system, options, rows, scaled, z):
    """(n_zones,) b1, of the zones solved so far: violation, gap and distance are small."""
    begin = system.impact_offsets[:-1]
    points = np.einsum("jk,jkx->jx", rows.coefficients, z[np.maximum(rows.unknowns, 0)])
    slack = np.einsum("jx,jx->j", system.normals, points) - rows.rhs
    violation = np.maximum.reduceat(-slack * rows.lengths, begin)
    twice = np.add.reduceat(
        np.append((z[: system.vertex_offsets[-1]] ** 2).sum(axis=1), 0.0),
        system.vertex_offsets[:-1],
    )
    gap = np.add.reduceat(scaled * np.abs(slack), begin)
    worst = np.maximum(np.maximum.reduceat(rows.rhs, begin), 0.0)
    return (
        (violation <= options.violation_tolerance * system.thickness)
        & (gap <= 0.5 * twice * options.gap_tolerance)
        & (twice <= (FARTHEST * worst) ** 2)
    )


def _solve_large(system, options, rows, zone, z, scaled, active, steps):
    """Interior point for one zone; writes its part of the arrays, returns feasible."""
    own = slice(*system.impact_offsets[zone : zone + 2])
    vertices = slice(*system.vertex_offsets[zone : zone + 2])
    if not rows.rhs[own].max() > 0.0:
        z[vertices], scaled[own], active[own] = 0.0, 0.0, False
        return True
    local = np.where(rows.unknowns[own] < 0, -1, rows.unknowns[own] - vertices.start)
    n_vertices = vertices.stop - vertices.start
    matrix = scaled_matrix(local, rows.coefficients[own], system.normals[own], n_vertices)
    solution, scaled[own], steps[zone], feasible = interior_point(
        matrix,
        rows.rhs[own],
        options.gap_tolerance,
        options.violation_tolerance * system.thickness / rows.lengths[own].max(),
    )
    active[own] = scaled[own] > matrix @ solution - rows.rhs[own]
    z[vertices] = solution.reshape(-1, 3)
    if (rows.unknowns[own] >= 0).all():
        _keep_centre(z[vertices], np.sqrt(system.masses[vertices]))
    return feasible


def _pull(rows, normals, scaled, n):
    """(n, 3) f8, C^T u."""
    z = np.zeros((n + 1, 3))  # the last row takes what acts on pinned vertices
    terms = rows.coefficients[:, :, None] * (scaled[:, None] * normals)[:, None, :]
    np.add.at(z, rows.unknowns.ravel(), terms.reshape(-1, 3))
    return z[:n]


def _keep_centre(z, sqrt_masses):
    """Take out the translation of a zone without pinned vertices.

    Weights sum to zero, so the optimum leaves the centre of mass where it is, and a
    translation changes no gap: what the factorisation's rounding put there can go.
    """
    for _ in range(2):
        moment = (z * sqrt_masses[:, None]).sum(axis=0)
        z -= moment * (sqrt_masses / (sqrt_masses**2).sum())[:, None]


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


def _descend(system, options, rows):
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
    positions = system.targets.copy()
    if options.preset == "xrtailor":
        positions[:n_free] = found
        # of mean(1/m) times 1/2 sum m |x - y|^2
        multipliers /= np.repeat(mean, per_impact)
    else:
        scale = np.repeat(largest, per_vertex) / np.sqrt(free_masses)
        positions[:n_free] += scale[:, None] * found
        multipliers *= np.repeat(largest, per_impact) / rows.lengths
    return SystemSolution(
        positions,
        multipliers,
        multipliers > 0.0,
        ~np.logical_or.reduceat(rows.hopeless, system.impact_offsets[:-1]),
        steps,
        np.full(n_zones, "gradient"),
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
    if len(problem.nodes) == 0:
        nothing = np.zeros(0)
        judged = residuals(problem, problem.targets, nothing)
        return ZoneSolution(problem.targets.copy(), nothing, judged, method, 0, True)
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
        str(solution.methods[0]),
        int(solution.iterations[0]),
        bool(solution.feasible[0]),
    )
