"""Meshes with the defects that exporters and artists make, each beside a contact that is known."""

import numpy as np
from numpy.typing import ArrayLike

from izo_ref.base.arrays import Faces, Floats, Positions
from validation.scenes.gadgets import THICKNESS_M, Gadget, vertex_on_face

CORNERS = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]])
FAR = np.array([64.0, 0.0, 0.0])


def with_parts(
    start: ArrayLike, faces: ArrayLike, move: ArrayLike = (0.0, 0.0, 0.0), at: ArrayLike = FAR
) -> Gadget:
    """Put a mesh beside a vertex that falls on a face; the mesh moves without touching anything.

    Args:
        start: (k, 3) [m], vertices of the mesh.
        faces: (m, 3), its faces.
        move: By which all of its vertices move [m].
        at: Where its origin is [m].

    Returns:
        The step; its answer is known in closed form, and the mesh ends as proposed.
    """
    known = vertex_on_face(CORNERS)
    own = np.asarray(start, np.float64).reshape(-1, 3) + np.asarray(at, np.float64)
    ends = own + np.asarray(move, np.float64)
    more = 4 + np.asarray(faces, np.int32).reshape(-1, 3)
    return Gadget(
        np.concatenate((known.start, own)),
        np.concatenate((known.end, ends)),
        np.concatenate((known.faces, more)),
        np.concatenate((known.best, ends)),
    )


def fan(n: int, end_height: float = -0.25, twin: bool = False) -> Gadget:
    """Lower the hub of a cone of n faces onto a pinned face, or onto the hub of another cone.

    Args:
        n: Faces of a cone, at least 3.
        end_height: Proposed height of the hub at the end [m]; it starts at 1 m.
        twin: Whether a cone that points upward, with n faces too, takes the place of the pinned
            face. Nothing is then known of the end, and the best end that is returned is none.
    """
    angle = 2.0 * np.pi * np.arange(n) / n
    rim = np.column_stack((np.cos(angle), np.sin(angle), np.full(n, 2.0)))
    start = np.concatenate(([[0.0, 0.0, 1.0]], rim))
    k = np.arange(n)
    faces = np.column_stack((np.zeros(n, int), 1 + k, 1 + (k + 1) % n))
    if twin:
        low = start * (1.0, 1.0, -1.0) + (0.01, 0.02, 1.0)
        start = np.concatenate((start, low))
        end = start - np.where(np.arange(len(start)) <= n, 1.5, 0.0)[:, None] * (0.0, 0.0, 1.0)
        both = np.concatenate((faces, faces + n + 1)).astype(np.int32)
        return Gadget(start, end, both, end)
    table = 16.0 * CORNERS
    start = np.concatenate((start, table))
    end = start.copy()
    end[0, 2] = end_height
    best = end.copy()
    best[0, 2] = THICKNESS_M
    faces = np.concatenate((faces, [[n + 1, n + 2, n + 3]]))
    return Gadget(start, end, faces, best, np.arange(n + 4) > n)


def book(pages: int) -> Gadget:
    """Lower an edge that many faces share onto a pinned edge that crosses it.

    Args:
        pages: Number of faces that share the edge, like pages their spine.
    """
    spine = np.array([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0]])
    angle = np.pi * (np.arange(pages) + 0.5) / pages
    tips = np.column_stack((np.zeros(pages), 4.0 * np.cos(angle), 2.0 + 4.0 * np.sin(angle)))
    low = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -4.0]])
    start = np.concatenate((spine, tips, low))
    end = start.copy()
    end[:2, 2] = -0.5
    best = end.copy()
    best[:2, 2] = THICKNESS_M
    n = pages + 2
    leaves = [(0, 1, 2 + k) for k in range(pages)]
    faces = np.array([*leaves, (n, n + 1, n + 2)])
    return Gadget(start, end, faces, best, np.arange(n + 3) >= n)


def soup(rng: np.random.Generator, n: int) -> tuple[Positions, Positions, Faces]:
    """Make n triangles without common vertices that fly through one another.

    Each starts in a cell of a lattice of its own, so that none meets another one, and its three
    corners are proposed to end anywhere within two cells around it.

    Args:
        rng: Draws everything.
        n: Number of triangles.
    """
    side = int(np.ceil(np.cbrt(n) - 1e-9))
    places = np.stack(np.unravel_index(np.arange(n), (side,) * 3), axis=1)[:, None, :]
    start = places + rng.uniform(0.05, 0.95, (n, 3, 3))
    end = places + 0.5 + rng.uniform(-2.0, 2.0, (n, 3, 3))
    faces = np.arange(3 * n, dtype=np.int32).reshape(n, 3)
    return start.reshape(-1, 3), end.reshape(-1, 3), faces


def tetrahedron(size: float = 1.0) -> tuple[Floats, Faces]:
    """Return the corners and faces of a tetrahedron.

    Args:
        size: Length of three of its edges [m].
    """
    points = size * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    return points, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32)
