"""Kinds of defects of a mesh, each with its right status and, where it is resolved, its answer."""

import numpy as np

from validation.ladders.ladder import Outcome, Rung
from validation.ladders.stacked import FREE, Kind
from validation.scenes.gadgets import Gadget
from validation.scenes.shapes import CORNERS, FAR, tetrahedron, with_parts

WELDED = {"weld": 0.0}
RATCHET = {"initial_intersections": "ratchet"}
REFUSED = ("InitialIntersectionError",)


def judge_kind(rung: Rung) -> list[Outcome]:
    """Resolve the step of a kind and judge it.

    Args:
        rung: A name of KINDS.
    """
    return KINDS[str(rung)].judge()


def _line(*x: float) -> Gadget:
    """Put a face whose corners are on one line beside the contact."""
    return with_parts([[v, v, 0.0] for v in x], [[0, 1, 2]], (1.0, 2.0, 3.0))


def _repeated(*rows: tuple[int, int, int]) -> Gadget:
    """Put a tetrahedron with some faces more beside the contact."""
    points, faces = tetrahedron()
    return with_parts(points, [*faces.tolist(), *rows])


def _duplicates() -> Gadget:
    """Put two tetrahedra with common places, but no common vertices, beside the contact."""
    points, faces = tetrahedron()
    other = points * (1.0, 1.0, -1.0)
    other[3] = 0.0, 0.0, -1.0
    return with_parts(np.concatenate((points, other)), np.concatenate((faces, faces[:, ::-1] + 4)))


def _seam() -> Gadget:
    """Put a sheet of two triangles beside the contact whose common edge is doubled."""
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0]]
    return with_parts(points, [[0, 1, 2], [3, 4, 5]], (0.0, 1.0, 0.0))


def _soup(move: float) -> Gadget:
    """Put a tetrahedron beside the contact whose faces have vertices of their own."""
    points, faces = tetrahedron()
    return with_parts(points[faces.ravel()], np.arange(12).reshape(4, 3), (move, 0.0, 0.0))


def _coplanar(gap: float) -> Gadget:
    """Put two faces in one plane beside the contact, level with each other."""
    face = CORNERS[:, [1, 0, 2]]
    return with_parts(np.concatenate((face, face + (4.0 + gap, 0, 0))), [[0, 1, 2], [3, 4, 5]])


def _collinear(gap: float) -> Gadget:
    """Put two faces beside the contact whose edges are on one line, one behind the other."""
    a, b = [[0, 0, 0], [1, 0, 0], [0, 1, 1]], [[1 + gap, 0, 0], [2, 0, 0], [2, 1, -1]]
    return with_parts(np.array(a + b, float), [[0, 1, 2], [3, 4, 5]])


def _alone(n_vertices: int, faces: list[list[int]]) -> Gadget:
    """Return a mesh of a few vertices and faces that moves as proposed, and nothing else."""
    start = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 1.0]])
    start = start[:n_vertices]
    end = start + (1.0, 2.0, 3.0)
    return Gadget(start, end, np.array(faces, np.int32).reshape(-1, 3), end)


def _isolated(*positions: tuple[float, float, float]) -> Gadget:
    return with_parts(np.array(positions) - FAR, np.empty((0, 3), np.int32))


T_JUNCTION = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 0, 0], [1, 1, 0], [-1, 1, 0]]
BOW_TIE = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
KINDS: dict[str, Kind] = {
    "zero-area face: three places on a line": Kind(lambda: _line(0.0, 1.0, 2.0)),
    "zero-area face: two corners at one place": Kind(lambda: _line(0.0, 0.0, 1.0)),
    "zero-area face: one place": Kind(lambda: _line(0.0, 0.0, 0.0)),
    "the same vertex twice in a face": Kind(
        lambda: with_parts([[0, 0, 0], [1, 0, 0]], [[0, 1, 1]]), ("DegenerateFaceError",)
    ),
    "an index of no vertex": Kind(
        lambda: with_parts([[0, 0, 0], [1, 0, 0]], [[0, 1, 2]]), ("IndexRangeError",)
    ),
    "face twice": Kind(lambda: _repeated((0, 1, 3))),
    "face twice, turned around": Kind(lambda: _repeated((1, 0, 3))),
    "face a hundred times": Kind(lambda: _repeated(*((0, 1, 3),) * 100)),
    "three faces at an edge": Kind(
        lambda: with_parts(
            [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 1], [0, -1, -1]],
            [[0, 1, 2], [0, 1, 3], [0, 1, 4]],
        )
    ),
    "two fans at one vertex": Kind(lambda: with_parts(BOW_TIE, [[0, 1, 2], [0, 3, 4]])),
    "duplicate vertices, refused": Kind(_duplicates, REFUSED),
    "duplicate vertices, welded": Kind(_duplicates, FREE, WELDED),
    "seam, refused": Kind(_seam, REFUSED),
    "seam, welded": Kind(_seam, FREE, WELDED),
    "triangle soup, refused": Kind(lambda: _soup(1.0), REFUSED),
    "triangle soup, welded": Kind(lambda: _soup(1.0), FREE, WELDED),
    "T-junction, refused": Kind(lambda: with_parts(T_JUNCTION, [[0, 1, 2], [3, 4, 5]]), REFUSED),
    "coplanar faces": Kind(lambda: _coplanar(1.0)),
    "coplanar faces, 1e-15 apart": Kind(lambda: _coplanar(1e-15)),
    "edges on one line": Kind(lambda: _collinear(0.5)),
    "edges on one line that touch, refused": Kind(lambda: _collinear(0.0), REFUSED),
    "isolated vertex": Kind(lambda: _isolated((9.0, 9.0, 9.0))),
    "isolated vertices at one place": Kind(lambda: _isolated(*((9.0, 9.0, 9.0),) * 3)),
    "isolated vertex on the face, refused": Kind(lambda: _isolated((0.25, 0.0, 0.0)), REFUSED),
    "isolated vertex at the largest float": Kind(lambda: _isolated((1.7e308, 0.0, 0.0))),
    "no vertices": Kind(lambda: _alone(0, [])),
    "one vertex, no faces": Kind(lambda: _alone(1, [])),
    "no faces": Kind(lambda: _alone(4, [])),
    "one face": Kind(lambda: _alone(3, [[0, 1, 2]])),
    "two faces": Kind(lambda: _alone(4, [[0, 1, 2], [1, 3, 2]])),
    "two faces of the same vertices": Kind(lambda: _alone(3, [[0, 1, 2], [0, 2, 1]])),
}
