"""Study of oracles: our solver and libraries of other authors against the exact optimum of zones.

It solves random zones, one impact with masses over six decades, and the largest zones of whole
steps, and measures relative errors, residuals and times. `python -m validation zones` starts it.
"""

import time
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
from flint import fmpq

from izo_ref.base.arrays import Floats
from izo_ref.loop.resolve import resolve
from izo_ref.scene import Scene
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.problem import ZoneProblem, ZoneSolution
from izo_ref.zones.residuals import residuals
from izo_ref.zones.system import zone_problem
from validation.oracles import nnls, qp, slsqp
from validation.oracles.answer import Answer, mass_norm
from validation.oracles.rational import ExactPoint, ExactZone, active_rows
from validation.scenes.zones import random_zone

SIZES = (1, 2, 4, 8, 16, 32, 64)
MASS_RATIOS = (1.0, 1e3, 1e6, 1e9, 1e12)
ORACLES: dict[str, Callable[[ZoneProblem], Answer]] = {
    "NNLS": nnls.solve,
    "SLSQP, scaled": slsqp.solve_scaled,
}
LARGE = ("piqp", "clarabel", "osqp", "proxqp", "daqp")


def ours(problem: ZoneProblem) -> ZoneSolution:
    """Solve a zone with the default solver, at a tolerance close to rounding."""
    return solve_zone(problem, tolerance=1e-12)


def _optimum(zone: ExactZone, active: Iterable[int] = ()) -> ExactPoint:
    """Compute the exact optimum of a feasible zone."""
    optimum = zone.solve(active)
    if optimum is None:
        raise ValueError("zone: expected one that some positions satisfy")
    return optimum


