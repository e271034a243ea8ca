"""Ladders of motion in which something comes close: grazing, contact at both ends, rest, touch."""

from collections.abc import Callable

import numpy as np

from validation.ladders.judge_step import Case, Known, judge_step
from validation.ladders.ladder import Ladder, Outcome, Rung
from validation.ladders.stacked import FREE, judge_gadget, moved_centre
from validation.ladders.touching_kinds import KINDS, REFUSED, judge_kind
from validation.scenes.gadgets import THICKNESS_M, vertex_on_face
from validation.scenes.shapes import CORNERS

FAMILY = "motion"
PROPOSED = "so the proposed positions are the answer, bit for bit"
GAPS = (1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-15, 1e-16, 1e-17, 1e-20, 1e-50, 1e-100, 1e-200)
GAPS = (*GAPS, 1e-300, 5e-324, 0)
BELOW = (-5e-324, -1e-300, -1e-16, -1e-9, -1e-3, -1, -1e3, -1e6, -1e9, -1e12, -1e20, -1e29, -1e31)


def _graze(rung: Rung) -> list[Outcome]:
    """Move a vertex over a face, parallel to it; at 0 it moves within the plane of the face."""
    height = float(rung)
    start = np.concatenate((CORNERS, [[-8.0, 0.25, height]]))
    end = np.concatenate((CORNERS, [[8.0, 0.125, height]]))
    known = Known(positions=end, tolerance=0.0) if height > 0.0 else Known(check=moved_centre)
    return judge_step(Case(start, end, np.array([[0, 1, 2]], np.int32), THICKNESS_M), known)


def _end_gap(rung: Rung) -> list[Outcome]:
    gap = float(rung)
    return judge_gadget(
        vertex_on_face(CORNERS, 1.0, gap), tolerance=0.0 if gap > 0.0 else 1e-9, by_objective=True
    )


def _start_gap(rung: Rung, end: Callable[[float], float]) -> list[Outcome]:
    """Start a vertex at a gap above a face; at 0 it touches and is refused."""
    gap = float(rung)
    scene = vertex_on_face(CORNERS, gap, end(gap))
    return judge_gadget(scene, FREE if gap > 0.0 else REFUSED, by_objective=True)


def _down(gap: float) -> float:
    return -0.5 + 0.0 * gap


def _stay(gap: float) -> float:
    return gap


def _start_down(rung: Rung) -> list[Outcome]:
    return _start_gap(rung, _down)


def _at_rest(rung: Rung) -> list[Outcome]:
    return _start_gap(rung, _stay)


CLOSE = [
    Ladder(
        FAMILY,
        "grazing",
        "A vertex passes over a face, parallel to it. It never meets the face if it is above its "
        f"plane, by however little, {PROPOSED}; at 0 it goes through the face in its plane.",
        "height over the face / its size",
        GAPS,
        _graze,
        (1e-3, 1e-16, 0),
    ),
    Ladder(
        FAMILY,
        "contact at the end",
        "A vertex is proposed to end close to a face. Above it, the path is free, "
        f"{PROPOSED}; on it, it touches at t = 1 exactly, and below it goes through. The objective "
        "of the answer is known in closed form. A path 2^100 times longer than the mesh is refused "
        "by an error.",
        "height at the end / size of the face",
        (*GAPS, *BELOW),
        _end_gap,
        (1e-3, 1e-16, 0, -1e-16),
    ),
    Ladder(
        FAMILY,
        "contact at the start",
        "A vertex starts close above a face and moves through it, so that the time of contact "
        "comes as close to 0 as floats can tell. The answer is known in closed form. At 0 it "
        "touches and is refused by an error that names the pair.",
        "height at the start / size of the face",
        GAPS,
        _start_down,
        (1e-3, 1e-16, 0),
    ),
    Ladder(
        FAMILY,
        "at rest",
        "A vertex rests above a face, closer than the thickness, and nothing moves: the answer is "
        "where everything is.",
        "height / size of the face",
        GAPS,
        _at_rest,
        (1e-3, 1e-16, 0),
    ),
    Ladder(
        FAMILY,
        "starts that touch",
        "Pairs that touch exactly at the start are refused, or, if asked for, kept on the side "
        "that the mesh tells, with an answer that is known in closed form. Where the mesh tells no "
        "side, the pairs are left out, and the status says so.",
        "kind",
        tuple(KINDS),
        judge_kind,
        tuple(KINDS),
    ),
]
