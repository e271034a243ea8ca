"""Solve zones: pick the method, launch, wrap."""

from dataclasses import replace

import numpy as np
from numba import get_num_threads

from izo_ref.base import checks
from izo_ref.base.devices import implementation
from izo_ref.base.errors import DeviceUnavailableError
from izo_ref.base.options import LAGRANGIAN, SWEEPS, Options
from izo_ref.solvers.augmented_lagrangian import descend, run_on_cpu
from izo_ref.solvers.cpu import zones as kernels
from izo_ref.solvers.interior_point import FARTHEST
from izo_ref.solvers.large_zone import LargeZone, solve_large_zone
from izo_ref.solvers.presets import GPU_METHOD
from izo_ref.solvers.scaled_constraints import SystemSolution, scale_constraints
from izo_ref.solvers.serial.small_zone import (
    ACTIVE_SET,
    BLOCK_PIVOT,
    CLOSED_FORM,
    Limits,
    work_of_small_zone,
)
from izo_ref.solvers.sweeps import sweep
from izo_ref.zones.problem import ZoneProblem, ZoneSolution, residuals
from izo_ref.zones.system import ZoneSystem, problem_system

INTERIOR_POINT = 3
METHOD_NAMES = np.array(
    ["closed-form", "block-pivot", "active-set", "interior-point", "apgs", "pivoting"]
)
# Some 5 ns each: a zone of n impacts is n (n + 60) of them, or a little more.
SERIAL_WORK = 20_000


def solve_system(
    system: ZoneSystem, options: Options, trace: bool = False, start=None, device: str = "cpu"
) -> SystemSolution:
    """Solve every zone of a system; small ones one a thread, large ones one by one.

    Args:
        system: `ZoneSystem`.
        options: `Options`.
        trace: whether the solution says objective and violation after each step.
        start: (n_impacts,) f8 [kg], multipliers of the last solution, 0 where there is none.
        device: `cpu`, or `cuda`, where `auto` is `newton`.

    Raises:
        OptionError, DeviceUnavailableError.
    """
    rows = scale_constraints(system)
    if checks.device(device) == "cuda":
        options, solve = _of_device(options)
        return descend(system, options, rows, trace, solve)
    if options.method in LAGRANGIAN or options.preset is not None:
        return descend(system, options, rows, trace)
    if options.method in SWEEPS:
        return sweep(system, options, rows, trace)
    n_zones = len(system.impact_offsets) - 1
    violation_m = options.violation_tolerance * system.thickness
    limits = Limits(options.gap_tolerance, violation_m, FARTHEST)
    codes, solved = np.full(n_zones, INTERIOR_POINT, np.int8), np.zeros(n_zones, bool)
    scaled, steps = np.empty(len(rows.rhs)), np.zeros(n_zones, np.int32)
    z = np.zeros((len(system.proposed), 3))
    small, first_tried = _small_zones(system, options)
    # a launch over all threads pays from some 100 us of work on
    sizes = np.diff(system.impact_offsets)[small]
    work = (sizes * (sizes + 60)).sum()
    few = work <= SERIAL_WORK and "small-launches" in options.rules
    kernel = kernels.solve_small_zones.alone if few else kernels.solve_small_zones
    n_slots = 1 if few else get_num_threads()
    number_starts, index_starts = _slots(system, small, n_slots)
    kernel(
        small,
        first_tried,
        system.impact_offsets,
        system.vertex_offsets,
        rows.unknowns,
        rows.coefficients,
        system.normals,
        rows.rhs,
        rows.lengths,
        limits,
        number_starts,
        index_starts,
        scaled,
        z.ravel(),
        codes,
        solved,
        steps,
        np.empty(number_starts[-1]),
        np.empty(index_starts[-1], np.int32),
    )
    # what is not solved so far: the interior point minds neither size nor dependent rows, and
    # judges better what is infeasible
    large = ~solved & (options.method in ("auto", "interior-point"))
    active = scaled > 0.0
    for zone in np.flatnonzero(large):
        codes[zone], solved[zone] = _solve_large(
            system, options, rows, zone, start, z, scaled, active, steps
        )
    if rows.hopeless.any():
        solved &= ~np.logical_or.reduceat(rows.hopeless, system.impact_offsets[:-1])
    displacements = (1.0 / np.sqrt(system.masses))[:, None] * z
    return SystemSolution(
        system.proposed + displacements,
        displacements,
        scaled / rows.lengths,
        active,
        solved,
        steps,
        METHOD_NAMES[codes],
    )


def _slots(system, zones, n_slots):
    """Where the work space of each slot begins: each has room for any of the zones."""
    sizes, vertices = np.diff(system.impact_offsets), np.diff(system.vertex_offsets)
    most = sizes[zones].max(initial=0), vertices[zones].max(initial=0)
    numbers, indices = work_of_small_zone(*most)
    return numbers * np.arange(n_slots + 1), indices * np.arange(n_slots + 1)


def _small_zones(system, options):
    """The zones for one thread each, and the method to begin with."""
    sizes = np.diff(system.impact_offsets)
    if options.method == "active-set":
        return np.arange(len(sizes)), np.full(len(sizes), ACTIVE_SET, np.int8)
    if options.method == "interior-point":
        return np.empty(0, np.int64), np.empty(0, np.int8)
    small = np.flatnonzero(sizes <= options.small_zone)
    single = (sizes[small] == 1) & ("closed-form" in options.rules)
    return small, np.where(single, CLOSED_FORM, BLOCK_PIVOT).astype(np.int8)


