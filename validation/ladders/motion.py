"""Family of motion: tunnelling, speed, order, turns, folds, grazing, touching, and rest."""

import numpy as np

from izo_ref.loop.resolve import resolve
from izo_ref.scene import Scene
from validation.ladders.judge_step import Case, Known, judge_step
from validation.ladders.ladder import Ladder, Outcome, Rung
from validation.ladders.motion_close import CLOSE, PROPOSED
from validation.ladders.stacked import judge_layers, moved_centre
from validation.scenes import sweeping
from validation.scenes.gadgets import THICKNESS_M
from validation.scenes.layers import CELL_M, GAP_M, layers

FAMILY = "motion"
SEED = 21
ORDER = (
    "The centre of mass stays, and the path is certified, so no layer goes through another one. "
    "The best end of flat layers in order is known in closed form. The objective may be at most a "
    "hundredth higher, and it is lower where layers slip past each other's rims."
)


def _tunnel(rung: Rung) -> list[Outcome]:
    k = int(rung)
    heights = GAP_M * np.arange(k + 1.0)
    heights[-1] -= 2 * k * GAP_M
    return judge_layers(layers(heights))


def _reverse(rung: Rung) -> list[Outcome]:
    return judge_layers(layers(GAP_M * np.arange(int(rung), 0.0, -1.0)))


def _speed(rung: Rung) -> list[Outcome]:
    return judge_layers(layers(np.array([0.0, GAP_M - float(rung) * CELL_M])))


def _motion(scene: sweeping.Motion, proposal_is_free: bool) -> list[Outcome]:
    """Resolve a motion; the proposed positions are the answer, or known to be none."""
    known = Known(positions=scene.end, tolerance=0.0)
    if not proposal_is_free:
        known = Known(check=moved_centre)
    return judge_step(Case(*scene, THICKNESS_M), known)


def _turn(rung: Rung) -> list[Outcome]:
    return _motion(sweeping.turned_block(float(rung)), float(rung) < 180.0)


def _inside_out(rung: Rung) -> list[Outcome]:
    return _motion(sweeping.scaled_ball(float(rung)), float(rung) > 0.0)


def _fold(rung: Rung) -> list[Outcome]:
    return _motion(sweeping.folded_sheet(5, float(rung)), float(rung) < 0.5)


def _fold_size(rung: Rung) -> list[Outcome]:
    return _motion(sweeping.folded_sheet(int(rung), 1.0), proposal_is_free=False)


def _coplanar(rung: Rung) -> list[Outcome]:
    return _motion(sweeping.coplanar_grids(4, float(rung)), float(rung) < 0.25)


def _scaled(rung: Rung) -> list[Outcome]:
    scene = sweeping.rippled_sheets(np.random.default_rng(SEED))
    expected = resolve(Scene(*scene), THICKNESS_M).positions
    scale = float(rung)
    case = Case(scale * scene.start, scale * scene.end, scene.faces, scale * THICKNESS_M)
    return judge_step(case, Known(positions=scale * expected))


