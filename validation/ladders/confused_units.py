"""Units that are confused on purpose: a ladder whose rungs are the names of the mistakes."""

from collections.abc import Callable

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.scene import Scene
from validation.ladders.judge_step import Case, Known, judge_step
from validation.ladders.ladder import Ladder, Outcome, Rung
from validation.scenes.analytic import (
    THICKNESS_M,
    AnalyticStep,
    free_vertex_on_face,
    scaled,
    sheet_on_table,
    turned,
    vertex_on_face,
)
from validation.scenes.sheets import meeting_sheets

FAMILY = "scale and place"
CERTIFIED = ("FREE", "FREE_BY_FALLBACK")
ONCE = {"relinearize": 0}


def _analytic(step: AnalyticStep, note: str) -> list[Outcome]:
    case = Case(
        step.start, step.end, step.faces, step.thickness, step.masses, step.pinned, options=ONCE
    )
    return judge_step(case, Known(positions=step.right, note=note))


def _cloth() -> Scene:
    """Return two wrinkled sheets that go through each other; positions in metres."""
    return meeting_sheets(np.random.default_rng(0), 150)


def _ends(
    start: Positions, end: Positions, scene: Scene, known: Known, thickness: float = THICKNESS_M
) -> list[Outcome]:
    case = Case(start, end, scene.faces, thickness, scene.masses, scene.pinned)
    return judge_step(case, known)


def _thickness_in_metres() -> list[Outcome]:
    step = scaled(sheet_on_table(), 1000.0)._replace(thickness=THICKNESS_M)
    step.right[3:, 2] = THICKNESS_M
    return _analytic(step, "The sheet lies so near the table, whatever the unit is.")


def _thickness_in_millimetres() -> list[Outcome]:
    step = sheet_on_table(1.0)
    return _analytic(step, "The sheet ends 1 m above the table.")


def _masses_in_grams() -> list[Outcome]:
    step = free_vertex_on_face((1000.0, 1000.0, 1000.0, 1.0))
    return _analytic(step, "The face counts as a thousand times as heavy.")


def _grows() -> list[Outcome]:
    start = _cloth().positions_t0
    known = Known(
        positions=1000.0 * start,
        tolerance=0.0,
        note="Everything grows around the origin. Nothing meets, so the end is the proposed one.",
    )
    return _ends(start, 1000.0 * start, _cloth(), known)


def _shrinks() -> list[Outcome]:
    start = _cloth().positions_t0
    known = Known(
        positions=start,
        tolerance=0.0,
        note="Everything shrinks around the origin. Nothing meets, so the end is the proposed one.",
    )
    return _ends(1000.0 * start, start, _cloth(), known)


def _moves_a_thousand_times() -> list[Outcome]:
    scene = _cloth()
    end = scene.positions_t0 + 1000.0 * (scene.positions_t1 - scene.positions_t0)
    known = Known(CERTIFIED, note="Velocities per millisecond: a certified path has to be free.")
    return _ends(scene.positions_t0, end, scene, known)


def _other_vertical() -> list[Outcome]:
    return _analytic(
        turned(sheet_on_table(), (1, 2, 0)), "Another axis is the vertical one, which is harmless."
    )


def _vertical_of_the_end() -> list[Outcome]:
    start = _cloth().positions_t0
    end = start[:, [0, 2, 1]] * (1.0, -1.0, 1.0)  # turned by 90 degrees about x
    known = Known(
        positions=end,
        tolerance=0.0,
        note="The path is a linear map of the start at each time, and never singular. So nothing "
        "meets, and the end is the proposed one.",
    )
    return _ends(start, end, _cloth(), known)


def _mirrored_end() -> list[Outcome]:
    start = _cloth().positions_t0
    known = Known(
        CERTIFIED,
        note="The end is the mirror image of the start, so everything goes through one plane at "
        "half time. A certified path has to be free.",
    )
    return _ends(start, start * (1.0, 1.0, -1.0), _cloth(), known)


def _faces_from_one() -> list[Outcome]:
    step = vertex_on_face()
    case = Case(step.start, step.end, step.faces + 1, step.thickness)
    return judge_step(case, Known(("IndexRangeError",), note="The last face names no vertex."))


def _thickness_of_zero() -> list[Outcome]:
    case_of_zero = vertex_on_face(0.0)
    case = Case(case_of_zero.start, case_of_zero.end, case_of_zero.faces, 0.0)
    return judge_step(case, Known(("ThicknessError",), note="Rounded to whole metres, it is 0."))


KINDS: dict[str, Callable[[], list[Outcome]]] = {
    "positions in mm, thickness in m": _thickness_in_metres,
    "positions in m, thickness in mm": _thickness_in_millimetres,
    "masses of one body in g, of the other in kg": _masses_in_grams,
    "start in m, end in mm": _grows,
    "start in mm, end in m": _shrinks,
    "moves a thousand times too long": _moves_a_thousand_times,
    "another axis is vertical": _other_vertical,
    "another axis is vertical at the end": _vertical_of_the_end,
    "the end is mirrored": _mirrored_end,
    "faces count from 1": _faces_from_one,
    "thickness rounded to 0": _thickness_of_zero,
}


def _run(rung: Rung) -> list[Outcome]:
    return KINDS[str(rung)]()


UNITS: list[Ladder] = [
    Ladder(
        FAMILY,
        "confused units",
        "Units and axes are confused on purpose. The right end follows by hand, or a certified "
        "path has to be free, or the error is known.",
        "kind",
        tuple(KINDS),
        _run,
        quick=("positions in mm, thickness in m", "another axis is vertical", "faces count from 1"),
        seconds=120.0,
    ),
]
