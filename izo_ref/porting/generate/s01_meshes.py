"""The meshes of stage S1, and what each of them is for."""

from __future__ import annotations

from random import Random
from typing import NamedTuple

from izo_ref.porting.cases import DTYPES
from izo_ref.porting.generate.meshes import (
    TETRAHEDRON,
    TETRAHEDRON_FACES,
    Face,
    Mesh,
    flipped,
    grid,
    joined,
    noise,
    part,
    shift,
    stack,
)
from izo_ref.porting.generate.random_numbers import dyadic
from izo_ref.porting.reference.contact import Point

ONE: list[Face] = [(0, 1, 2)]
FLOOR: list[Point] = [(-8, -8, 0), (8, -8, 0), (0, 8, 0)]
SPIKE: list[Point] = [(0, 0, 1), (1, 0, 5), (0, 1, 5)]  # its first vertex is the tip, below
DOWN_TETRAHEDRON = flipped(TETRAHEDRON)


class Row(NamedTuple):
    """A mesh with what it is for."""

    word: str
    flags: tuple[str, ...]
    grade: str
    mesh: Mesh
    what: str
    dtypes: tuple[str, ...] = DTYPES


def rows() -> list[Row]:
    """Return all meshes."""
    return [*_missed(), *_touching(), *_still(), *_shared(), *_many()]


def _missed() -> list[Row]:
    flags = ("missed-pairs",)
    rest = part(TETRAHEDRON, TETRAHEDRON_FACES, 0, 0, 0)
    tip = part(shift(DOWN_TETRAHEDRON, 1, 1, 9), TETRAHEDRON_FACES, 0, 0, -4)
    sheets = joined(part(*grid(3, noise(1)), 0, 0, 0), part(*_over(3, 2), 0, 0, -4))
    crumpled = joined(part(*grid(5, noise(3)), 0.5, 0.25, 1), part(*_over(5, 4), -0.75, 0.5, -2))
    blade: list[Point] = [(-16, -16, 1), (-15, -16, 1), (-16, -15, 4)]
    diagonal = joined(part(FLOOR, ONE, 0, 0, 0), part(blade, ONE, 32, 32, -6))
    layers = joined(stack(6, 0.5), part(SPIKE, ONE, 0.25, 0.5, -4))
    crossing: list[Point] = [(-1, -9, -1), (1, -9, -1), (0, -9, 3)]
    edge = joined(part(FLOOR, ONE, 0, 0, 0), part(crossing, ONE, 0, 2, 0))
    apart = joined(rest, part(shift(TETRAHEDRON, 40, 0, 0), TETRAHEDRON_FACES, 1, 1, 1))
    loose = Mesh([*FLOOR, (1, 1, 3), (9, 9, 9)], [*FLOOR, (1, 1, -3), (9, 9, -9)], ONE)
    return [
        Row("tip", flags, "easy", joined(rest, tip), "The tip of a tetrahedron enters another."),
        Row("sheets", flags, "medium", sheets, "Two sheets of 3 x 3 vertices pass each other."),
        Row("sheets", flags, "hard", crumpled, "Two crumpled sheets of 5 x 5 vertices."),
        Row("diagonal", flags, "hard", diagonal, "Apart at both ends, and in one another between."),
        Row("layers", flags, "medium", layers, "A vertex goes through six layers in one step."),
        Row(
            "one-edge", flags, "medium", edge, "A side cuts two edges, and no vertex meets a face."
        ),
        Row("apart", flags, "easy", apart, "Nothing meets, and an empty list is right."),
        Row("loose", flags, "hard", loose, "A vertex of no face goes through a face."),
        Row("folding", flags, "hard", _folding(), "A flat sheet folds within its own plane."),
    ]


def _over(n: int, seed: int) -> tuple[list[Point], list[Face]]:
    """Return a sheet above another one, shifted by fractions of a cell."""
    points, faces = grid(n, noise(seed))
    return shift(points, 0.375, 0.3125, 2), faces


def _folding() -> Mesh:
    """Return a strip of four squares whose ends pass through each other in its own plane."""
    start: list[Point] = [(x, y, 0) for x in range(5) for y in (0, 1)]
    faces = [face for k in range(0, 8, 2) for face in ((k, k + 2, k + 3), (k, k + 3, k + 1))]
    end = [*start[:6], (1.5, 0.25, 0), (1.75, 0.75, 0), (0.5, 0.25, 0), (0.625, 0.75, 0)]
    return Mesh(start, end, faces)


def _touching() -> list[Row]:
    flags = ("touching-boxes",)
    floor = part(FLOOR, ONE, 0, 0, 0)
    ends = joined(floor, part(shift(SPIKE, 0, 0, 1), ONE, 0, 0, -2))
    corner: list[Point] = [(4, 0, 0), (8, 0, 0), (4, 4, 4)]
    beside: list[Point] = [(0, 0, 0), (0, 4, 0), (0, 0, -4)]
    slide = joined(part(corner, ONE, -4, 0, 0), part(beside, ONE, 0, 0, 0))
    far_start, far_end = (shift(p, -1048576, 65536, 524288) for p in (ends.start, ends.end))
    far = Mesh(far_start, far_end, ends.faces)
    boxes = joined(
        part([(0, 0, 0), (2, 0, 0), (0, 2, 0)], ONE, 0, 0, 0),
        part([(2, 1, 1), (4, 1, 1), (4, -2, -2)], ONE, -1, 1, 1),
    )
    cross = joined(
        part([(-1, 0, 0), (1, 0, 0), (0, -3, -3)], ONE, 0, 0, 0),
        part([(0, -1, 1), (0, 1, 1), (0, 3, 3)], ONE, 0, 0, -1),
    )
    high = joined(ends, part(shift(FLOOR, 0, 0, 48), ONE, 0, 0, 0))
    low = Mesh(flipped(high.start), flipped(high.end), high.faces)
    digits = "A vertex ends on a corner with all digits of a {}: boxes may not come apart."
    off = "As the first, {} the middle of the scene: rounded boxes may not shrink on this side."
    return [
        Row("touching", flags, "easy", ends, "A vertex ends on a face; their boxes only touch."),
        Row("touching", flags, "medium", cross, "Two edges end on each other: flat boxes touch."),
        Row("touching", flags, "medium", slide, "Boxes touch in a corner, at the end of the step."),
        Row(
            "touching", flags, "hard", far, "As the first, far away: rounded boxes may not shrink."
        ),
        Row("touching", flags, "hard", high, off.format("below")),
        Row("touching", flags, "hard", low, off.format("above")),
        Row("touching", flags, "easy", boxes, "Boxes touch, nothing meets: any list is right."),
        Row("touching", flags, "hard", _corners(8, 24), digits.format("float32")),
        Row("touching", flags, "hard", _corners(1, 53), digits.format("float64"), ("f8",)),
    ]


