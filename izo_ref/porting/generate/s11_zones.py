"""The zones of stage S11: what is special about each, and how it is built."""

from __future__ import annotations

from random import Random

from izo_ref.porting.generate.random_numbers import dyadic, shuffled
from izo_ref.porting.generate.zone_parts import (
    FACE,
    MIDDLES,
    UP,
    Triple,
    ZoneParts,
    stack,
    unit,
)

SLANTED = unit(1.0, -2.0, 4.0)
DOWN: Triple = (0.0, 0.0, -1.0)
LIGHT, HEAVY = 2.0**-20, 2.0**20


def vertex_below_face(
    masses: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0),
    depth: float = 0.25,
    normal: Triple = UP,
    thickness: float = 2.0**-6,
    times: int = 1,
    size: float = 1.0,
    at: float = 0.0,
) -> ZoneParts:
    """Return a vertex that is proposed below a face; all four can move."""
    parts = ZoneParts(thickness)
    places = ((0.375, 0.25, -depth), (0, 0, 0), (1, 0, 0), (0, 1, 0))
    own = [
        parts.vertex([at + size * c for c in place], mass)
        for place, mass in zip(places, masses, strict=True)
    ]
    for _ in range(times):
        parts.impact(own, (1.0, -0.375, -0.375, -0.25), normal)
    return parts


def among_others() -> ZoneParts:
    """Return a vertex below a face in a zone that lists three vertices more, in no impact."""
    parts = ZoneParts()
    for place in ((0.5, -2.0, 3.0), (-1.5, 0.25, 2.0)):
        parts.vertex(place, 2.0)
    below = parts.vertex((0.375, 0.25, -0.25), 1.0)
    first = parts.vertex((0.0, 0.0, 0.0), 4.0)
    parts.vertex((1.0, 1.0, -3.0), 8.0)
    others = [parts.vertex(place, 2.0) for place in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))]
    parts.impact([below, first, *others], (1.0, -0.375, -0.375, -0.25))
    return parts


def plates_and_vertex(height: float) -> ZoneParts:
    """Return a pinned vertex at a height over a pinned face, and a free vertex below the face."""
    parts = ZoneParts()
    face = parts.plate((0.0, 0.0, 0.0))
    parts.impact([parts.vertex((0.25, 0.25, height), 0.0, 1), *face])
    parts.impact([parts.vertex((0.25, 0.25, -0.5), 1.0), *face])
    return parts


def edges_crossed(masses: tuple[float, ...], normal: Triple = UP) -> ZoneParts:
    """Return two edges of four masses; the first is proposed below the second."""
    parts = ZoneParts()
    places = ((-1, 0, -0.25), (1, 0, -0.5), (0, -1, 0), (0, 1, 0.125))
    own = [parts.vertex(place, mass) for place, mass in zip(places, masses, strict=True)]
    parts.impact(own, (0.75, 0.25, -0.375, -0.625), normal)
    return parts


def vertex_on_pinned_face(mass_of_pinned: float, mass: float = 1.0) -> ZoneParts:
    """Return a vertex that is proposed below a pinned face."""
    parts = ZoneParts()
    below = parts.vertex((0.25, 0.25, -0.5), mass)
    parts.impact([below, *parts.plate((0, 0, 0), mass_of_pinned)])
    return parts


def face_on_pinned_vertices(masses_of_pinned: tuple[float, float]) -> ZoneParts:
    """Return a face that is proposed below two pinned vertices, one of them at a corner."""
    parts = ZoneParts()
    face = [parts.vertex(place, 1.0) for place in ((0, 0, 0), (1, 0, 0.25), (0, 1, 0.125))]
    for mass, place, weights in zip(
        masses_of_pinned,
        ((0.25, 0.25, 0.0), (0.75, 0.125, 0.0)),
        ((1.0, -0.5, -0.25, -0.25), (1.0, -0.125, -0.75, -0.125)),
        strict=True,
    ):
        parts.impact([parts.vertex(place, mass, 1), *face], weights)
    return parts