LADDERS = [
    Ladder(
        FAMILY,
        "tunnelling",
        "A layer falls through many others, and as far again. " + ORDER,
        "layers that it falls through",
        (1, 2, 3, 5, 7, 10, 12, 14, 16, 20, 30, 50, 70, 100, 150, 200, 300, 500),
        _tunnel,
        (1, 2, 20),
        300.0,
        100,
    ),
    Ladder(
        FAMILY,
        "speed",
        "A layer falls through one other in one step. "
        + ORDER
        + " A thickness below 2^-300 of the "
        "largest coordinate is refused.",
        "edge lengths in one step",
        (
            1,
            3,
            10,
            30,
            100,
            300,
            1e3,
            1e4,
            1e5,
            1e6,
            1e7,
            1e8,
            1e9,
            1e12,
            1e15,
            1e20,
            1e30,
            1e60,
            1e90,
        ),
        _speed,
        (1, 100, 1e6),
        120.0,
        100,
    ),
    Ladder(
        FAMILY,
        "swapped layers",
        "Layers are proposed to end in reverse order; two of them change places. " + ORDER,
        "layers",
        (2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 25, 30, 40, 50, 70, 100),
        _reverse,
        (2, 3, 4),
        300.0,
    ),
    Ladder(
        FAMILY,
        "turn in one step",
        "A body of two sheets turns by an angle in one straight step. Below 180 degrees no map on "
        f"the way is singular, {PROPOSED}; at 180 degrees everything meets on the axis.",
        "angle [degrees]",
        (1, 30, 60, 90, 120, 150, 170, 179, 179.9, 179.99, 179.9999, 180 - 1e-6, 180 - 1e-9, 180),
        _turn,
        (90, 179),
        120.0,
    ),
    Ladder(
        FAMILY,
        "turned inside out",
        "A closed ball is scaled about its middle in one step. Above 0 no map on the way is "
        f"singular, {PROPOSED}; at 0 and below all of its vertices meet, and the end has to be "
        "certified free. The time is that of exact arithmetic with long numbers.",
        "factor",
        (0.5, 0.1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-100, 1e-300, 0, -1e-3, -0.1, -1, -10, -1e3),
        _inside_out,
        (0.5, 1e-3),
        120.0,
    ),
    Ladder(
        FAMILY,
        "fold in the plane (fails in ARCSim)",
        "Half of a flat sheet moves over the other half without leaving the plane. Below 1/2 no "
        f"two places meet, {PROPOSED}; above, the end has to be certified free, and the centre of "
        "mass stays. ARCSim 0.3.x leaves out pairs that start in one plane and reports success.",
        "part of the way to the mirrored place",
        (0.1, 0.25, 0.4, 0.49, 0.499999, 0.5 - 1e-12, 0.5, 0.500001, 0.51, 0.6, 0.8, 1, 2, 5, 100),
        _fold,
        (0.25, 0.6),
        120.0,
    ),
    Ladder(
        FAMILY,
        "fold in the plane, finer sheets",
        "Half of a flat sheet is mirrored onto the other half in its plane, for sheets of more and "
        "more vertices. The end has to be certified free, and the centre of mass stays.",
        "vertices along a side",
        (3, 5, 7, 9, 11, 13, 17, 21, 25, 33, 49, 65),
        _fold_size,
        (3,),
        300.0,
    ),
    Ladder(
        FAMILY,
        "coplanar grids (fail in ARCSim)",
        "Two grids that start in one plane, half an edge apart, are pushed into each other in that "
        f"plane. Below 1/4 they stay apart, {PROPOSED}; above, the end has to be certified free, "
        "and the centre of mass stays. ARCSim 0.3.x leaves out pairs that start in one plane, and "
        "reports success with contacts left.",
        "edge lengths that each grid moves",
        (
            0.1,
            0.2,
            0.249999,
            0.25 - 1e-12,
            0.25,
            0.250001,
            0.3,
            0.5,
            1,
            2,
            3,
            10,
            30,
            100,
            1e3,
            1e6,
        ),
        _coplanar,
        (0.1, 0.3),
        120.0,
    ),
    Ladder(
        FAMILY,
        "scene scaled (fails in ARCSim)",
        "Two rippled sheets go through each other, in a scene that is scaled. The answer is that "
        "of the scene of size 1, scaled. ARCSim 0.2.1 has absolute tolerances: scaled by 100, it "
        "reports success with intersections. Beyond 2^-1000 and 2^1000 m, an error names the sizes "
        "that are accepted.",
        "scale",
        (
            1e-305,
            1e-300,
            1e-100,
            1e-30,
            1e-9,
            1e-3,
            0.01,
            1,
            100,
            1e3,
            1e9,
            1e30,
            1e100,
            1e300,
            1e305,
        ),
        _scaled,
        (0.01, 100),
    ),
    *CLOSE,
]
