"""Solve zones: choose a method for each zone, launch the kernels and collect the answers.

Start reading with `solve_system`. If an augmented-Lagrangian method or a sweep was asked for, it
hands the whole system to `solvers/augmented_lagrangian.py` or `solvers/sweeps.py`. Otherwise it
solves the small zones side by side, one thread a zone, and then the large zones one by one
(`solvers/large_zone.py`).
"""

import math
from functools import partial
from typing import NamedTuple

import numpy as np
from numba import get_num_threads

from izo_ref.base import checks
from izo_ref.base.arrays import Codes, Flags, Floats, Ints, Multipliers
from izo_ref.base.deadline import UNLIMITED, Deadline
from izo_ref.base.devices import import_for_gpu
from izo_ref.base.errors import DeviceUnavailableError, SizeError
from izo_ref.base.options import LAGRANGIAN, SWEEPS, Options
from izo_ref.base.units import require_ratio
from izo_ref.solvers.augmented_lagrangian import SolveOn, descend, run_on_cpu
from izo_ref.solvers.cpu import zones as kernels
from izo_ref.solvers.interior_point import FARTHEST
from izo_ref.solvers.large_zone import solve_large_zone
from izo_ref.solvers.scaled_constraints import (
    ScaledConstraints,
    SystemSolution,
    constraints_of_zone,
    scale_constraints,
)
from izo_ref.solvers.serial.small_zone import (
    ACTIVE_SET,
    BLOCK_PIVOT,
    CLOSED_FORM,
    Limits,
    choose_small_zones,
)
from izo_ref.solvers.sweeps import sweep
from izo_ref.zones.problem import ZoneProblem, ZoneSolution, require_factors, require_problem
from izo_ref.zones.problem_in_range import problem_in_range, solution_back
from izo_ref.zones.residuals import residuals
from izo_ref.zones.system import ZoneSystem, problem_system

# The name of a method, by its code. `solvers/serial/small_zone.py` has the first three codes.
METHOD_NAMES = np.array(
    ["closed-form", "block-pivot", "active-set", "interior-point", "apgs", "pivoting"]
)
INTERIOR_POINT = 3
# The small zones of a system are solved on the calling thread up to this much work, in units of
# `choose_small_zones`. A unit takes some 5 ns, or a little more. So a launch over all threads pays
# off from some 100 us of work on.
SERIAL_WORK = 20_000


class _Answers(NamedTuple):
    """Answers for all zones of a system, in scaled variables. The solvers write the arrays."""

    multipliers: Multipliers  # (n_impacts,) f8 [m kg^1/2], of the constraints of unit length
    z: Floats  # (n_vertices, 3) f8 [m kg^1/2], 0 for pinned vertices
    active: Flags  # (n_impacts,) b1
    methods: Codes  # (n_zones,) i1, the last method that was tried, an index into METHOD_NAMES
    solved: Flags  # (n_zones,) b1
    steps: Ints  # (n_zones,) i4


def solve_system(
    system: ZoneSystem,
    options: Options,
    trace: bool = False,
    start: Multipliers | None = None,
    device: str = "cpu",
    deadline: Deadline = UNLIMITED,
) -> SystemSolution:
    """Solve every zone of a system: small zones one a thread, then large zones one by one.

    Args:
        system: The zones.
        options: The method and the tolerances.
        trace: Whether to record the objective and the violation of the first zone after each
            step. The augmented-Lagrangian methods and the sweeps can do so.
        start: (n_impacts,) f8 [kg], multipliers of the last solution, 0 for impacts that it did
            not have.
        device: `cpu` or `cuda`. With `cuda`, the method `auto` is block pivoting for zones of all
            sizes, and the CPU solves what that does not solve.
        deadline: When the solvers of the CPU have to end.

    Returns:
        The solution; `feasible` is False for zones that were not solved.

    Raises:
        OptionError: `device` has another value.
        DeviceUnavailableError: There is no GPU, or the method runs on the CPU only.
        OutOfTimeError: The deadline has passed.
    """
    constraints = scale_constraints(system)
    on_gpu = checks.device(device) == "cuda"
    if on_gpu and not options.is_default_method:
        return descend(system, options, constraints, trace, _choose_gpu_method(options))
    if options.method in LAGRANGIAN or options.preset is not None:
        run = partial(run_on_cpu, deadline=deadline)
        return descend(system, options, constraints, trace, run)
    if options.method in SWEEPS:
        return sweep(system, options, constraints, trace, deadline)
    if on_gpu:
        answers = _solve_on_gpu(system, options, constraints, start)
    else:
        answers = _solve_small_zones(system, options, constraints, deadline)
    # The interior point takes the zones that are not solved so far: neither the size of a zone
    # nor dependent constraints hinder it, and it judges better what is infeasible.
    if options.method in ("auto", "interior-point"):
        for zone in deadline.checked((~answers.solved).nonzero()[0].tolist()):
            _solve_large_zone(system, options, constraints, zone, start, answers, deadline)
    solved = answers.solved
    if constraints.hopeless.any():
        solved &= ~np.logical_or.reduceat(constraints.hopeless, system.impact_offsets[:-1])
    displacements = (1.0 / np.sqrt(system.masses))[:, None] * answers.z
    return SystemSolution(
        system.proposed + displacements,
        displacements,
        answers.multipliers / constraints.lengths,
        answers.active,
        solved,
        answers.steps,
        METHOD_NAMES[answers.methods],
    )


