"""Study: is the fixed point of re-linearisation a KKT point of the nonlinear problem?

It resolves small scenes with as many rounds of re-linearisation as lower the objective. From there
it re-linearises each zone alone, with the same pairs, until the zone stands still, and measures the
residuals of `oracles/nonlinear.py`. Some zones do not stand still: they slide until pairs meet that
they do not have. The outer loop would add these pairs, its objective would rise, and so it keeps
the round before. Such zones have no fixed point to judge; they are counted.
"""

from typing import Any

import numpy as np

from izo_ref.base.arrays import Flags, Positions
from izo_ref.base.options import Options
from izo_ref.detection.cpu.frames import renew_tight_frames
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.system import zone_problem
from validation.oracles.answer import mass_norm
from validation.oracles.nonlinear import NonlinearZone
from validation.scenes.contacts import KINDS, contact_scene

THICKNESS_M = 0.02
ROUNDS = 2000
# Both are fractions of the displacement from the proposed positions. A zone stands still if a round
# moves it by at most STILL. It has left the result of `resolve` if it is farther away than LEFT.
STILL = 1e-15
LEFT = 1e-2


def fixed_point(
    problem: ZoneProblem, is_edge_edge: Flags, positions: Positions
) -> Positions | None:
    """Re-linearise a zone with its own pairs until it stands still.

    Args:
        problem: The zone.
        is_edge_edge: (n_impacts,) b1, kind of each pair.
        positions: (n, 3) f8 [m], result of `resolve`.

    Returns:
        (n, 3) f8 [m], where it stands still, or where it is after ROUNDS rounds; None if it leaves
        the result of `resolve`.
    """
    size = np.abs(positions - problem.proposed).max()
    x = positions
    weights, normals = problem.weights.copy(), problem.normals.copy()
    for _ in range(ROUNDS):
        # no gap is above an infinite thickness, so every impact gets a new frame
        renew_tight_frames(x, problem.nodes, is_edge_edge, np.inf, weights, normals)
        parts = (problem.nodes, weights, normals, problem.proposed, problem.masses)
        new = solve_zone(ZoneProblem(*parts, problem.thickness), tolerance=1e-13).positions
        step, x = np.abs(new - x).max(), new
        if not np.abs(x - positions).max() <= LEFT * size:
            return None
        if step <= STILL * size:
            break
    return x


def nonlinear_rows(seed: int = 20240607, each: int = 10) -> list[dict[str, Any]]:
    """Measure the residuals of each zone at its fixed point, and how far SLSQP moves from there.

    Args:
        seed: Seed of the scenes.
        each: Number of scenes of each kind.

    Returns:
        One row for each zone.
    """
    rows = []
    for kind in KINDS:
        for number in range(each):
            rng = np.random.default_rng([seed, number, *kind.encode()])
            scene = contact_scene(rng, kind)
            options = Options(relinearize=200, relinearize_gain=0.0, relinearize_budget=np.inf)
            result = resolve(scene, THICKNESS_M, options=options)
            for zone in range(len(result.zones)):
                rows.append({"scene": kind, "number": number} | _row(scene, result, zone))
    return rows


def _row(scene: Scene, result: Result, zone: int) -> dict[str, Any]:
    own = result.zones.impacts_of(zone)
    kinds = result.impacts.is_edge_edge[own]
    problem = zone_problem(scene, result.impacts, result.zones, zone, result.thickness)
    positions = result.positions[np.unique(result.impacts.nodes[own])]
    rounds = max(entry.round for entry in result.history)
    row: dict[str, Any] = {"impacts": len(own), "rounds": rounds}
    x = fixed_point(problem, kinds, positions)
    if x is None:
        return row | {"fixed_point": False}
    nonlinear = NonlinearZone(problem, kinds)
    kkt = nonlinear.kkt(x)
    away, message = nonlinear.slsqp_from(x)
    size = mass_norm(problem.masses, x - problem.proposed)
    moved = mass_norm(problem.masses, away - x) / size
    return row | {
        "fixed_point": True,
        "violation": kkt.violation,
        "stationarity": kkt.stationarity,
        "complementarity": kkt.complementarity,
        "slsqp_moved": moved,
        "slsqp_says": message,
    }
