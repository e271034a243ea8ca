"""Inputs of `ZoneProblem` and `solve_zone`, and a judge of solutions in rational numbers."""

import math
from fractions import Fraction
from typing import Any

import numpy as np

import izo_ref
from izo_ref.base.options import CHOICES
from validation.fuzz import contract
from validation.fuzz.arrays import Rng, strange_value
from validation.fuzz.calls import disturbed, is_finite, shown
from validation.fuzz.tables import is_empty_flags, is_ordinary, mixes_flags, number_of, table_of
from validation.fuzz.trial import Trial

ORDINARY = 1e20  # largest coordinate for which every number of an answer has to be finite [m]
HEAVY = 1e290  # [kg], up to which multipliers of ordinary zones are finite


def zone_arrays(rng: Rng) -> dict[str, Any]:
    """Return the arguments of a valid zone problem."""
    n, k = int(rng.integers(4, 9)), int(rng.integers(0, 6))
    nodes = np.array([rng.choice(n, 4, replace=False) for _ in range(k)], int).reshape(-1, 4)
    weights = np.empty((k, 4))
    for i in range(k):
        inside = rng.dirichlet(np.ones(3))
        weights[i] = [1.0, *-inside]
    normals = rng.normal(size=(k, 3))
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-9)[:, None]
    masses = 10.0 ** rng.uniform(-3, 3, n)
    masses[rng.random(n) < 0.2] = np.inf
    return {
        "nodes": nodes,
        "weights": weights,
        "normals": normals,
        "proposed": rng.normal(size=(n, 3)),
        "masses": masses,
        "thickness": float(10.0 ** rng.uniform(-6, 0)),
    }


def zone_trial(rng: Rng) -> Trial:
    """Return a call of `ZoneProblem` and `solve_zone`."""
    arguments = disturbed(rng, zone_arrays(rng), 0.7)
    given: dict[str, Any] = {}
    if rng.random() < 0.6:
        offered = CHOICES["method"]
        given["method"] = offered[rng.integers(len(offered))]
        given["max_steps"] = 1000
    wrongs = contract.zone_wrongs(arguments)
    if rng.random() < 0.1:
        given["tolerance"] = strange_value(rng)
        wrong = contract.positive_wrong("tolerance", given["tolerance"], 0.0)
        wrongs += [wrong] if wrong else []
    tables = [table_of(arguments[k]) for k in ("proposed", "weights", "normals")]
    tables += [table_of(arguments[k]) for k in ("nodes", "masses")]
    mixed = any(t is not None and mixes_flags(t) for t in tables)
    mixed |= any(map(is_empty_flags, arguments.values()))
    is_open = False
    proposed = table_of(arguments["proposed"])
    is_open |= proposed is not None and not is_ordinary(proposed)
    thickness = number_of(arguments["thickness"])
    is_open |= thickness is not None and not 1e-20 < thickness < 1e20

    def call() -> Any:
        problem = izo_ref.ZoneProblem(**arguments)
        return problem, izo_ref.solve_zone(problem, **given)

    what = f"solve_zone({shown(arguments)}, {shown(given)})"
    is_open = mixed or (is_open and not wrongs)
    return Trial(call, None if is_open else wrongs, zone_problem_of, what)


def zone_problem_of(found: tuple[izo_ref.ZoneProblem, izo_ref.ZoneSolution]) -> str:
    """Return what is wrong with the solution of a zone: its numbers, or that it is called solved.

    The violation is computed in rational numbers.
    """
    problem, solution = found
    if not (is_finite(solution.positions) and is_finite(solution.displacements)):
        return "a position is not finite"
    # at extreme sizes, a multiplier that no float can hold becomes infinite (docs/limits)
    is_ordinary = max(np.abs(problem.proposed).max(), problem.thickness) < ORDINARY
    is_ordinary &= problem.masses[np.isfinite(problem.masses)].max(initial=0.0) < HEAVY
    if not is_finite(solution.multipliers) and is_ordinary:
        return "a multiplier is not finite"
    judged = solution.residuals
    if any(map(math.isnan, judged)):
        return "a residual is NaN"
    if not judged.solved(1e-9, 1e-9):
        return ""
    if not solution.feasible and judged.gap <= 1e-9 and len(problem.nodes) == 1:
        return "a solved zone is called infeasible"
    worst = Fraction(0)
    ends = [[Fraction(float(x)) for x in row] for row in solution.positions]
    for nodes, weights, normal in zip(problem.nodes, problem.weights, problem.normals, strict=True):
        gap = -Fraction(problem.thickness)
        for node, weight in zip(nodes.tolist(), weights.tolist(), strict=True):
            # relative to the first node, because weights sum to zero to their rounding only
            ends_of = zip(ends[node], ends[int(nodes[0])], normal.tolist(), strict=True)
            gap += sum(Fraction(weight) * Fraction(n) * (x - o) for x, o, n in ends_of)
        worst = max(worst, -gap)
    allowed = 2.0 * max(1e-9, judged.violation_floor) * problem.thickness
    if math.isinf(allowed):  # beyond the largest float
        return ""
    return "" if worst <= Fraction(allowed) else f"called solved, but violated by {float(worst)} m"
