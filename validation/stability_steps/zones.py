"""Judge the zones of a result: residuals in numbers of 80 bits, and the exact optimum."""

from typing import NamedTuple

import numpy as np

from izo_ref import Scene
from izo_ref.base.records import Status
from izo_ref.loop.resolve import Result
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.problem import Residuals
from izo_ref.zones.system import zone_problem
from validation.oracles.rational import ExactZone, active_rows

EXACT_IMPACTS = 12  # largest zone whose exact optimum is asked for: milliseconds
# The residuals are computed in doubles from rounded positions. Their floors bound the rounding of
# positions; the rounding of the computation itself is of the same size.
FLOORS = 2.0


class ExactCounts(NamedTuple):
    """What the exact optimum of the zones of a result says."""

    asked: int  # zones
    wrong: list[str]


def judge_residuals(scene: Scene, result: Result) -> list[str]:
    """Recompute gap and violation of each zone that is said to be solved.

    Exponents of 80-bit numbers have room for all lengths and masses, so nothing is scaled.
    """
    wrong = []
    options = result.options
    for zone, said in enumerate(result.residuals):
        if result.zone_statuses[zone] is not Status.FREE:
            continue
        gap, violation = _residuals(scene, result, zone)
        most_gap = _allowed(options.gap_tolerance, said.gap_floor)
        most_violation = _allowed(options.violation_tolerance, said.violation_floor)
        if not gap <= most_gap:
            wrong.append(f"gap: zone {zone} has {float(gap):.3e}, {_said(said)}")
        if not violation <= most_violation:
            wrong.append(f"violation: zone {zone} has {float(violation):.3e}, {_said(said)}")
    return wrong


def _allowed(tolerance: float, floor: float) -> float:
    return tolerance * (1.0 + 1e-6) + FLOORS * floor


def _said(said: Residuals) -> str:
    return f"said {said.gap:.3e} and {said.violation:.3e}, floors {said.gap_floor:.1e} and " + (
        f"{said.violation_floor:.1e}"
    )


def _residuals(scene: Scene, result: Result, zone: int) -> tuple[np.longdouble, np.longdouble]:
    """Return the relative gap and the violation over the thickness of a zone."""
    own = result.zones.impacts_of(zone)
    nodes = result.impacts.nodes[own]
    wide = np.longdouble
    x, y = result.positions.astype(wide), scene.positions_t1.astype(wide)
    pushes = np.maximum(result.multipliers[own], 0.0).astype(wide)
    rows = result.impacts.weights[own].astype(wide)[:, :, None]
    rows = rows * result.impacts.normals[own].astype(wide)[:, None, :]
    slack = (rows * (x[nodes] - x[nodes[:, :1]])).sum(axis=(1, 2)) - wide(result.thickness)
    vertices = result.zones.vertices_of(zone)
    forces = np.zeros_like(x)
    np.add.at(forces, nodes, rows * pushes[:, None, None])
    root = np.sqrt(scene.masses[vertices].astype(wide))[:, None]
    moved = root * (x - y)[vertices]
    error = moved - forces[vertices] / root
    objective = (moved**2).sum() / 2
    gap = (error**2).sum() / 2 + (pushes * np.abs(slack)).sum()
    violation = max(wide(0.0), -slack.min(initial=wide(np.inf)))
    return _ratio(gap, objective), violation / wide(result.thickness)


def _ratio(value: np.longdouble, scale: np.longdouble) -> np.longdouble:
    if scale > 0.0:
        return value / scale
    return np.longdouble(0.0 if value == 0.0 else np.inf)


def judge_exactly(scene: Scene, result: Result) -> ExactCounts:
    """Compare the answers of small zones with the exact optimum, by the proved distance."""
    asked, wrong = 0, []
    for zone in range(len(result.zones)):
        own = result.zones.impacts_of(zone)
        if len(own) > EXACT_IMPACTS or result.zone_statuses[zone] is Status.BLOCKED:
            continue
        asked += 1
        problem = zone_problem(scene, result.impacts, result.zones, zone, result.thickness)
        vertices = np.unique(result.impacts.nodes[own])
        positions, multipliers = result.positions[vertices], result.multipliers[own]
        bound = distance_bound(problem, positions, multipliers)
        if np.isnan(bound) or bound < 0.0:
            wrong.append(f"distance bound: zone {zone} has {bound}")
        exact = ExactZone(problem)
        optimum = exact.solve(active_rows(multipliers))
        if optimum is None:
            # a zone that nothing satisfies may be violated by less than the tolerance
            if np.isfinite(bound):
                wrong.append(f"distance bound: zone {zone} has no solution, {bound:.3e} was proved")
            continue
        distance = exact.distance(exact.moves(positions), optimum.moves)
        if not distance <= bound * (1.0 + 1e-12):
            wrong.append(f"distance bound: zone {zone} is off by {distance:.6e} > {bound:.6e}")
    return ExactCounts(asked, wrong)
