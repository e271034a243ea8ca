"""Vectors of stage S12: whole steps, judged by the certificate of the path and by the objective.

The limits of the objective are 1.05 times the largest one that `izo_ref.resolve` finds with any of
the three selections, with or without new normals at the answer, rounded up to three digits. They
are written down here, because other versions of numpy may change the last digits of what it finds;
the tests compute them anew. The lower limit is 0.95 times the objective in closed form: an answer
below it ignores the thickness.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from izo_ref.porting.cases import ACCEPTABLE, DTYPES, VALID, Case
from izo_ref.porting.generate import s12_scenes as scenes
from izo_ref.porting.generate.scene_parts import SceneParts

TUNNEL, QUEUE, MOTION = ("tunnel-swap",), ("queue-overflow",), ("pinned-motion",)
STILL = (*MOTION, "still-nodes")
NEAR, SAFE, HONEST = ("starts-in-contact",), ("fail-safe",), ("unhonest-status",)
IN_LAYERS = ("cap-100", "mass-weighting")
FALLS = ("unhonest-status", "mass-weighting")


class Lot(NamedTuple):
    """A case before it has a number.

    Attributes:
        word: The word of its id.
        flags: As in `Case`.
        grade: As in `Case`.
        what: As in `Case`.
        scene: The step.
        limit: Largest objective that is accepted [m^2]; None if there is no such limit.
        free: Whether the path can be free; None if a port may say either.
        least: Smallest objective that is accepted [m^2]; None if there is no such limit.
    """

    word: str
    flags: tuple[str, ...]
    grade: str
    what: str
    scene: SceneParts
    limit: float | None
    free: int | None = 1
    least: float | None = None


def _through() -> list[Lot]:
    """Return steps that are free at the end, or nearly, but go through things on the way."""
    return [
        Lot("fall", FALLS, "easy", "The tip of a triangle falls through a face.",
            scenes.over_a_face(), 0.0753),
        Lot("fall", FALLS, "medium", "The tip of a heavy triangle falls through a light face: the "
            "face has to give way.", scenes.over_a_face(mass=1024.0), 5.83e-4),
        Lot("fall", ("pinned-masses", "unhonest-status"), "easy",
            "The tip of a triangle falls through a pinned face.",
            scenes.over_a_face(pinned=1), 0.202),
        Lot("fall", ("pinned-masses", "fail-safe"), "medium", "The thickness is an eighth of a "
            "metre. The tip of a triangle has to stop that far above a pinned face.",
            scenes.over_a_face(pinned=1, thickness=0.125), 0.268, least=0.242),
        Lot("tunnel", TUNNEL, "easy", "A small triangle flies through a large face. It is clear of "
            "the face at the start and at the end.", scenes.small_through_large(), 0.0597),
        Lot("tunnel", TUNNEL, "medium", "Two triangles pass through each other by their edges "
            "alone: no vertex meets a face.", scenes.crossing_blades(), 0.0448),
        Lot("tunnel", TUNNEL, "medium", "Two sheets change places, so the end alone shows nothing.",
            scenes.swapped_layers(), 0.0172),
        Lot("tunnel", TUNNEL, "hard", "A rippled sheet falls through another one, eight edges "
            "deep.", scenes.two_sheets(2.0, seed=121), 0.87),
        Lot("tunnel", TUNNEL, "hard", "A sheet falls through five others, far beyond the last.",
            scenes.through_layers(5, 4.0), 1.94),
    ]  # fmt: skip


def _pinned() -> list[Lot]:
    """Return steps with pinned vertices that move."""
    blocked = "Pinned plates change places with a sheet between them. A port may find no way."
    tight = (
        "Pinned plates end nearer to each other than the thickness, so the constraints of the "
        "sheet between them contradict each other. Positions without contact exist all the same."
    )
    return [
        Lot("motion", STILL, "easy", "A pinned face rises into the tip of a triangle at rest.",
            scenes.over_a_face(drop=0.0, pinned=1, rise=0.5), 0.0233),
        Lot("motion", STILL, "medium", "A pinned triangle pushes a sheet at rest upwards.",
            scenes.pushed_sheet(0.5), 0.023),
        Lot("motion", STILL, "hard", "A pinned triangle moves through a sheet at rest fast, and "
            "tilts meanwhile.", scenes.pushed_sheet(4.0, 0.125), 5.27),
        Lot("motion", (*MOTION, *SAFE), "medium", "Pinned plates leave a sheet little room, and "
            "the sheet is proposed to end far beyond one of them.",
            scenes.pinch(2.0**-4, 0.5), 0.239),
        Lot("motion", MOTION, "medium", "A pinned face rises by a move that rounds in float64. It "
            "ends where it is proposed to end, bit for bit, and not at start plus move.",
            scenes.decimal_rise(), 0.13),
        Lot("blocked", (*HONEST, *MOTION), "medium", blocked, scenes.pinch(-0.125), None, None),
        Lot("blocked", (*HONEST, *MOTION), "hard", "A triangle is in a closed pinned box whose tip "
            "goes down through its bottom, so no path is free, and a port must say so.",
            scenes.crushed_in_a_box(1.5), None, 0),
        Lot("tight", (*SAFE, "infeasible"), "hard", tight, scenes.pinch(2.0**-8, 0.25), None, None),
    ]  # fmt: skip


def _near() -> list[Lot]:
    """Return steps that start near contact, and steps that are free."""
    return [
        Lot("free", SAFE, "easy", "Two sheets slide past each other and meet nothing, so the "
            "proposed positions are the answer, bit for bit.", scenes.apart(), 0.0),
        Lot("free", SAFE, "medium", "A sheet ends nearer to another one than the thickness, but "
            "meets nothing, so it has no impacts.", scenes.resting(0.125, 0.125 - 2.0**-8), 0.0),
        Lot("near", (*NEAR, *SAFE), "easy", "A sheet starts a millionth of a metre above another "
            "one and moves away, so nothing meets.", scenes.resting(2.0**-20, -0.5), 0.0),
        Lot("near", NEAR, "medium", "A sheet starts a millionth of a metre above another one and "
            "is proposed to end below it.", scenes.resting(2.0**-20, 0.25), 0.0524),
        Lot("near", NEAR, "hard", "Of a sheet that starts a millionth of a metre above another "
            "one, some vertices move away and the others go through.",
            scenes.resting(2.0**-20, 0.125, 0.125), 0.0139),
    ]  # fmt: skip


def _many() -> list[Lot]:
    """Return steps with many impacts, or with zones that are hard to solve."""
    return [
        Lot("queue", QUEUE, "easy", "Two sheets meet at 120 pairs at once.",
            scenes.two_sheets(0.25), 0.0046),
        Lot("queue", QUEUE, "medium", "A cone of sixteen faces falls through a sheet: its edges "
            "meet the same few vertices and edges.", scenes.cone_through_sheet(16, 5, 0.5), 0.0171),
        Lot("queue", QUEUE, "hard", "A cone of 32 faces falls through a sheet: the first detection "
            "finds 120 pairs or more at its tip.", scenes.cone_through_sheet(32, 5, 1.0), 0.136),
        Lot("layers", IN_LAYERS, "easy", "A sheet falls through three others.",
            scenes.through_layers(3, 1.0), 0.122),
        Lot("layers", IN_LAYERS, "medium", "A sheet falls onto another one; it is a thousand times "
            "heavier.", scenes.two_sheets(0.5, seed=122, heavy=1024.0), 1.06e-4),
        Lot("layers", IN_LAYERS, "hard", "A sheet falls through five others and is a thousand "
            "times heavier, so all end in one pile.",
            scenes.through_layers(5, 1.0, heavy=1024.0), 2.3e-3),
    ]  # fmt: skip


def cases() -> list[Case]:
    """Return the cases of stage S12."""
    result, counts = [], dict[str, int]()
    for lot in [*_through(), *_pinned(), *_near(), *_many()]:
        number = counts[lot.word] = counts.get(lot.word, 0) + 1
        ends: dict[str, Any] = {"judge": "free-path"}
        if lot.limit is not None:
            ends["objective_at_most"] = lot.limit
        if lot.least is not None:
            ends["objective_at_least"] = lot.least
        expected: dict[str, Any] = {"positions": ends}
        if lot.free is not None:
            expected = {"free": {"judge": "equal", "values": [lot.free]}, **expected}
        verdict = ACCEPTABLE if lot.free is None else VALID
        name, inputs = f"S12-{lot.word}-{number:02}", lot.scene.inputs()
        result.append(
            Case(name, "S12", lot.flags, verdict, lot.grade, DTYPES, lot.what, inputs, expected)
        )
    return result
