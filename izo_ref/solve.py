"""Solve zones: pick the method, launch, wrap."""

import numpy as np

from izo_ref.cpu import zones as kernels
from izo_ref.descent import descend
from izo_ref.errors import OptionError
from izo_ref.interior_point import FARTHEST, interior_point, scaled_matrix
from izo_ref.options import Options
from izo_ref.problem import ZoneProblem, ZoneSolution, residuals
from izo_ref.rows import SystemSolution, scaled_rows
from izo_ref.serial.active_set import INFEASIBLE, SOLVED
from izo_ref.zones import ZoneSystem, problem_system


def solve_system(system: ZoneSystem, options: Options) -> SystemSolution:
    """Solve every zone of a system; small ones one a thread, large ones one by one."""
    rows = scaled_rows(system)
    if options.method == "gradient":
        return descend(system, options, rows)
    n_zones = len(system.impact_offsets) - 1
    sizes = np.diff(system.impact_offsets)
    auto = options.method == "auto"
    single = (sizes == 1) & auto
    small = ~single & ((sizes <= options.small_zone) if auto else options.method == "active-set")

    scaled, steps = np.zeros(len(rows.rhs)), np.zeros(n_zones, np.int32)
    # one impact alone: l = max(0, r / K), and K = 1 for a unit row
    alone = system.impact_offsets[:-1][single]
    scaled[alone] = np.maximum(rows.rhs[alone], 0.0)
    z = _pull(rows, system.normals, scaled, len(system.targets))
    statuses = _solve_small(system, rows, small, scaled, z, steps)
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
    displacements = (1.0 / np.sqrt(system.masses))[:, None] * z
    return SystemSolution(
        system.targets + displacements,
        displacements,
        scaled / rows.lengths,
        active,
        feasible,
        steps,
        methods,
    )


def _solve_small(system, rows, small, scaled, z, steps):
    """Active set for the zones marked; writes multipliers, z and steps, returns statuses."""
    statuses = np.full(len(small), SOLVED, np.int8)
    if small.any():
        kernels.solve_active_set(
            np.flatnonzero(small),
            system.impact_offsets,
            system.vertex_offsets,
            rows.unknowns,
            rows.coefficients,
            system.normals,
            rows.rhs,
            scaled,
            z,
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
    if len(problem.nodes) == 0 or pinned.all():
        nothing = np.zeros(len(problem.nodes))
        judged = residuals(problem, problem.targets, nothing)
        feasible = judged.feasible(tolerance)
        still = np.zeros_like(problem.targets)
        return ZoneSolution(problem.targets.copy(), still, nothing, judged, method, 0, feasible)
    system, places = problem_system([problem])
    solution = solve_system(system, options)
    positions = solution.positions[places]
    return ZoneSolution(
        positions,
        solution.displacements[places],
        solution.multipliers,
        residuals(problem, positions, solution.multipliers),
        str(solution.methods[0]),
        int(solution.iterations[0]),
        bool(solution.feasible[0]),
    )
