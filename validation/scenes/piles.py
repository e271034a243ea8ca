"""Zone problems with the structure of real contacts: chains, stacks of sheets, pinches.

Each problem is drawn at positions where all of its constraints hold, so it is feasible. Its
proposed positions violate a constraint.
"""

from collections.abc import Iterable

import numpy as np

from izo_ref.base.arrays import AnyInts, Floats, Normals, Positions, Weights
from izo_ref.zones.problem import ZoneProblem
from validation.scenes.zones import THICKNESS_M, masses

APART_M = 3.0 * THICKNESS_M  # distance of neighbouring layers where all constraints hold


def chain_zone(rng: np.random.Generator, n_impacts: int, mass_ratio: float = 1e3) -> ZoneProblem:
    """Draw a ladder of edges, in which an impact shares vertices only with its two neighbours.

    Args:
        rng: Draws everything.
        n_impacts: Number of impacts, at least 1.
        mass_ratio: Mass of the heaviest vertex over that of the lightest.

    Returns:
        The problem, without pinned vertices.
    """
    n = n_impacts + 1
    below = 2 * np.arange(n_impacts)[:, None]
    nodes = np.hstack((below + 2, below + 3, below, below + 1))
    s, r = rng.uniform(0.1, 0.9, (2, n_impacts))
    weights = np.column_stack((1.0 - s, s, r - 1.0, -r))
    free = np.zeros((n, 2, 3))
    free[:, :, 2] = 2.0 * APART_M * np.arange(n)[:, None]
    # neighbouring edges cross where the weights say, and are flat enough to stay in order
    across = np.where(np.arange(n) % 2 == 0, 0.05, -0.05)
    free[:, 0, 0], free[:, 1, 0] = -0.1, 0.1
    free[:, 0, 1], free[:, 1, 1] = -across, across
    free[:, :, 2] += 0.2 * APART_M * rng.uniform(-1.0, 1.0, (n, 2))
    normals = _upward(rng, n_impacts)
    return _crushed(rng, nodes, weights, normals, free.reshape(-1, 3), mass_ratio, ())


def stack_zone(
    rng: np.random.Generator, n_layers: int, n_side: int, mass_ratio: float = 1e3
) -> ZoneProblem:
    """Draw small sheets of cloth that lie on one another and are pressed onto a pinned one.

    Each inner vertex of a sheet meets a face of the sheet below and a face of the sheet above.

    Args:
        rng: Draws everything.
        n_layers: Number of sheets with the lowest one, which is pinned; at least 2.
        n_side: Vertices along a side of a sheet, at least 3.
        mass_ratio: Mass of the heaviest vertex over that of the lightest.

    Returns:
        The problem.
    """
    size = n_side * n_side
    x, y = np.meshgrid(np.arange(n_side), np.arange(n_side), indexing="ij")
    grid = 0.01 * np.column_stack((x.ravel(), y.ravel())).astype(float)
    free = np.empty((n_layers, size, 3))
    for layer in range(n_layers):
        free[layer, :, :2] = grid + 0.002 * rng.uniform(-1.0, 1.0, (size, 2))
        free[layer, :, 2] = APART_M * (layer + 0.2 * rng.uniform(-1.0, 1.0, size))
    inner = (n_side * x[1:-1, 1:-1] + y[1:-1, 1:-1]).ravel()
    parts = [
        _on_sheet(free, vertex_layer, face_layer, inner, n_side)
        for low in range(n_layers - 1)
        for vertex_layer, face_layer in ((low + 1, low), (low, low + 1))
    ]
    nodes, weights, signs = (np.concatenate(column) for column in zip(*parts, strict=True))
    normals = _upward(rng, len(nodes)) * signs[:, None]
    return _crushed(rng, nodes, weights, normals, free.reshape(-1, 3), mass_ratio, range(size))


