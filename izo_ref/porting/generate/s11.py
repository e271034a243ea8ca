"""Vectors of stage S11: the optimum of a zone, exact."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from izo_ref.porting.cases import ACCEPTABLE, DTYPES, VALID, Case
from izo_ref.porting.generate import s11_zones as z
from izo_ref.porting.generate.zone_parts import UP, Triple, ZoneParts, stack, unit
from izo_ref.porting.reference.optimum import Optimum, Rows, check, optimum, rows_of
from izo_ref.porting.reference.optimum_scale import MULTIPLE, scales

NAN = float("nan")
LEFT: Triple = (-1.0, 0.0, 0.0)
RIGHT: Triple = (1.0, 0.0, 0.0)
BACK: Triple = (0.0, 1.0, 0.0)


class Lot(NamedTuple):
    """One case before it is solved."""

    word: str
    flags: tuple[str, ...]
    grade: str
    what: str
    parts: ZoneParts
    verdict: str = VALID


def _one_impact() -> list[Lot]:
    one = ("mass-weighting",)
    return [
        Lot("single", one, "easy", "One vertex and one face; the closed form is the answer.",
            z.vertex_below_face()),
        Lot("single", one, "medium", "Two edges whose four ends have different masses.",
            z.edges_crossed((1.0, 2.0, 4.0, 8.0))),
        Lot("single", one, "medium", "The normal is not along an axis.",
            z.vertex_below_face((4.0, 1.0, 2.0, 0.5), normal=z.SLANTED)),
        Lot("pinned", ("pinned-masses", "mass-weighting"), "easy",
            "A face whose mass is given as 0 is pinned, so the vertex goes the whole way.",
            z.vertex_on_pinned_face(0.0)),
        Lot("pinned", ("pinned-masses", "mass-weighting"), "medium",
            "The masses of two pinned vertices are NaN and negative.",
            z.face_on_pinned_vertices((NAN, -1.0))),
        Lot("pinned", ("pinned-masses", "mass-weighting"), "hard",
            "The masses of two pinned vertices are so small that dividing by them would "
            "drown all others.", z.face_on_pinned_vertices((2.0**-100, 2.0**-90))),
        Lot("satisfied", ("constraint-sign",), "easy",
            "The proposed positions satisfy the constraint, so they are the answer, bit for bit.",
            z.vertex_below_face(depth=-0.5)),
        Lot("satisfied", ("constraint-sign", "absolute-tolerance"), "medium",
            "The gap is as large as the thickness exactly, so nothing moves.",
            z.vertex_below_face(depth=-(2.0**-6))),
        Lot("satisfied", ("constraint-sign",), "hard",
            "Eight layers satisfy all constraints, so no bit changes.", stack([1.0] * 8, -0.125)),
        Lot("single", ("node-order",), "medium", "The first two vertices and one in the middle are "
            "in no impact, and stay where they are proposed to be.", z.among_others()),
        Lot("pinned", ("pinned-masses",), "medium", "All vertices of the first impact are pinned; "
            "it is satisfied, so it does not matter.", z.plates_and_vertex(0.5)),
    ]  # fmt: skip


def _masses() -> list[Lot]:
    own = ("mass-ratio", "mass-weighting")
    two = z.edges_crossed((z.LIGHT, 1.0, z.HEAVY, 1.0), z.SLANTED)
    two.impact((1, 0, 3, 2), (0.5, 0.5, -0.75, -0.25))
    heavy, light = 2.0**30, 2.0**-10
    return [
        Lot("mass", own, "easy", "One impact; the masses differ by a factor of a million.",
            z.vertex_below_face((2.0**-10, 1.0, 1.0, 2.0**10))),
        Lot("mass", own, "medium", "Two impacts share vertices whose masses differ by 1e12.", two),
        Lot("mass", own, "hard", "One impact with a mass ratio of 1e12: the heavy vertex moves by "
            "less than the rounding of its position.",
            z.vertex_below_face((light, heavy, 1.0, heavy))),
        Lot("mass", own, "hard", "Layers of masses 1e9, 1e6, 1e3 and 1 kg; the lightest is on "
            "top.", stack([2.0**30, 2.0**20, 2.0**10, 1.0])),
        Lot("mass", own, "hard", "Layers of masses 1, 128, 16e3 and 1e6 kg; the heaviest is "
            "on top.", stack([1.0, 2.0**7, 2.0**14, 2.0**20])),
        Lot("mass", own, "hard", "Light layers between heavy ones, nothing pinned.",
            stack([1024.0, 1.0] * 4, floor=False)),
    ]  # fmt: skip


def _redundant() -> list[Lot]:
    own = ("rows-redundant",)
    slanted = unit(3.0, 4.0, 0.0)
    floor: tuple[Triple, float] = (UP, 0.0)
    turned = [(unit(x, y, 4.0), 0.0) for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1))]
    return [
        Lot("redundant", own, "easy", "The same impact twice: its multiplier may be divided "
            "between the two in any way.", z.vertex_below_face(times=2)),
        Lot("redundant", own, "hard", "The same impact twelve times.",
            z.vertex_below_face((1.0, 2.0, 3.0, 4.0), normal=z.SLANTED, times=12)),
        Lot("redundant", own, "medium", "One constraint is half of another one, because the rest "
            "of its edge is pinned.", z.same_row_scaled()),
        Lot("redundant", own, "medium", "Two faces share the edge that a vertex is under.",
            z.over_a_shared_edge(2)),
        Lot("redundant", own, "hard", "Nine faces share the edge that a vertex is under.",
            z.over_a_shared_edge(9)),
        Lot("redundant", own, "hard", "A vertex in a corner of three planes, and a fourth plane "
            "through the corner.",
            z.walls((RIGHT, 0.0), (BACK, 0.0), floor, (UP, 0.0), (RIGHT, 0.0),
                    start=(-0.5, -0.25, -0.75))),
        Lot("redundant", own, "hard", "A vertex in the tip of a pyramid: five planes in three "
            "dimensions.", z.walls(*turned, floor, start=(0.25, 0.125, -1.0))),
        Lot("redundant", own, "medium", "Two of three constraints imply the third one, which is "
            "tight nowhere.",
            z.walls((RIGHT, 0.0), (BACK, 0.0), (slanted, -0.25), start=(-0.5, -0.75, 0.0))),
        Lot("redundant", own, "hard", "Three planes through one direction. A method that adds the "
            "most violated constraint must give up the second one for the third, which depends "
            "on those it has.",
            z.walls((UP, 77 / 64), (unit(4.0, 0.0, 3.0), 1.0), (unit(3.0, 0.0, 4.0), 19 / 16))),
        Lot("redundant", own, "medium", "Two parallel planes, of which the second one is farther: "
            "a method that keeps one of parallel rows has to keep the right one.",
            z.walls(floor, (UP, 0.25), start=(0.0, 0.0, -0.5))),
    ]  # fmt: skip


def _opposed() -> list[Lot]:
    own = ("rows-opposed",)
    down = unit(2.0**-4, 0.0, -1.0)
    flat = unit(2.0**-10, 0.0, -1.0)
    return [
        Lot("opposed", own, "easy", "A vertex between two pinned plates with room enough.",
            z.walls((UP, 0.0), (z.DOWN, -1.0), start=(0.0, 0.0, -0.5))),
        Lot("opposed", own, "medium", "A vertex between two pinned plates that leave room for "
            "one position only. Rounding can turn this into no room at all, so a port may refuse.",
            z.press(2.0**-5), ACCEPTABLE),
        Lot("opposed", own, "hard", "A vertex in a wedge of 4 degrees; the answer is sixteen times "
            "farther away than the constraints are violated.",
            z.walls((UP, 0.25), (down, 0.0))),
        Lot("opposed", own, "hard", "A vertex in a wedge of 0.06 degrees; the answer is a thousand "
            "times farther away than the constraints are violated.",
            z.walls((UP, 0.25), (flat, 0.0))),
        Lot("opposed", own, "hard", "A free vertex between two free faces with nearly opposed "
            "normals.", z.two_free_wedges(2.0**-5)),
        Lot("infeasible", ("infeasible", "rows-opposed"), "easy",
            "Two pinned plates leave no room for a vertex.",
            z.walls((UP, 0.0), (z.DOWN, 0.0))),
        Lot("infeasible", ("infeasible", "rows-opposed"), "medium",
            "Three pinned planes, of which each two leave room, leave none together.",
            z.walls((RIGHT, 1.0), (unit(-3.0, 4.0, 0.0), 0.0), (unit(-3.0, -4.0, 0.0), 0.0))),
        Lot("infeasible", ("infeasible", "rows-opposed"), "hard",
            "Five layers between a floor and a ceiling that leave room for four.",
            z.press(5.5 * 2.0**-6, layers=5)),
        Lot("infeasible", ("infeasible", "rows-opposed"), "hard",
            "A floor and a ceiling come so close that a hundredth of a thickness is missing.",
            z.press((2.0 - 2.0**-7) * 2.0**-6)),
        Lot("infeasible", ("infeasible", "pinned-masses"), "medium", "All vertices of the first "
            "impact are pinned, and it is violated: nothing can change that.",
            z.plates_and_vertex(0.0)),
    ]  # fmt: skip


def _sizes() -> list[Lot]:
    own = ("absolute-tolerance",)
    tiny = z.vertex_below_face(depth=0.25, thickness=2.0**-26, size=2.0**-20, times=1)
    far = z.vertex_below_face((1.0, 2.0, 1.0, 4.0), thickness=2.0**-10, at=1024.0)
    grams = stack([2.0**-40, 2.0**-39, 2.0**-40])
    return [
        Lot("size", own, "easy", "The zone is a micrometre large: a tolerance in metres finds "
            "nothing to do.", tiny),
        Lot("size", own, "medium", "The zone is a thousand kilometres large.",
            z.vertex_below_face(thickness=16.0, size=2.0**20)),
        Lot("size", own, "hard", "The zone is a kilometre away from the origin.", far),
        Lot("size", own, "hard", "The thickness is a billion times smaller than the violation.",
            stack([1.0, 2.0, 1.0], thickness=2.0**-30)),
        Lot("size", ("absolute-tolerance", "mass-weighting"), "hard",
            "All masses are 1e-12 kg.", grams),
    ]  # fmt: skip


def _hard_to_finish() -> list[Lot]:
    cap, early = ("cap-100", "early-stop"), ("early-stop", "cap-100")
    return [
        Lot("cap", cap, "easy", "Eight equal layers, all pressed together: a push at the floor "
            "reaches the top after many steps only.", stack([1.0] * 8)),
        Lot("cap", cap, "medium", "Twelve equal layers.", stack([1.0] * 12)),
        Lot("cap", cap, "hard", "Ten layers, of which the top one is a thousand times heavier.",
            stack([1.0] * 9 + [1024.0], normal=z.SLANTED)),
        Lot("cap", cap, "hard", "Twelve layers of alternating masses.", stack([1.0, 32.0] * 6)),
        Lot("early", early, "easy", "Moving a vertex out of one plane moves it into another one. "
            "The first positions without violation are not the closest ones.", z.corner(1.0)),
        Lot("early", early, "medium", "As before, at an angle of 7 degrees: progress is slow, so "
            "small steps do not mean that the end is near.", z.corner(0.125)),
        Lot("early", early, "hard", "A vertex under twelve faces with nearly the same normal.",
            z.fan(12)),
        Lot("early", early, "hard", "A light vertex under ten heavier faces.", z.fan(10, 2.0**-6)),
        Lot("random", early, "medium", "Six random impacts.", z.random_zone(111, 6, 12)),
        Lot("random", early, "medium", "Eight random impacts of few vertices.",
            z.random_zone(112, 8, 10)),
        Lot("random", early, "hard", "Eleven random impacts; the masses differ by 1e3.",
            z.random_zone(113, 11, 14, 10)),
        Lot("random", early, "hard", "Twelve random impacts of few vertices; the masses differ "
            "by 1e6.", z.random_zone(114, 12, 14, 20)),
    ]  # fmt: skip


def _expected(inputs: Mapping[str, Any], rows: Rows, found: Optimum) -> tuple[Any, tuple[str, ...]]:
    """Return what is expected, and the types of floats for which that says something."""
    feasible = {"judge": "equal", "values": [int(found.feasible)]}
    if not found.feasible:
        return {"feasible": feasible}, DTYPES
    scale = scales(inputs, rows, found)
    moves = dict(zip(rows.unknowns, found.moves, strict=True))
    ends = [
        float(Fraction(c) + moves.get((i // 3, i % 3), 0)) for i, c in enumerate(inputs["proposed"])
    ]
    limits = {"multiple": MULTIPLE["f4"], "multiple_f8": MULTIPLE["f8"]}
    positions = {"judge": "values", "values": ends, "scale": scale.positions, **limits}
    kkt = {
        "judge": "kkt",
        "scale": [2.0 * s for s in scale.positions],
        "gap_scale": scale.gaps,
        **limits,
    }
    return {"feasible": feasible, "positions": positions, "multipliers": kkt}, scale.dtypes


def cases() -> list[Case]:
    """Return the cases of stage S11."""
    result, counts = [], dict[str, int]()
    lots = [*_one_impact(), *_masses(), *_redundant(), *_opposed(), *_sizes(), *_hard_to_finish()]
    for lot in lots:
        number = counts[lot.word] = counts.get(lot.word, 0) + 1
        inputs = lot.parts.inputs()
        rows = rows_of(inputs)
        found = optimum(rows)
        check(rows, found)
        expected, dtypes = _expected(inputs, rows, found)
        name = f"S11-{lot.word}-{number:02}"
        result.append(
            Case(name, "S11", lot.flags, lot.verdict, lot.grade, dtypes, lot.what, inputs, expected)
        )
    return result
