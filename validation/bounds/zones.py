"""Bounds of what judges zones: the floors of residuals, the slacks, the distance to the optimum.

An input is a zone problem with positions that are not quite the optimum.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from flint import arb, ctx, fmpq

from izo_ref.base.arrays import Floats
from izo_ref.detection import weld
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones import scaled_zone
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.residuals import residuals
from izo_ref.zones.scaled_zone import ScaledZone
from validation.bounds.search import Bound, bound_of_floats, hard_floats
from validation.oracles.rational import ExactZone, active_rows, rational
from validation.scenes.zones import random_zone

BITS = 300  # precision of square roots that no rational number is
ZONE_NUMBERS = 24  # four points, a normal, two times four weights, a kind


class Tried(NamedTuple):
    """A zone and displacements near its optimum."""

    seed: int
    n_impacts: int
    mass_ratio: float
    off: float  # size of the displacement from the optimum, over the optimum's

    def zone(self) -> tuple[ZoneProblem, Floats, Floats]:
        """Return the problem, displacements from the proposed positions, and multipliers."""
        rng = np.random.default_rng(self.seed)
        problem = random_zone(rng, self.n_impacts, self.mass_ratio)
        solution = solve_zone(problem, tolerance=1e-12)
        moves = solution.displacements
        size = float(np.abs(moves).max())
        return problem, moves + self.off * size * rng.normal(size=moves.shape), solution.multipliers


def _draw(rng: np.random.Generator) -> Tried:
    return Tried(
        int(rng.integers(2**31)),
        int(2 ** rng.integers(0, 5)),
        10.0 ** float(rng.integers(0, 13)),
        10.0 ** float(rng.uniform(-17, 0)),
    )


def _change(rng: np.random.Generator, tried: Tried) -> Tried:
    other = _draw(rng)
    kind = rng.integers(3)
    if kind == 0:
        return tried._replace(off=tried.off * 10.0 ** float(rng.normal()))
    if kind == 1:
        return tried._replace(mass_ratio=other.mass_ratio)
    return other._replace(n_impacts=tried.n_impacts)


def _distance_ratio(tried: Tried) -> float:
    """The true distance to the exact optimum over the bound."""
    problem, moves, multipliers = tried.zone()
    bound = distance_bound(problem, problem.proposed + moves, multipliers, moves)
    if math.isinf(bound):
        return 0.0
    zone = ExactZone(problem)
    optimum = zone.solve(active_rows(multipliers))
    if optimum is None:
        return 0.0
    exact = [[rational(v) for v in row] for row in moves.tolist()]
    return zone.distance(exact, optimum.moves) / bound


def _slack_ratio(tried: Tried) -> float:
    """The error of gap less thickness, before it is scaled."""
    problem, moves, _ = tried.zone()
    computed, error = scaled_zone._slack(problem, moves, np.arange(len(problem.nodes)))
    worst = 0.0
    for j, nodes in enumerate(problem.nodes.tolist()):
        exact = -rational(problem.thickness)
        for node, weight in zip(nodes, problem.weights[j].tolist(), strict=True):
            for axis in range(3):
                place = rational(problem.proposed[node, axis]) + rational(moves[node, axis])
                exact += rational(weight) * rational(problem.normals[j, axis]) * place
        worst = max(worst, float(abs(rational(computed[j]) - exact) / rational(error[j])))
    return worst


def _exact_rows(problem: ZoneProblem) -> list[dict[tuple[int, int], arb]]:
    """Return the rows of C in BITS bits, by vertex and axis."""
    rows = []
    for nodes, weights, normal in zip(
        problem.nodes.tolist(), problem.weights.tolist(), problem.normals.tolist(), strict=True
    ):
        row: dict[tuple[int, int], arb] = {}
        for node, weight in zip(nodes, weights, strict=True):
            for axis in range(3):
                entry = arb(weight) * arb(normal[axis]) / arb(float(problem.masses[node])).sqrt()
                row[node, axis] = row.get((node, axis), arb(0)) + entry
        length = sum((v * v for v in row.values()), arb(0)).sqrt()
        rows.append({key: v / length for key, v in row.items()})
    return rows


def _moved_ratio(tried: Tried) -> float:
    """The error of C times a step, over what `moved` adds for it."""
    ctx.prec = BITS
    problem, moves, _ = tried.zone()
    zone = ScaledZone(problem, moves)
    step = np.random.default_rng(tried.seed).normal(size=zone.matrix.shape[1])
    slack, error = zone.moved(step)
    before, worst = arb(0), 0.0
    for j, row in enumerate(_exact_rows(problem)):
        k = int(zone.constraint_of.ravel()[j])
        before = arb(float(zone.slack[k]))
        exact = before - sum((v * arb(step[3 * i + a]) for (i, a), v in row.items()), arb(0))
        room = arb(error[k]) - arb(zone.slack_error[k])
        worst = max(worst, float(abs(arb(slack[k]) - exact) / room))
    return worst


def _pulled_ratio(tried: Tried) -> float:
    """The error of C^T times multipliers, as a length."""
    ctx.prec = BITS
    problem, moves, _ = tried.zone()
    zone = ScaledZone(problem, moves)
    pushes = np.random.default_rng(tried.seed).random(len(zone.slack))
    pulled, error = zone.pulled(pushes)
    exact = [arb(0)] * len(pulled)
    seen = set()
    for j, row in enumerate(_exact_rows(problem)):
        k = int(zone.constraint_of.ravel()[j])
        if k not in seen:  # equal impacts are one constraint
            seen.add(k)
            for (i, a), v in row.items():
                exact[3 * i + a] += v * arb(pushes[k])
    off = sum(((arb(p) - e) ** 2 for p, e in zip(pulled.tolist(), exact, strict=True)), arb(0))
    return float(off.sqrt() / arb(error))


def _floor_ratio(x: Floats) -> float:
    """The violation of an exact optimum whose positions are rounded, over the floor.

    The thickness is the exact gap at the points, so nothing is violated there. The exact optimum
    may be half a unit in the last place away from every coordinate.
    """
    points, normal = x[:12].reshape(4, 3), x[12:15] / np.linalg.norm(x[12:15])
    first, second = np.abs(x[15:19]), np.abs(x[19:23])
    is_edge_edge = x[23] > 0.0
    if is_edge_edge:
        weights = np.array([1.0 - first[0] / 4, first[0] / 4, second[0] / 4 - 1.0, -second[0] / 4])
    else:
        weights = np.array([1.0, *(-second[:3] / second[:3].sum())])
    gap = sum(
        (
            rational(weights[k]) * rational(normal[axis]) * rational(points[k, axis])
            for k in range(4)
            for axis in range(3)
        ),
        fmpq(0),
    )
    if gap < 0:
        normal, gap = -normal, -gap
    thickness = float(gap.p) / float(gap.q)
    if thickness <= 0.0:
        return 0.0
    problem = ZoneProblem([[0, 1, 2, 3]], [weights], [normal], points, np.ones(4), thickness)
    found = residuals(problem, points, np.zeros(1))
    half = np.spacing(np.abs(points)) / 2.0
    moved = float((np.abs(weights)[:, None] * np.abs(normal) * half).sum())
    return (found.violation_m + moved) / (found.violation_floor * thickness)


def _weld_ratio(x: Floats) -> float:
    """The relative error of a distance, over what `weld` allows for two of them."""
    computed = float(weld._distances(x[None, :3], x[None, 3:6])[0])
    exact_sq = sum(
        ((rational(p) - rational(q)) ** 2 for p, q in zip(x[:3], x[3:6], strict=True)), fmpq(0)
    )
    if exact_sq == 0:
        return 0.0
    relative = abs(rational(computed) ** 2 / exact_sq - 1) / 2  # of the root, to first order
    return float(relative / rational(weld.ROUNDING - 1.0))


def _numbers(n: int, rng: np.random.Generator) -> Floats:
    return hard_floats(rng, n)


def _of_zones(name: str, file: str, sentence: str, ratio: Callable[[Tried], float]) -> Bound:
    path = f"izo_ref/zones/{file}"
    return Bound(name, path, sentence, ratio, _draw, _change, _written, _parsed, 2_000)


def _written(tried: Tried) -> str:
    return f"{tried.seed} {tried.n_impacts} {tried.mass_ratio.hex()} {tried.off.hex()}"


def _parsed(text: str) -> Tried:
    seed, n_impacts, mass_ratio, off = text.split()
    return Tried(int(seed), int(n_impacts), float.fromhex(mass_ratio), float.fromhex(off))


BOUNDS = [
    _of_zones(
        "distance to the optimum of a zone",
        "distance.py",
        "The true distance, from the exact optimum, over the bound. Near the optimum it is from "
        "1 / sqrt 2 to 1 by the derivation, and less where rounding counts.",
        _distance_ratio,
    ),
    _of_zones(
        "slack of an impact",
        "scaled_zone.py",
        "Gap less thickness, from differences of positions.",
        _slack_ratio,
    ),
    _of_zones(
        "slack after a step",
        "scaled_zone.py",
        "Entries of C and the product: 20 of 24 u of the sizes of the terms. Where the slack is "
        "far larger than the step, the bound is that of one subtraction, which is reached.",
        _moved_ratio,
    ),
    _of_zones(
        "pull of the multipliers",
        "scaled_zone.py",
        "A sum over the impacts of a vertex, as a length; errors of different signs cancel.",
        _pulled_ratio,
    ),
    bound_of_floats(
        "floor of the violation",
        "izo_ref/zones/serial/residuals.py",
        "The violation of an exact optimum whose positions are rounded: all of the derivation, "
        "30 of 32 u.",
        _floor_ratio,
        partial(_numbers, ZONE_NUMBERS),
    ),
    bound_of_floats(
        "distance of two vertices that are welded",
        "izo_ref/detection/weld.py",
        "One of two distances whose rounding the factor covers.",
        _weld_ratio,
        partial(_numbers, 6),
    ),
]
