"""Solvers of zones against oracles: rows of numbers, no prose."""

import time
from itertools import product

import numpy as np

from izo_ref.loop.resolve import resolve
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.problem import ZoneProblem, residuals
from izo_ref.zones.system import zone_problem
from validation.oracles import nnls, qp, slsqp
from validation.oracles.answer import mass_norm
from validation.oracles.rational import ExactZone, active_rows
from validation.scenes.zones import random_zone

SIZES = (1, 2, 4, 8, 16, 32, 64)
MASS_RATIOS = (1.0, 1e3, 1e6, 1e9, 1e12)
ORACLES = {"NNLS": nnls.solve, "SLSQP, scaled": slsqp.solve_scaled}
LARGE = ("piqp", "clarabel", "osqp", "proxqp", "daqp")


def ours(problem):
    """The default solver, asked for all that floats can give."""
    return solve_zone(problem, tolerance=1e-12)


def random_zone_rows(seed=20240607, count=200, solvers=True):
    """One row a zone: the relative error of each solver against the exact optimum.

    `error` is |x - x*| over |x* - y| in the norm of the masses; of ours also that of the
    positions, rounded to floats, next to the least that any positions can have.
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
        optimum = zone.solve(active_rows(solution.multipliers))
        seconds = time.perf_counter() - begin
        nearest = [
            [float(y + m) for y, m in zip(target, move, strict=True)]
            for target, move in zip(
                _fractions(zone.proposed), _fractions(optimum.moves), strict=True
            )
        ]
        error = {"ours": zone.relative_error(solution.displacements, optimum)}
        row = {
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


def _fractions(points):
    from fractions import Fraction

    return [[Fraction(int(v.p), int(v.q)) for v in point] for point in points]


def one_impact(depth, masses=(1e-3, 1.0, 1.0, 1e3)):
    """A vertex that is `depth` behind a face [m], with masses over six decades [kg]."""
    return ZoneProblem(
        [[0, 1, 2, 3]],
        [[1.0, -0.3, -0.3, -0.4]],
        [[0.0, 0.0, 1.0]],
        [[0.3, 0.3, -depth], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        masses,
        1e-4,
    )


def scaling_rows():
    """SLSQP on one impact, as it is and scaled: what it says, and what is."""
    forms = {
        "raw": slsqp.solve_raw,
        "raw, with gradients": lambda *args, **kw: slsqp.solve_raw(*args, gradients=True, **kw),
        "scaled": slsqp.solve_scaled,
    }
    rows = []
    for depth, form, ftol in product((1e-2, 1e-3, 1e-5), forms, (1e-6, 1e-12)):
        problem = one_impact(depth)
        zone = ExactZone(problem)
        optimum = zone.solve()
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


def _position_error(answer, optimum):
    """Largest error of a displacement over the largest displacement."""
    exact = np.array([[float(v) for v in move] for move in _fractions(optimum.moves)])
    return float(np.abs(answer.displacements - exact).max() / np.abs(exact).max())


def size_rows(seed=20240607, limit_s=2.0, repeats=5):
    """Time of the dense oracles by size: medians, until one takes longer than the limit."""
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


def _against_ours(problem, displacements):
    """Relative mass-weighted distance to our answer; infinite for no answer."""
    if not np.isfinite(displacements).all():
        return float("inf")
    own = ours(problem).displacements
    return mass_norm(problem.masses, own - displacements) / mass_norm(problem.masses, own)


def problem_rows(name, problem, solvers=("piqp", "clarabel")):
    """A zone by ours and by others, each judged by our residuals and the proved distance."""
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


def _judged(name, problem, solver, answer, says, seconds):
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


def step_zone_rows(name, scene, thickness=1e-4, largest=20):
    """The largest zones in which a step ends, as it was resolved."""
    result = resolve(scene, thickness)
    sizes = np.diff(result.zones.impact_offsets)
    rows = []
    for zone in np.argsort(-sizes, kind="stable")[:largest]:
        problem = zone_problem(scene, result.impacts, result.zones, int(zone), thickness)
        rows += problem_rows(f"{name}, zone {int(zone)}", problem)
    return rows
