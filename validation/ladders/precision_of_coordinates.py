"""Coordinates that come rounded, as files have them: starts that touch or cross then, and status.

Whether the rounded mesh touches or crosses itself is decided by exact arithmetic over all pairs
(`validation/oracles/pairs.py`), without our code. The door has to agree: it refuses exactly these
starts. With `initial_intersections="ratchet"`, every step goes on, and its status says what was
left out.
"""

import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.base.errors import InitialIntersectionError
from izo_ref.loop.resolve import resolve
from izo_ref.scene import Scene
from validation.ladders.ladder import RIGHT, WRONG, Ladder, Outcome, Rung
from validation.oracles.pairs import meeting_pairs
from validation.scenes.crossing import Step, crossing_sheets

FAMILY = "precision"
SEED = 20240611
STEPS = 20
GAP = 0.08 / 3.0  # about, of the sheets at the start [m], while an edge has 1/3 m
# Spacing of the grid to which coordinates are rounded, over the gap.
SPACINGS = (1e-9, 1e-6, 1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)


def _decimals(count: int) -> Callable[[Positions], Any]:
    return lambda positions: np.round(positions, count)


FORMATS: dict[str, Callable[[Positions], Any]] = {
    "float64": lambda positions: positions,
    "9 decimals": _decimals(9),
    "float32": lambda positions: positions.astype(np.float32),
    "6 decimals": _decimals(6),
    "float32, 1 km away": lambda positions: (positions + 1e3).astype(np.float32),
    "4 decimals": _decimals(4),
    "float16": lambda positions: positions.astype(np.float16),
    "3 decimals": _decimals(3),
    "float32, 100 km away": lambda positions: (positions + 1e5).astype(np.float32),
    "2 decimals": _decimals(2),
    "float16, 30 m away": lambda positions: (positions + 30.0).astype(np.float16),
    "float32, 1000 km away": lambda positions: (positions + 1e6).astype(np.float32),
    "1 decimal": _decimals(1),
    "whole numbers": _decimals(0),
}


def judge_rounded(make: Callable[[Positions], Any], count: int) -> list[Outcome]:
    """Resolve steps whose coordinates were rounded.

    Args:
        make: Takes coordinates [m] and returns rounded ones, of any type of floats.
        count: Number of steps.

    Returns:
        One outcome. It is right if the door refuses exactly the starts that exact arithmetic
        refuses, and if no status is false.
    """
    begin, statuses, wrong = time.perf_counter(), Counter[str](), []
    for number in range(count):
        step = crossing_sheets(np.random.default_rng([SEED, number]), 4.0 ** -(1 + number % 3))
        start, end = make(step.start), make(step.end)
        exact = step._replace(start=np.asarray(start, np.float64), end=np.asarray(end, np.float64))
        touches = _meets(exact, exact.start)
        for mode in ("raise", "ratchet"):
            status, problem = _resolved(step, exact, start, end, mode, touches)
            statuses[f"{mode}: {status}"] += 1
            if problem:
                wrong.append(f"step {number}, {mode}: {problem}")
    verdict = WRONG if wrong else RIGHT
    said = ", ".join(f"{status} {n}" for status, n in sorted(statuses.items()))
    seconds = (time.perf_counter() - begin) / count
    note = wrong[0] if wrong else "exact arithmetic agrees about every start and every free path"
    return [Outcome(verdict, said, seconds=seconds, note=note)]


def _resolved(
    step: Step, exact: Step, start: Any, end: Any, mode: str, touches: bool
) -> tuple[str, str]:
    """Resolve a rounded step; return its status, and what is wrong, in words."""
    try:
        scene = Scene(start, end, step.faces, step.masses, step.pinned, initial_intersections=mode)
    except InitialIntersectionError:
        expected = touches and mode == "raise"
        return "refused", "" if expected else "the start is free, and it is refused"
    if touches and mode == "raise":
        return "accepted", "the start touches or crosses, and it is accepted"
    result = resolve(scene, step.thickness)
    status = result.status.name
    if not np.isfinite(result.positions).all():
        return status, "a position is not finite"
    free = status in ("FREE", "FREE_BY_FALLBACK")
    if free and not touches and _meets(exact, result.positions):
        return status, "the path is called free, and a pair meets"
    if not free and not touches and status != "BLOCKED":
        return status, "pairs are left out, and the start is free"
    return status, ""


def _meets(step: Step, positions: Positions) -> bool:
    found = meeting_pairs(step.start, positions, step.faces)
    return len(found.vertex_face) + len(found.edge_edge) > 0


def _format(rung: Rung) -> list[Outcome]:
    return judge_rounded(FORMATS[str(rung)], STEPS)


def _spacing(rung: Rung) -> list[Outcome]:
    unit = float(rung) * GAP
    return judge_rounded(lambda positions: np.rint(positions / unit) * unit, STEPS)


LADDERS: list[Ladder] = [
    Ladder(
        FAMILY,
        "rounded coordinates",
        "Sheets that nearly touch, with coordinates as file formats round them. The door refuses "
        "exactly the starts that touch or cross then, and no status is false; exact arithmetic "
        "over all pairs decides.",
        "kind",
        tuple(FORMATS),
        _format,
        (),
        600.0,
        tuple(FORMATS)[-1],
    ),
    Ladder(
        FAMILY,
        "grid of coordinates",
        "Sheets whose coordinates are rounded to an ever coarser grid. The door refuses exactly "
        "the starts that touch or cross then, and no status is false; exact arithmetic over all "
        "pairs decides.",
        "spacing / gap",
        SPACINGS,
        _spacing,
        (),
        600.0,
        SPACINGS[-1],
    ),
]
