"""Family of geometry: slivers, needles, parallel edges, T-junctions, fans, soup, and defects."""

from functools import partial

import numpy as np

from validation.ladders.geometry_kinds import KINDS, judge_kind
from validation.ladders.judge_step import Case, Known, judge_step
from validation.ladders.ladder import Ladder, Outcome, Rung
from validation.ladders.stacked import CERTIFIED, FREE, judge_gadget, moved_centre
from validation.scenes.gadgets import edge_on_edge, vertex_on_edge, vertex_on_face
from validation.scenes.shapes import CORNERS, book, fan, soup

FAMILY = "geometry"
SEED = 21
REFUSED = ("InitialIntersectionError",)
SOUP_THICKNESS_M = 2.0**-10
SMALL = (1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-15, 1e-16, 1e-20, 1e-50)
SMALL = (*SMALL, 1e-100, 1e-200, 1e-300, 5e-324, 0)
CLOSED = (
    "The closed form is an answer; one that slides off sideways may be closer to the proposed "
    "positions, so the objective may be lower, but not higher."
)


def _sliver(rung: Rung) -> list[Outcome]:
    return judge_gadget(vertex_on_face(CORNERS * (1.0, float(rung), 1.0)), by_objective=True)


def _needle(rung: Rung) -> list[Outcome]:
    return judge_gadget(edge_on_edge(2.0 * float(rung)), by_objective=True)


def _parallel(rung: Rung) -> list[Outcome]:
    return judge_gadget(edge_on_edge(1.0, float(rung)), by_objective=True)


def _t_junction(rung: Rung, end: float) -> list[Outcome]:
    gap = float(rung)
    return judge_gadget(vertex_on_edge(gap, end), FREE if gap > 0.0 else REFUSED)


def _fan(rung: Rung) -> list[Outcome]:
    return judge_gadget(fan(int(rung)))


def _fans(rung: Rung) -> list[Outcome]:
    start, end, faces, *_ = fan(int(rung), twin=True)
    return judge_step(Case(start, end, faces, 2.0**-10), Known(CERTIFIED, check=moved_centre))


def _book(rung: Rung) -> list[Outcome]:
    return judge_gadget(book(int(rung)))


def _soup(rung: Rung) -> list[Outcome]:
    case = Case(*soup(np.random.default_rng(SEED), int(rung)), SOUP_THICKNESS_M)
    return judge_step(case, Known(check=moved_centre))


LADDERS = [
    Ladder(
        FAMILY,
        "slivers",
        "A vertex falls through the centre of a face that becomes a sliver, and at 0 a line. "
        + CLOSED,
        "height / length of the face",
        SMALL,
        _sliver,
        (1, 1e-3, 1e-8, 0),
    ),
    Ladder(
        FAMILY,
        "needle edges",
        "A short edge falls through a long one; at 0 it is a point, and its face has no area. "
        + CLOSED,
        "length of the edge / that of the other",
        SMALL,
        _needle,
        (1, 1e-3, 1e-12, 0),
    ),
    Ladder(
        FAMILY,
        "parallel edges",
        "An edge falls through another one that is nearly parallel to it, and at 0 parallel, with "
        "both faces in one plane. " + CLOSED,
        "angle [rad]",
        SMALL,
        _parallel,
        (1, 1e-3, 1e-8, 0),
    ),
    Ladder(
        FAMILY,
        "T-junction that closes",
        "The tip of a triangle starts close to the middle of another one's edge, in the same "
        "plane, and moves through it. The answer is known in closed form. A start that touches is "
        "refused by an error that names the pairs.",
        "distance at the start / length of the edge",
        SMALL,
        partial(_t_junction, end=-0.5),
        (1, 1e-8, 5e-324, 0),
    ),
    Ladder(
        FAMILY,
        "T-junction that opens",
        "The same tip moves away from the edge, so the proposed positions are the answer, bit for "
        "bit.",
        "distance at the start / length of the edge",
        SMALL,
        partial(_t_junction, end=2.0),
        (1, 1e-8, 5e-324, 0),
    ),
    Ladder(
        FAMILY,
        "fan on a face",
        "The hub of a cone of many faces falls through a pinned face. The answer is known in "
        "closed form. Detection compares all edges at the hub with one another, so the time grows "
        "with the square of their number.",
        "faces at one vertex",
        (3, 10, 30, 100, 300, 1000, 3000, 10000, 30000, 100000),
        _fan,
        (3, 100),
        120.0,
    ),
    Ladder(
        FAMILY,
        "fan on a fan",
        "Two cones of many faces go through each other, tip first, so that each face meets very "
        "many. The end has to be certified free, and the centre of mass stays.",
        "faces at one vertex",
        (3, 10, 20, 30, 50, 70, 100, 140, 200, 300, 500, 1000, 2000, 3000),
        _fans,
        (3, 10),
        300.0,
    ),
    Ladder(
        FAMILY,
        "non-manifold edge",
        "An edge that many faces share falls through a pinned edge. The answer is known in closed "
        "form. All faces are close to one another, so the time grows with the square of their "
        "number.",
        "faces at one edge",
        (1, 2, 3, 5, 10, 30, 100, 300, 1000, 3000, 10000, 30000),
        _book,
        (1, 3, 100),
        120.0,
    ),
    Ladder(
        FAMILY,
        "triangle soup",
        "Triangles without common vertices fly through one another, each corner its own way, up to "
        "two of their sizes. The end has to be certified free, and the centre of mass stays.",
        "triangles",
        (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000),
        _soup,
        (2, 10),
        300.0,
    ),
    Ladder(
        FAMILY,
        "defects",
        "Meshes with one defect each, beside a contact whose answer is known in closed form. The "
        "right answer is that one with the mesh untouched, or a refusal that names the defect.",
        "kind",
        tuple(KINDS),
        judge_kind,
        tuple(KINDS),
    ),
]
