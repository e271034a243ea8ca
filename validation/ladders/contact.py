"""Family of contact: stacks, pinches, cages, knots, and zones of all sizes."""

from functools import partial

import numpy as np

from izo_ref.loop.resolve import Result
from izo_ref.zones.problem import ZoneProblem
from validation.ladders.judge_step import Case, Known, judge_step
from validation.ladders.judge_zone import judge_zone
from validation.ladders.ladder import Ladder, Outcome, Rung
from validation.ladders.stacked import (
    ABOVE_BEST,
    CERTIFIED,
    FREE,
    judge_gadget,
    judge_layers,
    moved_centre,
)
from validation.scenes.balls import pressed_balls
from validation.scenes.gadgets import cage, tiles
from validation.scenes.knots import pulled_knot
from validation.scenes.layers import GAP_M, THICKNESS_M, layers

FAMILY = "contact"
SEED = 21
BLOCKED = ("BLOCKED",)
KNOT_THICKNESS_M = 1e-3


def _stack(rung: Rung) -> list[Outcome]:
    return judge_layers(layers(np.full(int(rung), -GAP_M), low=0.0))


def _room(share: float) -> tuple[str, ...]:
    """Return the right statuses where this share of the room that the thickness needs is left."""
    return FREE if share >= 1.0 else CERTIFIED if share > 0.0 else BLOCKED


def _pinch(rung: Rung, proposed: tuple[float, ...]) -> list[Outcome]:
    share = float(rung)
    room = (len(proposed) + 1) * THICKNESS_M * share
    scene = layers(GAP_M * np.array(proposed), low=0.0, high=room)
    # below 1 the thickness does not fit on both sides of every layer, so no answer is the best one
    return judge_layers(scene if share >= 1.0 else scene._replace(best=None), _room(share))


def _pinched_zone(rung: Rung) -> list[Outcome]:
    """State the zone of five points above one another between two pinned ones."""
    n, share = 5, float(rung)
    # node k is point k of the column; each has a twin that its weight of zero belongs to
    nodes = np.array([[k + 1, n + 2, k, n + 2] for k in range(n + 1)])
    weights = np.tile([1.0, 0.0, -1.0, 0.0], (n + 1, 1))
    normals = np.tile([0.0, 0.0, 1.0], (n + 1, 1))
    rng = np.random.default_rng(SEED)
    proposed = np.zeros((n + 3, 3))
    proposed[1 : n + 1, 2] = THICKNESS_M * np.round(64.0 * rng.uniform(-9, 9, n)) / 64.0
    proposed[n + 1, 2] = (n + 1) * THICKNESS_M * share
    masses = np.ones(n + 3)
    masses[[0, n + 1, n + 2]] = np.inf
    return judge_zone(ZoneProblem(nodes, weights, normals, proposed, masses, THICKNESS_M))


def _cage(rung: Rung) -> list[Outcome]:
    share = float(rung)
    scene = cage(share * THICKNESS_M, (3.0, 2.0, 1.0))
    if share > 0.5:
        return judge_gadget(scene)
    case = Case(scene.start, scene.end, scene.faces, THICKNESS_M, None, scene.pinned)
    return judge_step(case, Known(_room(share)))


def _one_zone(rung: Rung) -> list[Outcome]:
    side = round(float(rung) ** 0.5)
    scene = layers(np.array([GAP_M, 0.0]), side)
    case = Case(scene.start, scene.end, scene.faces, THICKNESS_M)
    moves = scene.best - scene.end if scene.best is not None else np.zeros(1)
    known = Known(FREE, None, float((moves**2).sum(axis=1).mean()), ABOVE_BEST, check=_is_one_zone)
    return judge_step(case, known)


def _is_one_zone(result: Result) -> str:
    """Return a sentence if the impacts are not of one zone, or too few to hold each vertex."""
    n, m = len(result.zones), len(result.impacts.toi)
    if n != 1 or m < len(result.positions) // 2:
        return (
            f"{m} impacts in {n} zones hold two sheets apart, not one zone of at least as many "
            "as a sheet has vertices."
        )
    return moved_centre(result)


def _zones_of_one(rung: Rung) -> list[Outcome]:
    return judge_gadget(tiles(int(rung)))


def _balls(rung: Rung) -> list[Outcome]:
    scene = pressed_balls(np.random.default_rng(SEED), int(rung))
    case = Case(scene.positions_t0, scene.positions_t1, scene.faces, None, scene.masses)
    return judge_step(case, Known())


def _knot(rung: Rung, n_rings: int | None = None) -> list[Outcome]:
    rings, pull = (n_rings, float(rung)) if n_rings else (int(rung), 1.0)
    return judge_step(Case(*pulled_knot(rings, pull), KNOT_THICKNESS_M), Known(check=moved_centre))


