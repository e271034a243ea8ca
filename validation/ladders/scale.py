"""Scale and place: sizes, distances from the origin, thicknesses, and confused units."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.base.errors import IzoError
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene
from validation.ladders.confused_units import UNITS
from validation.ladders.judge_step import Case, Known, judge_step
from validation.ladders.ladder import Ladder, Outcome, Rung, worst
from validation.oracles.pairs import meeting_pairs
from validation.scenes.analytic import (
    THICKNESS_M,
    AnalyticStep,
    edge_on_edge,
    free_vertex_on_face,
    moved,
    scaled,
    sheet_on_table,
    vertex_on_face,
)
from validation.scenes.sheets import meeting_sheets

FAMILY = "scale and place"
# Without rounds that take the normals again, so that the right end is that of the first normals.
ONCE = {"relinearize": 0}
EXACT_GRID = 2.0**42  # numbers with 10 binary places are floats up to here
AWAY = 1e-2  # relative error of an objective: the order in which impacts are found may differ
HAND = "The right end follows by hand."
NOTHING_KNOWN = (
    "The numbers of the scene are rounded there, so its right end is not known; a path that is "
    "certified has to be free, and a start that touches has to be refused."
)
SHAPES: dict[str, tuple[str, Callable[..., AnalyticStep]]] = {
    "vertex": ("A vertex falls through a pinned face", vertex_on_face),
    "edge": ("An edge falls through a pinned edge", edge_on_edge),
    "sheet": ("A flat sheet falls through a pinned table", sheet_on_table),
}
LARGER = tuple(
    10.0**k for k in (0, 1, 3, 6, 9, 12, 20, 30, 31, 100, 200, 290, 299, 300, 301, 305, 307)
)
SMALLER = (
    *(10.0**-k for k in (0, 1, 3, 6, 9, 12, 20, 30, 31, 100, 200, 290, 298, 301, 302, 305, 310)),
    5e-324,
)
POWERS = (0, 1, 30, 99, 101, 300, 600, 900, 990, 996, 997, 1000, 1010, 1015, 1020)
PLACES = (*(10 * k for k in range(5)), 42, 43, 44, 45, 46, 48, 50, 52, 53, 54, 57, 60)
DIRECTIONS = {
    "along the plane": (1.0, 0.0, 0.0),
    "along the normal": (0.0, 0.0, 1.0),
    "obliquely": (1.0, -1.0, 1.0),
}
THIN = tuple(
    10.0**-k for k in (3, 6, 9, 12, 15, 16, 17, 20, 30, 50, 80, 90, 91, 100, 200, 300, 320)
)
THICK = tuple(10.0**k for k in (-2, -1, 0, 1, 2, 4, 8, 16, 30, 50, 59, 60, 61, 70, 100, 200, 300))
TABLES = tuple(10.0**k for k in (0, 1, 2, 3, 4, 6, 8, 9, 10, 12, 14, 15, 16, 17, 18, 20))


def case_of(step: AnalyticStep) -> Case:
    """Return a step as a case of the judge."""
    return Case(
        step.start, step.end, step.faces, step.thickness, step.masses, step.pinned, options=ONCE
    )


def judge_analytic(step: AnalyticStep, statuses: tuple[str, ...] = ("FREE",)) -> list[Outcome]:
    """Judge a step whose right end is known."""
    return judge_step(case_of(step), Known(statuses, step.right, note=HAND))


def rounded(step: AnalyticStep) -> Known:
    """Return what is known of a step whose numbers were rounded: what its start may be."""
    touching = meeting_pairs(step.start, step.start, step.faces)
    if len(touching.vertex_face) or len(touching.edge_edge):
        return Known(("InitialIntersectionError",), note=NOTHING_KNOWN)
    return Known(("FREE", "InitialIntersectionError"), note=NOTHING_KNOWN)


def _sizes() -> list[Ladder]:
    """Return ladders of sizes, with factors that are no powers of two, and with such that are."""
    ladders = []
    for name, (words, make) in SHAPES.items():

        def run(rung: Rung, make: Callable[..., AnalyticStep] = make) -> list[Outcome]:
            # 1.1 is no power of two, and a step that is rounded otherwise has the same answer
            return judge_analytic(scaled(make(), 1.1 * float(rung)))

        told = f"{words}; all lengths are multiplied by 1.1 times this. {HAND}"
        ladders += [
            Ladder(
                FAMILY, f"larger, {name}", told, "factor", LARGER, run, (1e9,), wanted=1e299
            ),
            Ladder(
                FAMILY, f"smaller, {name}", told, "factor", SMALLER, run, (1e-9,), wanted=1e-298
            ),
        ]  # fmt: skip
    told = (
        "Two wrinkled sheets of 150 triangles go through each other; all lengths are multiplied by "
        "this power of two. The right end is that of the sheets as they are, multiplied, bit for "
        "bit."
    )
    powers, less = tuple(map(float, POWERS)), tuple(-float(p) for p in POWERS)
    return [
        *ladders,
        Ladder(
            FAMILY, "larger, bits", told, "exponent", powers, _same_bits, (101.0,), wanted=996.0
        ),
        Ladder(
            FAMILY, "smaller, bits", told, "exponent", less, _same_bits, (-101.0,), wanted=-990.0
        ),
    ]  # fmt: skip


def _same_bits(rung: Rung) -> list[Outcome]:
    scene = meeting_sheets(np.random.default_rng(0), 150)
    exponent, thickness = int(rung), THICKNESS_M
    right = resolve(scene, thickness).positions

    def times(lengths: Floats) -> Floats:
        with np.errstate(under="ignore", over="ignore"):
            return np.ldexp(lengths, exponent)

    case = Case(
        times(scene.positions_t0), times(scene.positions_t1), scene.faces,
        math.ldexp(thickness, exponent), scene.masses, scene.pinned,
    )  # fmt: skip
    return judge_step(
        case, Known(positions=times(right), tolerance=0.0, note="The bits are equal.")
    )


def _places() -> list[Ladder]:
    ladders = []
    for name, (words, make) in SHAPES.items():
        for where, direction in DIRECTIONS.items():

            def run(
                rung: Rung,
                make: Callable[..., AnalyticStep] = make,
                direction: Sequence[float] = direction,
            ) -> list[Outcome]:
                return _moved(make(), 2.0 ** float(rung), direction)

            told = (
                f"{words}. The step is moved {where} by two to the power of this times a metre, "
                f"where the scene is 1 m large. {HAND} Beyond 42, coordinates and thickness are "
                "rounded; then a certified path has to be free."
            )
            rungs = tuple(map(float, PLACES))
            ladders.append(
                Ladder(FAMILY, f"moved {where}, {name}", told, "exponent", rungs, run, (20.0,),
                       wanted=42.0)
            )  # fmt: skip
    told = (
        "A vertex falls through a pinned face of 1 m, and both are moved by so many metres in ten "
        "random directions, so that every coordinate is rounded. What is known is that the vertex "
        "keeps the thickness, up to the rounding of the coordinates."
    )
    sheets = (
        "Two wrinkled sheets of 150 triangles, 1 m large, go through each other, and are moved by "
        "so many metres. The right status and objective are those of the same sheets at the "
        "origin, with coordinates rounded as there."
    )
    far = tuple(10.0**k for k in (0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 20))
    return [
        *ladders,
        Ladder(FAMILY, "moved anywhere", told, "distance [m]", far, _anywhere, (1e6,), wanted=1e12),
        Ladder(FAMILY, "moved, sheets", sheets, "distance [m]", far, _sheets, (1e6,)),
    ]


def _moved(step: AnalyticStep, distance: float, direction: Sequence[float]) -> list[Outcome]:
    """Judge a step that is moved; the right end is known as long as no number is rounded."""
    there = moved(step, distance * np.array(direction))
    if distance <= EXACT_GRID:
        return judge_analytic(there)
    return judge_step(case_of(there), rounded(there))


def _anywhere(rung: Rung) -> list[Outcome]:
    distance = float(rung)
    draws = []
    for seed in range(10):
        direction = np.random.default_rng(seed).normal(size=3)
        there = moved(vertex_on_face(), distance * direction / np.linalg.norm(direction))
        # rounding moves each coordinate by up to this, and so the vertex and the face
        rounding = 4.0 * float(np.spacing(distance))
        if rounding < 0.25 * THICKNESS_M:
            known = Known(positions=there.right, tolerance=max(1e-9, rounding), note=HAND)
        else:
            known = rounded(there)
        draws.append(judge_step(case_of(there), known))
    return worst(draws)


def _sheets(rung: Rung) -> list[Outcome]:
    """Judge sheets far from the origin by the same sheets at the origin."""
    scene, by = (
        meeting_sheets(np.random.default_rng(0), 150),
        float(rung) * np.array([0.6, 0.0, 0.8]),
    )
    far = scene.positions_t0 + by, scene.positions_t1 + by
    near = far[0] - by, far[1] - by  # without rounding, since both numbers are on the same grid
    others = scene.faces, scene.masses, scene.pinned
    try:
        there = resolve(Scene(*near, *others), THICKNESS_M)
        off = _rounding(there, float(rung))
        tolerance = AWAY + 2.0 * off + off**2
        known = Known((there.status.name,), objective=there.objective, tolerance=tolerance)
    except IzoError as error:
        known = Known((type(error).__name__,))
    return judge_step(Case(*far, others[0], THICKNESS_M, *others[1:]), known)


def _rounding(result: Result, distance: float) -> float:
    """Return how far rounding moves the vertices that were moved, over how far they were moved.

    Far from the origin, the thickness is kept up to the rounding of two positions, and the end is
    rounded itself. Both are a unit in the last place at most.
    """
    moves = result.positions - result.certificate.scene.positions_t1
    n_moved = np.count_nonzero(moves.any(axis=1))
    return 2.0 * float(np.spacing(distance)) * math.sqrt(n_moved) / float(np.linalg.norm(moves))


def _thicknesses() -> list[Ladder]:
    ladders = []
    unit = "thickness / edge"
    for name, (words, make) in SHAPES.items():

        def at_zero(rung: Rung, make: Callable[..., AnalyticStep] = make) -> list[Outcome]:
            return judge_analytic(make(float(rung)))

        def higher(rung: Rung, make: Callable[..., AnalyticStep] = make) -> list[Outcome]:
            return _thin_and_high(make, float(rung))

        known = f"{words} at z = 0. {HAND}"
        rounded = (
            f"{words} at z = 1 m. {HAND} Below 1e-16 the right end is rounded onto what it may not "
            "touch; then a certified path has to be free."
        )
        ladders += [
            Ladder(FAMILY, f"thin at the origin, {name}", known, unit, THIN, at_zero, (1e-12,),
                   wanted=1e-12),
            Ladder(FAMILY, f"thin at 1 m, {name}", rounded, unit, THIN, higher, (1e-9,)),
            Ladder(FAMILY, f"thick, {name}", known, unit, THICK, at_zero, (10.0,), wanted=1e59),
        ]  # fmt: skip
    return ladders


def _thin_and_high(make: Callable[..., AnalyticStep], thickness: float) -> list[Outcome]:
    step = make(thickness, height=1.0)
    if thickness >= 1e-15:  # the tolerance of the positions covers the rounding of 1 + d
        return judge_analytic(step)
    return judge_step(case_of(step), rounded(step))


def _two_scales() -> list[Ladder]:
    told = (
        "A vertex of a triangle of 1 m falls onto a pinned face that is so many times larger. "
        f"{HAND}"
    )
    free = (
        "A vertex falls through a free face, whose corners weigh so many times as much as the "
        f"vertex. {HAND}"
    )
    ratios = tuple(10.0**k for k in (0, 3, 6, 9, 12, 16, 20, 24, 28, 30, 31, 40))

    def table(rung: Rung) -> list[Outcome]:
        step = vertex_on_face()
        start, end, right = (part.copy() for part in (step.start, step.end, step.right))
        for part in (start, end, right):
            part[:3] = (part[:3] - (0.25, 0.25, 0.0)) * float(rung) + (0.25, 0.25, 0.0)
        return judge_analytic(step._replace(start=start, end=end, right=right))

    def heavier(rung: Rung) -> list[Outcome]:
        mass = float(rung)
        return judge_analytic(free_vertex_on_face((mass, mass, mass, 1.0)))

    def lighter(rung: Rung) -> list[Outcome]:
        return judge_analytic(free_vertex_on_face((1.0, 1.0, 1.0, float(rung))))

    return [
        Ladder(
            FAMILY, "small on large", told, "ratio of sizes", TABLES, table, (1e9,), wanted=1e9
        ),
        Ladder(FAMILY, "heavy face", free, "mass ratio", ratios, heavier, (1e12,), wanted=1e30),
        Ladder(
            FAMILY, "light face",
            f"A vertex that weighs so many times as much falls through a free face. {HAND}",
            "mass ratio", ratios, lighter, (1e12,), wanted=1e30,
        ),
    ]  # fmt: skip


LADDERS: list[Ladder] = [*_sizes(), *_places(), *_thicknesses(), *_two_scales(), *UNITS]
