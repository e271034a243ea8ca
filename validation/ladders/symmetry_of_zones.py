"""Symmetries of a zone problem: impacts in another order, sides exchanged, impacts repeated."""

import time
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from izo_ref.base.arrays import AnyInts, Floats
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.problem import ZoneProblem, ZoneSolution
from validation.ladders.ladder import RIGHT, SAYS_SO, WRONG, Ladder, Outcome, Rung
from validation.oracles.rational import ExactZone, active_rows
from validation.scenes.piles import chain_zone, pinch_zone, stack_zone
from validation.scenes.zones import random_zone

FAMILY = "symmetry"
SEED = 20240608
ZONES = 48  # of each symmetry
TOLERANCE = 1e-9  # largest relative error against the exact optimum

# Takes a zone; returns another one, and what brings its displacements back.
Written: TypeAlias = tuple[ZoneProblem, Callable[[Floats], Floats]]
ZoneTwin: TypeAlias = Callable[[np.random.Generator, ZoneProblem], Written]


def drawn_zone(number: int) -> ZoneProblem:
    """Draw a zone of at most some 30 impacts; its kind changes with the number."""
    rng = np.random.default_rng([SEED, number])
    ratio, n = 10.0 ** rng.uniform(0.0, 6.0), int(rng.integers(1, 25))
    kinds = (
        lambda: random_zone(rng, n, ratio),
        lambda: chain_zone(rng, n, ratio),
        lambda: pinch_zone(rng, 2 * (1 + n // 4), ratio),
        lambda: stack_zone(rng, 2 + n // 6, 3, ratio),
    )
    return kinds[number % 4]()


def other_order(rng: np.random.Generator, zone: ZoneProblem) -> Written:
    """The impacts in another order."""
    order = rng.permutation(len(zone.nodes))
    return _changed(zone, zone.nodes[order], zone.weights[order], zone.normals[order]), _same


def sides_exchanged(rng: np.random.Generator, zone: ZoneProblem) -> Written:
    """Half of the impacts with their sides exchanged: other signs of weights and normal."""
    signs = rng.choice([-1.0, 1.0], (len(zone.nodes), 1))
    return _changed(zone, zone.nodes, signs * zone.weights, signs * zone.normals), _same


def other_corners(rng: np.random.Generator, zone: ZoneProblem) -> Written:
    """The four vertices of each impact in another order, with their weights."""
    order = rng.permuted(np.tile(np.arange(4), (len(zone.nodes), 1)), axis=1)
    nodes = np.take_along_axis(zone.nodes, order, axis=1)
    weights = np.take_along_axis(zone.weights, order, axis=1)
    return _changed(zone, nodes, weights, zone.normals), _same


def other_vertices(rng: np.random.Generator, zone: ZoneProblem) -> Written:
    """The vertices with other numbers."""
    order = rng.permutation(len(zone.masses))
    place = np.argsort(order)
    twin = ZoneProblem(
        place[zone.nodes],
        zone.weights,
        zone.normals,
        zone.proposed[order],
        zone.masses[order],
        zone.thickness,
    )
    return twin, lambda moves: moves[place]


def repeated(rng: np.random.Generator, zone: ZoneProblem) -> Written:
    """Each impact three times."""
    three = np.repeat(np.arange(len(zone.nodes)), 3)
    return _changed(zone, zone.nodes[three], zone.weights[three], zone.normals[three]), _same


def scaled(rng: np.random.Generator, zone: ZoneProblem) -> Written:
    """Lengths times 2^k and masses times 2^j."""
    k, j = int(rng.integers(-90, 91)), int(rng.integers(-90, 91))
    twin = ZoneProblem(
        zone.nodes,
        zone.weights,
        zone.normals,
        np.ldexp(zone.proposed, k),
        np.ldexp(zone.masses, j),
        float(np.ldexp(zone.thickness, k)),
    )
    return twin, lambda moves: np.ldexp(moves, -k)


def axes_exchanged(rng: np.random.Generator, zone: ZoneProblem) -> Written:
    """The axes in another order, one of them backward."""
    axes, sign = rng.permutation(3), np.array([1.0, -1.0, 1.0])
    proposed, normals = (sign * array[:, axes] for array in (zone.proposed, zone.normals))
    twin = ZoneProblem(zone.nodes, zone.weights, normals, proposed, zone.masses, zone.thickness)
    return twin, lambda moves: (sign * moves)[:, np.argsort(axes)]


def two_zones(rng: np.random.Generator, zone: ZoneProblem) -> Written:
    """Together with another zone that shares no vertex with it."""
    other, n = drawn_zone(int(rng.integers(1 << 30))), len(zone.masses)
    twin = ZoneProblem(
        np.concatenate((zone.nodes, other.nodes + n)),
        np.concatenate((zone.weights, other.weights)),
        np.concatenate((zone.normals, other.normals)),
        np.concatenate((zone.proposed, other.proposed)),
        np.concatenate((zone.masses, other.masses)),
        zone.thickness,
    )
    return twin, lambda moves: moves[:n]


def _changed(zone: ZoneProblem, nodes: AnyInts, weights: Floats, normals: Floats) -> ZoneProblem:
    return ZoneProblem(nodes, weights, normals, zone.proposed, zone.masses, zone.thickness)


def _same(moves: Floats) -> Floats:
    return moves


SYMMETRIES: dict[str, ZoneTwin] = {
    "order of impacts": other_order,
    "sides exchanged": sides_exchanged,
    "order of corners": other_corners,
    "vertices numbered anew": other_vertices,
    "impacts three times": repeated,
    "lengths times 2^k, masses times 2^j": scaled,
    "axes exchanged": axes_exchanged,
    "two zones as one": two_zones,
}


def judge_zone_symmetry(name: str, count: int) -> list[Outcome]:
    """Solve twins of zones, and compare them with the exact optimum of the zones themselves."""
    begin = time.perf_counter()
    errors, silent, unsolved = [], 0, 0
    for number in range(count):
        zone = drawn_zone(number)
        rng = np.random.default_rng([SEED, number, 1])
        twin, back = SYMMETRIES[name](rng, zone)
        found: ZoneSolution = solve_zone(twin)
        exact = ExactZone(zone)
        optimum = exact.solve(active_rows(solve_zone(zone).multipliers))
        if optimum is None:
            raise AssertionError("zones are drawn at positions that satisfy the constraints")
        errors.append(exact.relative_error(back(found.displacements), optimum))
        claims = found.feasible and found.residuals.solved(1e-9, 1e-9)
        unsolved += not claims
        silent += claims and errors[-1] > TOLERANCE
    right = max(errors) <= TOLERANCE
    verdict = RIGHT if right else WRONG if silent else SAYS_SO
    seconds = (time.perf_counter() - begin) / count
    status = "solved" if not unsolved else f"{unsolved} of {count} not solved"
    note = f"{count} zones against the exact optimum of the zone as it was, in rational numbers"
    return [Outcome(verdict, status, error=max(errors), seconds=seconds, note=note)]


def _run(rung: Rung) -> list[Outcome]:
    return judge_zone_symmetry(str(rung), ZONES)


LADDERS: list[Ladder] = [
    Ladder(
        FAMILY,
        "zones",
        f"{ZONES} zones of 1 to 30 impacts and masses that differ by up to 1e6, written in another "
        "way. The displacements are compared with the exact optimum of the zone as it was.",
        "kind",
        tuple(SYMMETRIES),
        _run,
        (),
        120.0,
        tuple(SYMMETRIES)[-1],
    )
]