PINCH = (4, 2, 1.1, 1.01, 1.0001, 1 + 1e-6, 1 + 1e-9, 1, 1 - 1e-6, 0.99, 0.9, 0.75, 0.51, 0.5)
PINCH = (*PINCH, 0.25, 0.1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-100, 0, -1)
ROOM = "room over what the thickness needs"
PINCHED = (
    "Pinned sheets close on {}. At 1 and above the thickness fits, and the heights in order that "
    "are closest to the proposed ones are known in closed form; the objective may be at most a "
    "hundredth higher. Between 0 and 1 only less than the thickness fits, so the answer has to be "
    "certified free; at 0 and below nothing fits."
)
LADDERS = [
    Ladder(
        FAMILY,
        "stack",
        "Layers are pressed through one another onto a pinned floor. The best end of flat layers "
        "is known in closed form; the objective may be at most a hundredth higher.",
        "layers",
        (1, 2, 3, 5, 7, 10, 14, 20, 30, 50, 70, 100, 200),
        _stack,
        (1, 3),
        300.0,
    ),
    Ladder(
        FAMILY,
        "pinched layer",
        PINCHED.format("one layer"),
        ROOM,
        PINCH,
        partial(_pinch, proposed=(16.0,)),
        (2, 1.01, 1, 0.9),
    ),
    Ladder(
        FAMILY,
        "pinched layers",
        PINCHED.format("three layers that change places"),
        ROOM,
        PINCH,
        partial(_pinch, proposed=(3.0, 0.0, 1.0)),
        (2, 1.01, 1, 0.9),
        120.0,
    ),
    Ladder(
        FAMILY,
        "pinched zone",
        "Five points above one another are pinched between two pinned ones, as a zone problem. It "
        "is feasible exactly if the room is at least what the thickness needs; rational arithmetic "
        "says so, and computes the optimum. A room that is smaller by less than 1e-9 is within the "
        "tolerance of a violation and not a rung.",
        ROOM,
        (4, 2, 1.1, 1.01, 1 + 1e-6, 1 + 1e-9, 1 + 1e-11, 1, 1 - 1e-7, 1 - 1e-6, 0.99, 0.9, 0, -1),
        _pinched_zone,
        (2, 1, 0.9),
    ),
    Ladder(
        FAMILY,
        "cage",
        "A pinned cube closes around a vertex that wants to go far out through a corner. Down to "
        "half of the thickness, the vertex ends in the corner that the thickness leaves, which is "
        "known exactly. Between 0 and that the answer has to be certified free; at 0 and below "
        "nothing fits.",
        "half of the side / thickness",
        (
            1e3,
            100,
            10,
            2,
            1.1,
            1.01,
            1 + 1e-6,
            1 + 1e-9,
            1,
            0.9,
            0.51,
            0.5,
            0.25,
            1e-3,
            1e-9,
            0,
            -1,
        ),
        _cage,
        (10, 1.01, 1, 0.9),
    ),
    Ladder(
        FAMILY,
        "one zone",
        "Two sheets change places, so that all their impacts are one zone with at least as many "
        "impacts as a sheet has vertices. The best end of flat sheets is known in closed form; the "
        "objective may be at most a hundredth higher, and the centre of mass stays.",
        "vertices of a sheet",
        (9, 36, 100, 400, 900, 2500, 4900, 10000, 22500, 40000, 62500, 102400),
        _one_zone,
        (9,),
        300.0,
    ),
    Ladder(
        FAMILY,
        "zones of one",
        "Vertices fall on faces, far from one another: each impact is a zone. The answer is known "
        "in closed form.",
        "zones",
        (1, 10, 100, 1000, 3000, 10000, 30000, 100000, 300000, 1000000),
        _zones_of_one,
        (1, 10),
        300.0,
    ),
    Ladder(
        FAMILY,
        "pressed balls",
        "Balls of 320 triangles are pressed together until neighbours would overlap by two fifths "
        "of their size. The end has to be certified free, and independent oracles check it.",
        "balls",
        (1, 2, 4, 8, 16, 27, 64, 125, 216, 343, 512, 1000),
        _balls,
        (2,),
        300.0,
    ),
    Ladder(
        FAMILY,
        "knot pulled tight",
        "An overhand knot in a tube of 40 rings is pulled straight. A free path keeps the knot, so "
        "the proposed straight tube is no answer. The end has to be certified free, and the centre "
        "of mass stays.",
        "part of the way to the straight tube",
        (0.1, 0.2, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.8, 1, 1.5, 3, 10),
        partial(_knot, n_rings=40),
        (0.1,),
        120.0,
    ),
    Ladder(
        FAMILY,
        "knot, finer tubes",
        "An overhand knot is pulled until the tube would be straight, in tubes of more and more "
        "rings. What is known is as for the other knot.",
        "rings",
        (15, 20, 25, 30, 40, 50, 60, 80, 100, 150, 200),
        _knot,
        (),
        300.0,
    ),
]
