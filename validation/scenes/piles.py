"""Zone problems with the structure of contacts: chains, stacks of sheets, pinches.

Each is drawn where all of its impacts hold, so it is feasible. Its proposed positions violate
them.
"""

import numpy as np

from izo_ref.zones.problem import ZoneProblem
from validation.scenes.zones import THICKNESS_M, masses

APART_M = 3.0 * THICKNESS_M  # of neighbouring layers where all impacts hold


def chain_zone(rng, n_impacts, mass_ratio=1e3) -> ZoneProblem:
    """A ladder of edges, each on the next: an impact shares vertices with its neighbours only.

    Args:
        rng: `numpy.random.Generator`.
        n_impacts: at least 1.
        mass_ratio: of the heaviest vertex to the lightest.
    """
    n = n_impacts + 1
    below = 2 * np.arange(n_impacts)[:, None]
    nodes = np.hstack((below + 2, below + 3, below, below + 1))
    s, r = rng.uniform(0.1, 0.9, (2, n_impacts))
    weights = np.column_stack((1.0 - s, s, r - 1.0, -r))
    free = np.zeros((n, 2, 3))
    free[:, :, 2] = 2.0 * APART_M * np.arange(n)[:, None]
    # crossed, and meeting where the weights say; flat enough to stay above one another
    across = np.where(np.arange(n) % 2 == 0, 0.05, -0.05)
    free[:, 0, 0], free[:, 1, 0] = -0.1, 0.1
    free[:, 0, 1], free[:, 1, 1] = -across, across
    free[:, :, 2] += 0.2 * APART_M * rng.uniform(-1.0, 1.0, (n, 2))
    normals = _upward(rng, n_impacts)
    return _crushed(rng, nodes, weights, normals, free.reshape(-1, 3), mass_ratio, ())


def stack_zone(rng, n_layers, n_side, mass_ratio=1e3) -> ZoneProblem:
    """Small sheets of cloth on one another, the lowest pinned, all pressed through the floor.

    Each inner vertex of a sheet meets a face of the sheet below, and one of the sheet above.

    Args:
        rng: `numpy.random.Generator`.
        n_layers: sheets, with the pinned one; at least 2.
        n_side: vertices along a side of a sheet, at least 3.
        mass_ratio: of the heaviest vertex to the lightest.
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


def pinch_zone(rng, n_impacts, mass_ratio=1e3) -> ZoneProblem:
    """Faces above one another, a vertex between each two: opposed rows on every vertex.

    Args:
        rng: `numpy.random.Generator`.
        n_impacts: even; half as many vertices, each between two faces.
        mass_ratio: of the heaviest vertex to the lightest.
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


def _on_sheet(free, vertex_layer, face_layer, inner, n_side):
    """Vertices of one sheet against the triangles of another, over which they are."""
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
    # sheets are jittered, so a point can be a little outside: taken to the face's rim
    inside = np.clip(inside, 0.02, 0.9)
    inside /= np.maximum(inside.sum(axis=1, keepdims=True) / 0.98, 1.0)
    weights = np.column_stack((np.ones(len(inner)), inside.sum(axis=1) - 1.0, -inside))
    size = n_side * n_side
    nodes = np.column_stack((size * vertex_layer + inner, size * face_layer + face))
    sign = 1.0 if vertex_layer > face_layer else -1.0
    return nodes, weights, np.full(len(inner), sign)


def _upward(rng, n):
    """(n, 3) f8, unit, about a degree from z."""
    normals = np.column_stack((0.01 * rng.normal(size=(n, 2)), np.ones(n)))
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _crushed(rng, nodes, weights, normals, free, mass_ratio, pinned):
    """The problem that proposes `free` pressed together, with noise; pinned vertices stay."""
    pinned = np.asarray(pinned, int)
    gaps = np.einsum("jx,jk,jkx->j", normals, weights, free[nodes])
    # rows that tilt so far that they do not hold are left out
    kept = gaps >= 1.01 * THICKNESS_M
    nodes, weights, normals = nodes[kept], weights[kept], normals[kept]
    violated = False
    while not violated:
        proposed = free * (1.0, 1.0, rng.uniform(0.2, 0.5))
        proposed += 0.5 * APART_M * rng.normal(size=free.shape)
        proposed[pinned] = free[pinned]
        reached = np.einsum("jx,jk,jkx->j", normals, weights, proposed[nodes])
        violated = (reached < THICKNESS_M).any()
    weight = masses(rng, len(free), mass_ratio)
    weight[pinned] = np.inf
    return ZoneProblem(nodes, weights, normals, proposed, weight, THICKNESS_M)