def _solve_small_zones(
    system: ZoneSystem, options: Options, constraints: ScaledConstraints, deadline: Deadline
) -> _Answers:
    """Solve the small zones in one launch, one thread a zone; large zones count as unsolved."""
    n_zones, n_impacts = len(system.impact_offsets) - 1, len(system.nodes)
    multipliers, z = np.empty(n_impacts), np.zeros((len(system.proposed), 3))
    methods, solved = np.full(n_zones, INTERIOR_POINT, np.int8), np.zeros(n_zones, bool)
    steps = np.zeros(n_zones, np.int32)
    zones, first_tried, work, n_numbers, n_indices = choose_small_zones(
        system.impact_offsets, system.vertex_offsets, *_small_zones_of_method(options, n_impacts)
    )
    if len(zones) == 0:  # large zones alone: the kernel need not be compiled
        return _Answers(multipliers, z, np.zeros(n_impacts, bool), methods, solved, steps)
    on_one_thread = work <= SERIAL_WORK and "small-launches" in options.rules
    kernel = kernels.solve_small_zones.alone if on_one_thread else kernels.solve_small_zones
    n_slots = 1 if on_one_thread else get_num_threads()
    slots = np.arange(n_slots + 1)
    violation_m = options.violation_tolerance * system.thickness
    for part in deadline.slices(range(len(zones))):
        kernel(
            range(n_slots),
            zones[part.start : part.stop],
            first_tried[part.start : part.stop],
            system.impact_offsets,
            system.vertex_offsets,
            constraints.unknowns,
            constraints.coefficients,
            system.normals,
            constraints.rhs,
            constraints.lengths,
            Limits(options.gap_tolerance, violation_m, FARTHEST, deadline.stop),
            n_numbers * slots,
            n_indices * slots,
            multipliers,
            z.ravel(),
            methods,
            solved,
            steps,
            np.empty(n_numbers * n_slots),
            np.empty(n_indices * n_slots, np.int32),
        )
    return _Answers(multipliers, z, multipliers > 0.0, methods, solved, steps)


