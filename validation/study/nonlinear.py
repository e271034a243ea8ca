"""Is the fixed point of re-linearisation a KKT point of the nonlinear problem?

Small scenes are resolved with as many rounds of re-linearisation as pay. From there the
zone alone is re-linearised on, with the same pairs, until it stands still. Some zones do
not stand still: with the pairs they have they slide off, into pairs they do not have; the
outer loop takes those in, and its objective rises, so it keeps the round before. Such zones
have no fixed point to judge and are counted.
"""

import numpy as np

from izo_ref.base.options import Options
from izo_ref.detection.cpu.frames import compute_closest_frames
from izo_ref.loop.resolve import resolve
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.system import zone_problem
from validation.oracles.answer import mass_norm
from validation.oracles.nonlinear import NonlinearZone
from validation.scenes.contacts import KINDS, contact_scene

THICKNESS_M = 0.02
ROUNDS = 2000
# Of the displacement: a zone that stands still moves less in a round,
STILL = 1e-15
# and one that goes farther than this from the result of `resolve` has left it.
LEFT = 1e-2


def fixed_point(problem, is_edge_edge, positions):
    """Re-linearise a zone with its own pairs until it stands still; None if it leaves."""
    size = np.abs(positions - problem.proposed).max()
    x = positions
    weights, normals = np.empty_like(problem.weights), np.empty_like(problem.normals)
    for _ in range(ROUNDS):
        compute_closest_frames(x, problem.nodes, is_edge_edge, weights, normals)
        parts = (problem.nodes, weights, normals, problem.proposed, problem.masses)
        new = solve_zone(ZoneProblem(*parts, problem.thickness), tolerance=1e-13).positions
        step, x = np.abs(new - x).max(), new
        if not np.abs(x - positions).max() <= LEFT * size:
            return None
        if step <= STILL * size:
            break
    return x


def nonlinear_rows(seed=20240607, each=10):
    """One row a zone: residuals at the fixed point, and how far SLSQP goes from it."""
    rows = []
    for kind in KINDS:
        for number in range(each):
            rng = np.random.default_rng([seed, number, *kind.encode()])
            scene = contact_scene(rng, kind)
            options = Options(relinearize=200, relinearize_gain=0.0)
            result = resolve(scene, THICKNESS_M, options=options)
            for zone in range(len(result.zones)):
                rows.append({"scene": kind, "number": number} | _row(scene, result, zone))
    return rows


def _row(scene, result, zone):
    own = result.zones.impacts_of(zone)
    kinds = result.impacts.is_edge_edge[own]
    problem = zone_problem(scene, result.impacts, result.zones, zone, result.thickness)
    positions = result.positions[np.unique(result.impacts.nodes[own])]
    row = {"impacts": len(own), "rounds": max(entry.round for entry in result.history)}
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