def walls(*planes: tuple[Triple, float], start: Triple = (0, 0, 0), mass: float = 1.0) -> ZoneParts:
    """Return one vertex that pinned planes keep on one side each.

    Args:
        planes: Normal of each plane, and how far it is from the origin along the normal.
        start: Proposed position of the vertex.
        mass: Its mass.
    """
    parts = ZoneParts()
    own = parts.vertex(start, mass)
    for normal, offset in planes:
        axis = max(range(3), key=lambda k: abs(normal[k]))
        at = [offset / normal[axis] if k == axis else 0.0 for k in range(3)]
        parts.wall(own, at, normal)
    return parts


def same_row_scaled() -> ZoneParts:
    """Return a vertex, and an edge that leads to it; both are against pinned things."""
    parts = ZoneParts()
    own = parts.vertex((0, 0, -0.25), 1.0)
    held = parts.vertex((1, 0, 0), 0.0, 1)
    parts.wall(own, (0, 0, 0), UP)
    below = [parts.vertex((0.5, y, -(2.0**-7)), 0.0, 1) for y in (-1, 1)]
    parts.impact([own, held, *below], MIDDLES)
    return parts


def over_a_shared_edge(times: int) -> ZoneParts:
    """Return a vertex over an edge; each face at the edge gives the same constraint."""
    parts = ZoneParts()
    own, a, b = (
        parts.vertex(p, m) for p, m in (((0, 0, -0.25), 1), ((-1, 0, 0), 2), ((1, 0, 0), 4))
    )
    for k in range(times):
        tip = parts.vertex((0, 1 + k, 0), 1.0)
        parts.impact([own, a, b, tip], (1.0, -0.5, -0.5, 0.0))
    return parts


def press(room: float, layers: int = 1, thickness: float = 2.0**-6) -> ZoneParts:
    """Return free edges, one above the other, between a pinned floor and a pinned ceiling."""
    parts = stack([1.0] * layers, drop=-(2.0**-8), thickness=thickness)
    top = [parts.vertex((x, 0.0, room), 0.0, 1) for x in (-1.0, 1.0)]
    parts.impact([*top, 2 * layers, 2 * layers + 1], MIDDLES)
    return parts


def two_free_wedges(slope: float) -> ZoneParts:
    """Return a free vertex between two free faces, whose normals are nearly opposed."""
    parts = ZoneParts()
    own = parts.vertex((0, 0, 0), 1.0)
    for normal in (UP, unit(slope, 0.0, -1.0)):
        face = [parts.vertex(p, 2.0) for p in ((-1, 0, 0), (1, -1, 0), (1, 1, 0))]
        parts.impact([own, *face], FACE, normal)
    return parts


def fan(count: int, mass: float = 1.0) -> ZoneParts:
    """Return a vertex under many faces that have nearly the same normal."""
    parts = ZoneParts()
    own = parts.vertex((0, 0, -0.5), mass)
    for k in range(count):
        tilt = unit((k % 3 - 1) / 16.0, (k % 4 - 1.5) / 16.0, 1.0)
        face = [parts.vertex((x, y, k / 64.0), 1.0 + k % 5) for x, y in ((-1, 0), (1, -1), (1, 1))]
        parts.impact([own, *face], FACE, tilt)
    return parts


def corner(slope: float) -> ZoneParts:
    """Return a vertex that violates one plane; moving out of it violates another one."""
    steep = unit(-1.0, 0.0, slope)
    return walls((UP, 0.0), (steep, 0.0), start=(0.5, 0.0, -0.25))


def random_zone(seed: int, impacts: int, vertices: int, ratio: int = 4) -> ZoneParts:
    """Return random impacts of both kinds, with random normals; some vertices are pinned."""
    random, parts = Random(seed), ZoneParts(2.0**-7)
    for k in range(vertices):
        place = [dyadic(random, -0.5, 0.5) for _ in range(3)]
        mass = 2.0 ** int(ratio * random.random())
        parts.vertex(place, mass, int(k % 5 == 4))
    for j in range(impacts):
        own = shuffled(random, range(vertices))[:4]
        b, c = dyadic(random, 0.0, 1.0, 6), dyadic(random, 0.0, 1.0, 6)
        edges = (1.0 - b, b, c - 1.0, -c)
        face = (1.0, -b * c, b * c - b, b - 1.0)
        x, y, z = (dyadic(random, -1.0, 1.0) for _ in range(3))
        parts.impact(own, edges if j % 2 else face, unit(x, y, 1.0 + abs(z)))
    return parts
