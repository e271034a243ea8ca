"""Judges of the zones of a result, by residuals and by oracles: facts of `check`."""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from izo_ref.app.files import SavedResult
from izo_ref.base.arrays import Multipliers, Positions
from izo_ref.base.options import Options
from izo_ref.scene import Scene
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.grouping import build_zones
from izo_ref.zones.problem import ZoneProblem, require_factors
from izo_ref.zones.residuals import residuals
from izo_ref.zones.system import zone_problem
from validation.judge import Fact, asked
from validation.limits import Limits
from validation.oracles import nnls, qp, slsqp
from validation.oracles.answer import Answer, mass_norm
from validation.oracles.rational import EXACT_IMPACTS, ExactZone, active_rows

# Largest number of impacts of a zone that an oracle is asked about; `reports/zones.json` has their
# times by size.
LIMITS = {"exact": EXACT_IMPACTS, "NNLS": 256, "SLSQP": 64}
# Number of zones that each oracle is asked about, the largest first.
ZONES_ASKED = 50
NAMES = {"exact": "exact rational arithmetic", "SLSQP": "SLSQP, scaled"}
SOLVERS: dict[str, Callable[[ZoneProblem], Answer]] = {
    "NNLS": nnls.solve,
    "SLSQP": slsqp.solve_scaled,
    "PIQP": lambda problem: qp.solve(problem, "piqp"),
}


class _JudgedZone(NamedTuple):
    """A zone of a result, with its residuals."""

    problem: ZoneProblem
    positions: Positions
    multipliers: Multipliers
    gap: float  # relative
    violation: float  # over the thickness
    distance: float  # to the optimum at most, over the distance to the proposed positions
    solved: bool  # to tolerance


def zones(scene: Scene, result: SavedResult, options: Options, limits: Limits) -> list[Fact]:
    """Judge whether each zone is optimal, by residuals and by oracles.

    Args:
        scene: The scene.
        result: A result with its impacts, multipliers and thickness.
        options: The tolerances are used.
        limits: The limits of each oracle.

    Returns:
        A fact from the residuals, and one from each oracle if there is a zone.

    Raises:
        ValueError: The result has no impacts, multipliers or thickness.
        SizeError: A weight or a normal is too large or too small for the solvers.
    """
    begin = time.perf_counter()
    judged = _judged_zones(scene, result, options)
    seconds = time.perf_counter() - begin
    if not judged:
        return [Fact("each zone is optimal", "izo_ref.residuals", "no zones", True, seconds)]
    unsolved = sum(not zone.solved for zone in judged)
    answer = (
        f"{len(judged)} zones, {unsolved} not to tolerance; "
        f"the largest relative gap is {max(zone.gap for zone in judged):.1e}, "
        f"the largest violation over the thickness {max(zone.violation for zone in judged):.1e}, "
        "the largest proved relative distance to the optimum "
        f"{max(zone.distance for zone in judged):.1e}"
    )
    facts = [Fact("each zone is optimal", "izo_ref.residuals", answer, unsolved == 0, seconds)]
    for name in ("exact", "NNLS", "SLSQP", "PIQP"):
        by = NAMES.get(name, name)
        ask = "zones agree with an oracle", by, limits, _zones_by, name, judged
        facts.append(asked(*ask)[0])
    return facts


def _judged_zones(scene: Scene, result: SavedResult, options: Options) -> list[_JudgedZone]:
    """Compute the residuals and the distance bound of each zone of a result."""
    impacts, all_multipliers, thickness = result.impacts, result.multipliers, result.thickness
    if impacts is None or all_multipliers is None or thickness is None:
        raise ValueError("result: expected impacts, multipliers and a thickness")
    require_factors(impacts)
    grouped = build_zones(scene, impacts)
    judged = []
    for zone in range(len(grouped)):
        own = grouped.impacts_of(zone)
        vertices = np.unique(impacts.nodes[own])
        problem = zone_problem(scene, impacts, grouped, zone, thickness)
        positions, multipliers = result.positions[vertices], all_multipliers[own]
        found = residuals(problem, positions, multipliers)
        length = mass_norm(problem.masses, positions - problem.proposed)
        bound = distance_bound(problem, positions, multipliers)
        judged.append(
            _JudgedZone(
                problem,
                positions,
                multipliers,
                gap=found.gap,
                violation=found.violation,
                distance=bound / length if length > 0.0 else (0.0 if bound == 0.0 else np.inf),
                solved=found.solved(options.gap_tolerance, options.violation_tolerance),
            )
        )
    return judged


def _zones_by(oracle: str, judged: list[_JudgedZone]) -> tuple[str, bool | None]:
    """Compare the answers of zones with those of an oracle.

    The relative distance can fail only against the exact oracle. For the others it is for
    information, since it may be their own error.
    """
    chosen = sorted(judged, key=lambda zone: -len(zone.problem.nodes))
    limit = LIMITS.get(oracle, np.inf)
    chosen = [zone for zone in chosen if len(zone.problem.nodes) <= limit][:ZONES_ASKED]
    errors = [_relative_error(oracle, zone) for zone in chosen]
    failed = sum(error is None for error in errors)
    worst = max((error for error in errors if error is not None), default=0.0)
    answer = (
        f"the largest relative distance is {worst:.1e}, over {len(chosen)} of {len(judged)} zones"
    )
    if failed:
        answer += f"; no answer for {failed} of them"
    # a relative gap of 1e-9 is a relative distance of at most sqrt(1e-9) = 3.2e-5 if the
    # constraints hold; what they may be violated by adds to it
    passed = failed == 0 and worst <= 1e-4 if oracle == "exact" and chosen else None
    return answer, passed


def _relative_error(oracle: str, zone: _JudgedZone) -> float | None:
    """Compute the distance of a zone's answer to that of an oracle, over the displacement.

    Returns:
        The relative distance; None if the oracle has no answer.
    """
    problem = zone.problem
    unknown = np.isfinite(problem.masses)[problem.nodes] & (problem.weights != 0.0)
    if not (unknown.any(axis=1) & problem.normals.any(axis=1)).all():
        return None  # a constraint without an unknown or a normal, which no oracle takes
    if oracle == "exact":
        return _exact_error(zone)
    answer = SOLVERS[oracle](problem)
    if not np.isfinite(answer.displacements).all():
        return None
    offsets = zone.positions - problem.proposed - answer.displacements
    size = mass_norm(problem.masses, answer.displacements)
    error = mass_norm(problem.masses, offsets)
    return error / size if size > 0.0 else float(error > 0.0)


def _exact_error(zone: _JudgedZone) -> float | None:
    exact = ExactZone(zone.problem)
    optimum = exact.solve(active_rows(zone.multipliers))
    return None if optimum is None else exact.relative_error(exact.moves(zone.positions), optimum)