def _solve_large(system, options, rows, zone, start, z, scaled, active, steps):
    """One zone on its own; writes its part of the arrays, returns method and solved."""
    own = slice(*system.impact_offsets[zone : zone + 2])
    vertices = slice(*system.vertex_offsets[zone : zone + 2])
    if not rows.rhs[own].max() > 0.0:
        z[vertices], scaled[own], active[own] = 0.0, 0.0, False
        return INTERIOR_POINT, True
    local = np.where(rows.unknowns[own] < 0, -1, rows.unknowns[own] - vertices.start)
    large = LargeZone(
        local,
        rows.coefficients[own],
        system.normals[own],
        rows.rhs[own],
        rows.lengths[own],
        int(vertices.stop - vertices.start),
    )
    known = np.zeros(len(large.rhs)) if start is None else start[own] * large.lengths
    solution, scaled[own], method, steps[zone], solved = solve_large_zone(
        large,
        known,
        options.gap_tolerance,
        options.violation_tolerance * system.thickness,
        options.method == "interior-point",
    )
    active[own] = scaled[own] > large.times(solution) - rows.rhs[own]
    z[vertices] = solution.reshape(-1, 3)
    if (rows.unknowns[own] >= 0).all():
        _keep_centre(z[vertices], np.sqrt(system.masses[vertices]))
    return np.flatnonzero(method == METHOD_NAMES)[0], solved


def _keep_centre(z, sqrt_masses):
    """Take out the translation of a zone without pinned vertices.

    Weights sum to zero, so the optimum leaves the centre of mass where it is, and a
    translation changes no gap: what the factorisation's rounding put there can go.
    """
    for _ in range(2):
        moment = (z * sqrt_masses[:, None]).sum(axis=0)
        z -= moment * (sqrt_masses / (sqrt_masses**2).sum())[:, None]


def _of_device(options):
    """Options with the method that a GPU has for `auto`, and what runs its kernel."""
    if options.method not in ("auto", *LAGRANGIAN) and options.preset is None:
        raise DeviceUnavailableError(
            f"device 'cuda': method {options.method!r} is of the processor; a GPU has "
            f"{', '.join(LAGRANGIAN)} and the presets"
        )
    solve = implementation(
        "cuda", run_on_cpu, "izo_ref.solvers.gpu_augmented_lagrangian:run_on_gpu"
    )
    if options.method == "auto" and options.preset is None:
        options = replace(options, **GPU_METHOD)
    return options, solve


def solve_zone(
    problem: ZoneProblem,
    method: str = "auto",
    line_search: str = "backtracking",
    tolerance: float = 1e-9,
    preset: str | None = None,
    *,
    multiplier_update: str = "every-step",
    penalty: str = "fixed",
    max_steps: int = 100_000,
    precision: str = "float64",
    trace: bool = False,
    device: str = "cpu",
) -> ZoneSolution:
    """Solve one zone problem.

    Args:
        problem: `ZoneProblem`.
        method: `auto`, `active-set`, `interior-point`, `pgs`, `apgs`, `gradient`, `jacobi`,
            `chebyshev`, `cg`, `lbfgs`, `newton`; see `Options`, also for what follows.
        line_search: `exact`, `backtracking`, `wolfe`.
        tolerance: relative duality gap, and violation over the thickness.
        preset: `arcsim`, `icloth`, `xrtailor`: that system's method and parameters.
        multiplier_update: `every-step`, `inner-solve`.
        penalty: `fixed`, `grown`.
        max_steps: [steps] of an augmented-Lagrangian method, or sweeps.
        precision: `float64`, `float32`.
        trace: whether the solution says objective and violation after each step; the
            augmented-Lagrangian methods and sweeps can.
        device: `cpu`, or `cuda` for an augmented-Lagrangian method or a preset; `auto` is
            `newton` there.

    Returns:
        `ZoneSolution`; its residuals are computed outside the solver.

    Raises:
        OptionError, DeviceUnavailableError.

    Source: SPEC sections 3 to 5.
    """
    options = Options(
        method=method,
        line_search=line_search,
        preset=preset,
        multiplier_update=multiplier_update,
        penalty=penalty,
        max_steps=max_steps,
        precision=precision,
        gap_tolerance=tolerance,
        violation_tolerance=tolerance,
    )
    pinned = np.isinf(problem.masses)
    if len(problem.nodes) == 0 or pinned.all():
        nothing = np.zeros(len(problem.nodes))
        judged = residuals(problem, problem.proposed, nothing)
        feasible = judged.feasible(tolerance)
        still = np.zeros_like(problem.proposed)
        return ZoneSolution(problem.proposed.copy(), still, nothing, judged, method, 0, feasible)
    system, places = problem_system([problem])
    solution = solve_system(system, options, trace, device=device)
    positions = solution.positions[places]
    return ZoneSolution(
        positions,
        solution.displacements[places],
        solution.multipliers,
        residuals(problem, positions, solution.multipliers),
        str(solution.methods[0]),
        int(solution.iterations[0]),
        bool(solution.feasible[0]),
        solution.trace,
    )