def _solve_on_gpu(
    system: ZoneSystem,
    options: Options,
    constraints: ScaledConstraints,
    start: Multipliers | None,
) -> _Answers:
    """Solve the zones on a GPU by block pivoting."""
    solve = import_for_gpu("izo_ref.solvers.gpu_system:solve_on_gpu")
    found = solve(system, options, constraints, start)
    z = np.zeros((len(system.proposed), 3))
    z[: len(found.z) // 3] = found.z.reshape(-1, 3)
    methods = np.full(len(found.solved), BLOCK_PIVOT, np.int8)
    steps = np.maximum(found.steps, 0)
    return _Answers(found.multipliers, z, found.multipliers > 0.0, methods, found.solved, steps)


def _small_zones_of_method(options: Options, n_impacts: int) -> tuple[int, int, int]:
    """Return the impacts of the largest small zone, and the methods to try first.

    The first method is for zones of several impacts, the second for zones of one.
    """
    if options.method == "active-set":
        return n_impacts, ACTIVE_SET, ACTIVE_SET
    largest = 0 if options.method == "interior-point" else options.small_zone
    single = CLOSED_FORM if "closed-form" in options.rules else BLOCK_PIVOT
    return largest, BLOCK_PIVOT, single


def _solve_large_zone(
    system: ZoneSystem,
    options: Options,
    constraints: ScaledConstraints,
    zone: int,
    start: Multipliers | None,
    answers: _Answers,
    deadline: Deadline,
) -> None:
    """Solve one zone on its own and write its part of the answers."""
    own = slice(*system.impact_offsets[zone : zone + 2])
    vertices = slice(*system.vertex_offsets[zone : zone + 2])
    rhs = constraints.rhs[own]
    if not rhs.max() > 0.0:  # the proposed positions satisfy every constraint
        answers.z[vertices], answers.multipliers[own], answers.active[own] = 0.0, 0.0, False
        answers.methods[zone], answers.solved[zone] = INTERIOR_POINT, True
        return
    large = constraints_of_zone(system, constraints, zone)
    masses = system.masses[vertices]
    solution = solve_large_zone(
        large,
        np.zeros(len(rhs)) if start is None else start[own] * large.lengths,
        options.gap_tolerance,
        options.violation_tolerance * system.thickness,
        options.method == "interior-point",
        # z is sqrt(m) times a displacement, so a heavy vertex that moves as far as a light one has
        # a z that is larger by the root of the ratio of their masses.
        FARTHEST * math.sqrt(float(masses.max()) / float(masses.min())),
        deadline,
    )
    multipliers = solution.multipliers
    answers.multipliers[own], answers.steps[zone] = multipliers, solution.steps
    answers.active[own] = multipliers > large.times(solution.z) - rhs
    answers.z[vertices] = solution.z.reshape(-1, 3)
    if (constraints.unknowns[own] >= 0).all():
        _keep_centre(answers.z[vertices], np.sqrt(masses))
    answers.methods[zone] = METHOD_NAMES.tolist().index(solution.method)
    answers.solved[zone] = solution.solved


def _keep_centre(z: Floats, sqrt_masses: Floats) -> None:
    """Remove the translation of a zone whose impacts have no pinned vertex, in place.

    The weights of an impact sum to zero. So the optimum leaves the centre of mass where it is,
    and a translation changes no gap. A translation can only come from rounding in the
    factorisation.
    """
    for _ in range(2):
        moment = (z * sqrt_masses[:, None]).sum(axis=0)
        z -= moment * (sqrt_masses / (sqrt_masses**2).sum())[:, None]


def _choose_gpu_method(options: Options) -> SolveOn:
    """Return the function that runs a method of the augmented Lagrangian on a GPU."""
    if options.method not in LAGRANGIAN and options.preset is None:
        raise DeviceUnavailableError(
            f"device 'cuda': method {options.method!r} runs on the CPU only; a GPU runs 'auto', "
            f"{', '.join(LAGRANGIAN)} and the presets"
        )
    return import_for_gpu("izo_ref.solvers.gpu_augmented_lagrangian:run_on_gpu")


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

    `Options` describes the methods and the options of the augmented-Lagrangian methods in full.

    Args:
        problem: The zone problem.
        method: `auto`, `active-set`, `interior-point`, `pgs`, `apgs`, `gradient`, `jacobi`,
            `chebyshev`, `cg`, `lbfgs` or `newton`.
        line_search: `exact`, `backtracking` or `wolfe`.
        tolerance: Largest relative duality gap, and largest violation as a fraction of the
            thickness.
        preset: `arcsim`, `icloth` or `xrtailor`: the method and the parameters of that system.
        multiplier_update: `every-step` or `inner-solve`.
        penalty: `fixed` or `grown`.
        max_steps: Largest number of steps of an augmented-Lagrangian method, or of sweeps.
        precision: `float64` or `float32`.
        trace: Whether to record the objective and the violation after each step. The
            augmented-Lagrangian methods and the sweeps can do so.
        device: `cpu`, or `cuda` for an augmented-Lagrangian method or a preset. With `cuda`,
            the method `auto` is block pivoting for zones of all sizes, and the CPU solves what that
            does not solve.

    Returns:
        The solution. Its residuals are computed outside the solver.

    Raises:
        OptionError: An option has a value that is not offered, or `problem` is no `ZoneProblem`.
        SizeError: The lengths of the problem differ too much from each other, a vertex would have
            to end where no float is, or the weights or
            the normals of an impact are too large or too small.
        MassError: A mass is too small beside the largest one.
        DeviceUnavailableError: There is no GPU, or the method runs on the CPU only.

    Source: docs/method sections 3 to 5.
    """
    require_problem(problem)
    require_factors(problem)
    tolerance = checks.tolerance("tolerance", tolerance)
    trace = checks.flag("trace", trace)
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
    require_ratio(problem.masses, np.isfinite(problem.masses))
    twin, units = problem_in_range(problem)
    solution = _solve_in_range(twin, options, trace, device)
    solution = solution if twin is problem else solution_back(solution, units)
    off = np.flatnonzero(~np.isfinite(solution.positions).all(axis=1))
    if len(off):
        raise SizeError(
            f"proposed: expected a zone whose answer floats can hold, but vertex {off[0]} has to "
            "end beyond the largest float. Divide all coordinates and the thickness by a power of "
            "two"
        )
    return solution


def _solve_in_range(
    problem: ZoneProblem, options: Options, trace: bool, device: str
) -> ZoneSolution:
    """Solve a zone problem of ordinary size (`zones/problem_in_range.py`)."""
    pinned = np.isinf(problem.masses)
    if len(problem.nodes) == 0 or pinned.all():
        nothing = np.zeros(len(problem.nodes))
        judged = residuals(problem, problem.proposed, nothing)
        feasible = judged.feasible(options.violation_tolerance)
        still = np.zeros_like(problem.proposed)
        ends, method = problem.proposed.copy(), options.method
        return ZoneSolution(ends, still, nothing, judged, method, 0, feasible)
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
