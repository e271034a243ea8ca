"""Kinds of starts that touch exactly, each with its right status and answer."""

import numpy as np

from validation.ladders.ladder import Outcome, Rung
from validation.ladders.stacked import FREE, Kind
from validation.scenes.gadgets import Gadget, edge_on_edge, vertex_on_edge, vertex_on_face
from validation.scenes.shapes import CORNERS

RATCHET = {"initial_intersections": "ratchet"}
REFUSED = ("InitialIntersectionError",)
LEFT_OUT = ("FREE_EXCEPT_EXCLUDED",)


def judge_kind(rung: Rung) -> list[Outcome]:
    """Resolve the step of a kind and judge it.

    Args:
        rung: A name of KINDS.
    """
    return KINDS[str(rung)].judge()


def tip_on_face(end_gap: float) -> Gadget:
    """Let a triangle stand with one corner on the centre of a face, and fall or rise.

    Args:
        end_gap: Proposed height of the corner at the end [m].
    """
    gadget = vertex_on_face(CORNERS, 0.0, end_gap)
    above = np.array([[0.5, 0.25, 4.0], [-0.5, 0.25, 4.0]])
    ends = above + (0.0, 0.0, end_gap)
    start, end, faces, best, _ = gadget
    return Gadget(
        np.concatenate((start, above)),
        np.concatenate((end, ends)),
        np.concatenate((faces, [[3, 4, 5]])),
        np.concatenate((best, ends)),
    )


def _as_proposed(scene: Gadget) -> Gadget:
    return scene._replace(best=scene.end)


def _in_the_plane(end_gap: float) -> Gadget:
    """Let a small face lie in the plane of another one and inside it, and move along its normal."""
    start = np.concatenate((CORNERS, 0.125 * CORNERS))
    end = start + np.repeat([0.0, end_gap], 3)[:, None] * (0.0, 0.0, 1.0)
    return Gadget(start, end, np.array([[0, 1, 2], [3, 4, 5]]), end)


def _corner_on_corner(end_gap: float) -> Gadget:
    """Let two triangles touch by their corners, and move on past each other."""
    low = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, -2.0], [-1.0, 0.5, -2.0]])
    high = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 2.0], [-1.0, 0.0, 2.0]])
    start = np.concatenate((low, high))
    end = np.concatenate((low, high + (0.0, 0.0, end_gap)))
    return Gadget(start, end, np.array([[0, 1, 2], [3, 4, 5]]), end)


SQUARE = 0.5 * np.pi
KINDS: dict[str, Kind] = {
    "corner on a face, refused": Kind(lambda: tip_on_face(-0.5), REFUSED),
    "corner on a face, falls": Kind(lambda: tip_on_face(-0.5), FREE, RATCHET),
    "corner on a face, rises": Kind(lambda: tip_on_face(0.5), FREE, RATCHET),
    "edge on an edge, refused": Kind(lambda: edge_on_edge(2.0, SQUARE, 0.0), REFUSED),
    "edge on an edge, falls": Kind(lambda: edge_on_edge(2.0, SQUARE, 0.0), FREE, RATCHET),
    "parallel edges, falls": Kind(lambda: edge_on_edge(1.0, 0.0, 0.0), FREE, RATCHET),
    "corner on an edge in one plane, refused": Kind(lambda: vertex_on_edge(0.0, -0.5), REFUSED),
    "corner on an edge in one plane, goes on": Kind(
        lambda: vertex_on_edge(0.0, -0.5), FREE, RATCHET
    ),
    "corner on an edge in one plane, leaves": Kind(lambda: vertex_on_edge(0.0, 0.5), FREE, RATCHET),
    "corner on a corner, refused": Kind(lambda: _corner_on_corner(0.5), REFUSED),
    "corner on a corner, leaves": Kind(lambda: _corner_on_corner(0.5), FREE, RATCHET),
    "vertex without faces on a face, falls": Kind(
        lambda: _as_proposed(vertex_on_face(CORNERS, 0.0, -0.5)), LEFT_OUT, RATCHET
    ),
    "face in the plane of a face, refused": Kind(lambda: _in_the_plane(0.5), REFUSED),
    "face in the plane of a face, leaves": Kind(lambda: _in_the_plane(0.5), LEFT_OUT, RATCHET),
}