def _corners(seed: int, bits: int) -> Mesh:
    """Return two faces, one of which ends with its first vertex on the first vertex of the other.

    There the boxes touch. Boxes as middles and half sizes, or from start + (end - start), come
    apart by rounding with these seeds.
    """
    random = Random(seed)

    def points(count: int, low: float, high: float, digits: int) -> list[Point]:
        numbers = [dyadic(random, low, high, digits) for _ in range(3 * count)]
        return [(numbers[k], numbers[k + 1], numbers[k + 2]) for k in range(0, 3 * count, 3)]

    corner = points(1, 0.25, 0.5, bits)
    rest = points(2, 4.0, 8.0, bits - 3)
    start = points(3, -8.0, -4.0, bits - 3)
    end = points(2, -4.0, -1.0, bits - 3)
    still = corner + rest
    return Mesh(still + start, still + corner + end, [(0, 1, 2), (3, 4, 5)])


def _still() -> list[Row]:
    flags = ("still-nodes",)
    rest = part(TETRAHEDRON, TETRAHEDRON_FACES, 0, 0, 0)
    other = part(shift(TETRAHEDRON, 9, 0, 0), TETRAHEDRON_FACES, 0, 0, 0)
    mover = part(shift(DOWN_TETRAHEDRON, 1, 1, 9), TETRAHEDRON_FACES, 0, 0, -4)
    rising = joined(part(SPIKE, ONE, 0, 0, 0), part(FLOOR, ONE, 0, 0, 2))
    hinge = Mesh([*FLOOR, (0, 0, 1), (1, 0, 5), (0, 1, 5)], [], [(0, 1, 2), (3, 4, 5)])
    hinge = hinge._replace(end=[*hinge.start[:2], (0, 8, 8), *hinge.start[3:]])
    whole = "Three parts, two of which rest; the third meets one of them."
    return [
        Row("still", flags, "easy", rising, "A face rises to a vertex at rest."),
        Row("still", flags, "medium", joined(rest, other, mover), whole),
        Row(
            "still", flags, "hard", hinge, "Of six vertices one moves: its face turns on the rest."
        ),
        Row("still", flags, "easy", joined(rest, other), "Nothing moves, nothing meets."),
    ]


def _shared() -> list[Row]:
    flags = ("shared-vertices",)
    rim: list[Point] = [(4, 0, 0), (3, 3, 0), (0, 4, 0), (-3, 3, 0), (-4, 0, 0), (-3, -3, 0)]
    fan: list[Face] = [(0, k, k + 1) for k in range(1, 6)]
    start: list[Point] = [(0, 0, 1), *rim]
    closed = Mesh(start, [*start[:6], (3, 2, 1.5)], fan)
    opened = Mesh(start, [(0, 0, -1), *rim], fan)
    # the tip goes through the base: no pair of faces is without a common vertex
    inverted = Mesh(TETRAHEDRON, [*TETRAHEDRON[:3], (1, 1, -2)], TETRAHEDRON_FACES)
    strip: list[Point] = [(0, 0, 0), (0, 2, 0), (2, 0, 0), (2, 2, 0), (4, 1, 0)]
    faces: list[Face] = [(0, 2, 1), (1, 2, 3), (2, 4, 3)]
    lifted = Mesh([*strip[:4], (2.5, 1, 2)], [*strip[:4], (1, 1, -1)], faces)
    return [
        Row("fan", flags, "easy", opened, "Faces around one vertex, which moves: nothing meets."),
        Row("fan", flags, "medium", closed, "The last face of a fan meets the first ones."),
        Row("inverted", flags, "hard", inverted, "A tetrahedron turns inside out."),
        Row("strip", flags, "hard", lifted, "The end of a strip goes through its second face."),
    ]


def _many() -> list[Row]:
    flags = ("queue-overflow",)
    result = []
    for n, grade in ((20, "easy"), (70, "medium"), (150, "hard")):
        distance = 1 / 64
        mesh = joined(stack(n, distance), part(SPIKE, ONE, 0, 0, -1 - n * distance))
        what = f"One vertex meets {n} faces, more than a list of fixed length may hold."
        result.append(Row("many", flags, grade, mesh, what))
    tips = [part(shift(SPIKE, k / 256, k / 512, 0), ONE, 0, 0, -2) for k in range(48)]
    crowd = joined(stack(45, 1 / 64), *tips)
    what = "48 vertices go through 45 faces each: one block of queries has 2160 pairs."
    return [*result, Row("many", flags, "hard", crowd, what)]