def random_zone_rows(
    seed: int = 20240607, count: int = 200, solvers: bool = True
) -> list[dict[str, Any]]:
    """Measure the relative error of each solver against the exact optimum of random zones.

    `error` is |x - x*| over |x* - y| in the norm of the masses. For our solver there is also the
    error of its positions, which are rounded to floats, next to the least error that any positions
    in floats can have.

    Args:
        seed: Seed of the zones.
        count: Number of zones.
        solvers: Ask the solvers of LARGE, too.

    Returns:
        One row for each zone.
    """
    rows = []
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        size = SIZES[number % len(SIZES)]
        ratio = MASS_RATIOS[number // len(SIZES) % len(MASS_RATIOS)]
        problem = random_zone(rng, size, ratio)
        solution = ours(problem)
        begin = time.perf_counter()
        zone = ExactZone(problem)
        optimum = _optimum(zone, active_rows(solution.multipliers))
        seconds = time.perf_counter() - begin
        nearest = [
            [float(y + m) for y, m in zip(proposed, move, strict=True)]
            for proposed, move in zip(
                _fractions(zone.proposed), _fractions(optimum.moves), strict=True
            )
        ]
        error: dict[str, float] = {"ours": zone.relative_error(solution.displacements, optimum)}
        row: dict[str, Any] = {
            "number": number,
            "impacts": size,
            "mass_ratio": ratio,
            "active": sum(value != 0 for value in optimum.multipliers),
            "method": solution.method,
            "error": error,
            "error_of_positions": zone.relative_error(zone.moves(solution.positions), optimum),
            "least_of_positions": zone.relative_error(zone.moves(np.array(nearest)), optimum),
            "exact_s": seconds,
            "claims": {},
        }
        names = list(ORACLES) + (list(LARGE) if solvers else [])
        for name in names:
            answer = ORACLES[name](problem) if name in ORACLES else qp.solve(problem, name)
            error[name] = zone.relative_error(answer.displacements, optimum)
            row["claims"][name] = answer.claims
        rows.append(row)
    return rows


def _fractions(points: Iterable[Iterable[fmpq]]) -> list[list[Fraction]]:
    return [[Fraction(int(v.p), int(v.q)) for v in point] for point in points]


def one_impact(depth: float, masses: Sequence[float] = (1e-3, 1.0, 1.0, 1e3)) -> ZoneProblem:
    """Make a zone of one vertex behind a face, with masses over six decades.

    Args:
        depth: Distance of the vertex behind the face [m].
        masses: Masses of the vertex and of the corners [kg].
    """
    return ZoneProblem(
        [[0, 1, 2, 3]],
        [[1.0, -0.3, -0.3, -0.4]],
        [[0.0, 0.0, 1.0]],
        [[0.3, 0.3, -depth], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        masses,
        1e-4,
    )


def scaling_rows() -> list[dict[str, Any]]:
    """Measure SLSQP on one impact, raw and scaled: what it claims, and its error.

    Returns:
        One row for each depth, form and tolerance.
    """
    forms: dict[str, Callable[..., Answer]] = {
        "raw": slsqp.solve_raw,
        "raw, with gradients": lambda *args, **kw: slsqp.solve_raw(*args, gradients=True, **kw),
        "scaled": slsqp.solve_scaled,
    }
    rows = []
    for depth, form, ftol in product((1e-2, 1e-3, 1e-5), forms, (1e-6, 1e-12)):
        problem = one_impact(depth)
        zone = ExactZone(problem)
        optimum = _optimum(zone)
        answer = forms[form](problem, ftol=ftol)
        error = zone.relative_error(answer.displacements, optimum)
        rows.append(
            {
                "depth": depth,
                "form": form,
                "ftol": ftol,
                "claims": answer.claims,
                "says": answer.message,
                "error": error,
                "largest_position_error": _position_error(answer, optimum),
            }
        )
    return rows


def _position_error(answer: Answer, optimum: ExactPoint) -> float:
    """Compute the largest error of a displacement over the largest displacement."""
    exact = np.array([[float(v) for v in move] for move in _fractions(optimum.moves)])
    return float(np.abs(answer.displacements - exact).max() / np.abs(exact).max())


def size_rows(seed: int = 20240607, limit_s: float = 2.0, repeats: int = 5) -> list[dict[str, Any]]:
    """Measure the time of the dense oracles by size.

    Args:
        seed: Seed of the zones.
        limit_s: An oracle whose median takes longer gets no larger zones.
        repeats: Number of zones of each size.

    Returns:
        One row for each oracle and size, with the median time.
    """
    rows = []
    solvers = dict(ORACLES)
    for size in (1, 4, 16, 64, 128, 256, 512):
        for name in list(solvers):
            seconds, errors = [], []
            for number in range(repeats):
                rng = np.random.default_rng([seed, size, number])
                problem = random_zone(rng, size, 1e3)
                answer = solvers[name](problem)
                seconds.append(answer.seconds)
                errors.append(_against_ours(problem, answer.displacements))
            median = float(np.median(seconds))
            rows.append(
                {"oracle": name, "impacts": size, "seconds": median, "against_ours": max(errors)}
            )
            if median > limit_s:
                del solvers[name]
    return rows


def _against_ours(problem: ZoneProblem, displacements: Floats) -> float:
    """Compute the relative mass-weighted distance to our answer; infinity if there is no answer."""
    if not np.isfinite(displacements).all():
        return float("inf")
    own = ours(problem).displacements
    return mass_norm(problem.masses, own - displacements) / mass_norm(problem.masses, own)


def problem_rows(
    name: str, problem: ZoneProblem, solvers: Sequence[str] = ("piqp", "clarabel")
) -> list[dict[str, Any]]:
    """Solve a zone with our solver and with others, and judge each answer in the same way.

    Args:
        name: Name of the zone in the rows.
        problem: The zone.
        solvers: Names of solvers of `oracles/qp.py`.

    Returns:
        One row for each solver, with the residuals and the proved distance to the optimum.
    """
    begin = time.perf_counter()
    solution = ours(problem)
    seconds = time.perf_counter() - begin
    rows = [_judged(name, problem, "ours", solution, solution.method, seconds)]
    for solver in solvers:
        answer = qp.solve(problem, solver)
        row = _judged(name, problem, solver, answer, answer.message, answer.seconds)
        row["against_ours"] = _against_ours(problem, answer.displacements)
        rows.append(row)
    return rows


def _judged(
    name: str,
    problem: ZoneProblem,
    solver: str,
    answer: Answer | ZoneSolution,
    says: str,
    seconds: float,
) -> dict[str, Any]:
    """Return the row of an answer."""
    positions = problem.proposed + answer.displacements
    multipliers = answer.multipliers
    if multipliers is None:
        multipliers = np.full(len(problem.nodes), np.nan)
    judged = residuals(problem, positions, multipliers)
    size = mass_norm(problem.masses, answer.displacements)
    bound = distance_bound(problem, positions, multipliers, answer.displacements)
    return {
        "zone": name,
        "impacts": len(problem.nodes),
        "solver": solver,
        "says": says,
        "gap": judged.gap,
        "violation": judged.violation,
        "stationarity": judged.stationarity,
        "distance": bound / size if size > 0.0 else bound,
        "seconds": seconds,
    }


def step_zone_rows(
    name: str, scene: Scene, thickness: float = 1e-4, largest: int = 20
) -> list[dict[str, Any]]:
    """Resolve a step, and measure the largest zones of its last iteration with `problem_rows`.

    Args:
        name: Name of the step in the rows.
        scene: The step.
        thickness: [m].
        largest: Number of zones.

    Returns:
        The rows of all these zones.
    """
    result = resolve(scene, thickness)
    sizes = np.diff(result.zones.impact_offsets)
    rows = []
    for zone in np.argsort(-sizes, kind="stable")[:largest]:
        problem = zone_problem(scene, result.impacts, result.zones, int(zone), thickness)
        rows += problem_rows(f"{name}, zone {int(zone)}", problem)
    return rows