def pinch_zone(rng: np.random.Generator, n_impacts: int, mass_ratio: float = 1e3) -> ZoneProblem:
    """Draw faces above one another with a vertex between each two of them.

    Each such vertex has two opposed constraints, one from the face below and one from that above.

    Args:
        rng: Draws everything.
        n_impacts: Number of impacts, even; half as many vertices are between two faces.
        mass_ratio: Mass of the heaviest vertex over that of the lightest.

    Returns:
        The problem, without pinned vertices.
    """
    n = n_impacts // 2
    corners = np.array([[-0.05, -0.03, 0.0], [0.05, -0.03, 0.0], [0.0, 0.06, 0.0]])
    faces = np.repeat(corners[None], n + 1, axis=0)
    faces[:, :, 2] = 2.0 * APART_M * np.arange(n + 1)[:, None]
    tips = np.zeros((n, 3))
    tips[:, 2] = 2.0 * APART_M * (np.arange(n) + 0.5)
    free = np.concatenate((faces.reshape(-1, 3), tips))
    free[:, 2] += 0.2 * APART_M * rng.uniform(-1.0, 1.0, len(free))
    tip = 3 * (n + 1) + np.arange(n)
    face = 3 * np.arange(n + 1)[:, None] + np.arange(3)
    nodes = np.concatenate((np.column_stack((tip, face[:-1])), np.column_stack((tip, face[1:]))))
    inside = rng.dirichlet([3.0, 3.0, 3.0], n)
    weights = np.tile(np.column_stack((np.ones(n), -inside)), (2, 1))
    normals = np.tile(_upward(rng, n), (2, 1))
    normals[n:] *= -1.0
    return _crushed(rng, nodes, weights, normals, free, mass_ratio, ())


def _on_sheet(
    free: Floats, vertex_layer: int, face_layer: int, inner: AnyInts, n_side: int
) -> tuple[AnyInts, Weights, Floats]:
    """Pair the vertices of one sheet with the triangles of another that they are above or below.

    Args:
        free: (n_layers, n_side^2, 3) f8 [m], positions of all sheets.
        vertex_layer: Sheet of the vertices.
        face_layer: Sheet of the triangles.
        inner: (k,) int, the vertices, numbered within their sheet.
        n_side: Vertices along a side of a sheet.

    Returns:
        (k, 4) int, nodes; (k, 4) f8, weights; (k,) f8, 1 where the vertex is above, else -1.
    """
    points = free[vertex_layer, inner, :2]
    corner = np.clip((points / 0.01).astype(int), 0, n_side - 2)
    first = n_side * corner[:, 0] + corner[:, 1]
    upper = (points / 0.01 - corner).sum(axis=1) > 1.0
    low = np.column_stack((first, first + n_side, first + 1))
    high = np.column_stack((first + n_side + 1, first + 1, first + n_side))
    face = np.where(upper[:, None], high, low)
    a, b, c = free[face_layer][face][:, :, :2].transpose(1, 0, 2)
    edges = np.stack((b - a, c - a), axis=2)
    inside = np.linalg.solve(edges, (points - a)[:, :, None])[:, :, 0]
    # sheets are jittered, so a point can be a little outside; then it is taken to the face's rim
    inside = np.clip(inside, 0.02, 0.9)
    inside /= np.maximum(inside.sum(axis=1, keepdims=True) / 0.98, 1.0)
    weights = np.column_stack((np.ones(len(inner)), inside.sum(axis=1) - 1.0, -inside))
    size = n_side * n_side
    nodes = np.column_stack((size * vertex_layer + inner, size * face_layer + face))
    sign = 1.0 if vertex_layer > face_layer else -1.0
    return nodes, weights, np.full(len(inner), sign)


def _upward(rng: np.random.Generator, n: int) -> Normals:
    """Draw (n, 3) f8 unit vectors about a degree from the z axis."""
    normals = np.column_stack((0.01 * rng.normal(size=(n, 2)), np.ones(n)))
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _crushed(
    rng: np.random.Generator,
    nodes: AnyInts,
    weights: Weights,
    normals: Normals,
    free: Positions,
    mass_ratio: float,
    pinned: Iterable[int],
) -> ZoneProblem:
    """Make a problem whose proposed positions are pressed together along z, with noise.

    Args:
        rng: Draws the proposed positions and the masses.
        nodes: (k, 4) int.
        weights: (k, 4) f8.
        normals: (k, 3) f8.
        free: (n, 3) f8 [m], positions at which the constraints hold.
        mass_ratio: Mass of the heaviest vertex over that of the lightest.
        pinned: Pinned vertices; they stay where they are.
    """
    pinned = np.asarray(pinned, int)
    gaps = np.einsum("jx,jk,jkx->j", normals, weights, free[nodes])
    # constraints whose normals tilt so far that they do not hold are left out
    kept = gaps >= 1.01 * THICKNESS_M
    nodes, weights, normals = nodes[kept], weights[kept], normals[kept]
    while True:
        proposed = free * (1.0, 1.0, rng.uniform(0.2, 0.5))
        proposed += 0.5 * APART_M * rng.normal(size=free.shape)
        proposed[pinned] = free[pinned]
        reached = np.einsum("jx,jk,jkx->j", normals, weights, proposed[nodes])
        if (reached < THICKNESS_M).any():
            break
    weight = masses(rng, len(free), mass_ratio)
    weight[pinned] = np.inf
    return ZoneProblem(nodes, weights, normals, proposed, weight, THICKNESS_M)
