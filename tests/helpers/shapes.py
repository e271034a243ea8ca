"""Small scenes with answers that can be worked out by hand."""

import numpy as np

import izo_ref
from izo_ref.solvers.large_zone import LargeZone
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.zones.system import problem_system


def grid(n, z=0.0, size=1.0, jitter=None):
    """(n * n, 3) positions and faces of a flat square sheet."""
    x, y = np.meshgrid(np.linspace(0.0, size, n), np.linspace(0.0, size, n), indexing="ij")
    positions = np.column_stack((x.ravel(), y.ravel(), np.full(n * n, z)))
    if jitter is not None:
        positions += jitter
    i, j = np.divmod(np.arange((n - 1) ** 2), n - 1)
    a, b, c, d = i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1
    return positions, np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))


def vertex_over_face(drop=2.0, masses=(1.0, 1.0, 1.0, 1.0), pinned=(False,) * 4, at=(0.25, 0.25)):
    """A vertex of a small triangle above falls through a larger one below.

    Vertices 0..2 are the face in z = 0, vertex 3 stands 1 above `at` and falls by `drop`;
    the triangle it belongs to reaches up and away, so nothing else meets.
    """
    start = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [*at, 1], [*at, 9], [*at, 9]], float)
    start[4:, 0] += (-0.1, 0.1)
    end = start.copy()
    end[3, 2] -= drop
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    masses = np.array([*masses, 1.0, 1.0])
    return izo_ref.Scene(start, end, faces, masses, np.array([*pinned, False, False]))


def two_sheets(rng, n=8, gap=0.05, pinned_below=False):
    """A rippled sheet driven through another one."""
    low, faces = grid(n, 0.0, jitter=0.002 * rng.normal(size=(n * n, 3)))
    high, _ = grid(n, gap, jitter=0.002 * rng.normal(size=(n * n, 3)))
    start = np.concatenate((low, high + (0.013, 0.021, 0.0)))
    end = start.copy()
    end[n * n :, 2] -= 2.0 * gap * (0.8 + 0.4 * rng.random(n * n))
    end[: n * n, 2] += 0.2 * gap * rng.random(n * n)
    pinned = np.arange(2 * n * n) < (n * n if pinned_below else 0)
    masses = 0.5 + rng.random(2 * n * n)
    return izo_ref.Scene(start, end, np.concatenate((faces, faces + n * n)), masses, pinned)


def random_problem(rng, n_impacts, mass_ratio=1.0, n_vertices=None, thickness=1e-3):
    """A zone problem of random impacts on few vertices; feasible or not."""
    k = n_vertices or max(4, int(2.2 * n_impacts**0.9) + 3)
    nodes = np.array([rng.choice(k, 4, replace=False) for _ in range(n_impacts)])
    s, r = rng.random(n_impacts), rng.random(n_impacts)
    edges = np.column_stack((1.0 - s, s, -(1.0 - r), -r))
    corners = rng.dirichlet([1.0, 1.0, 1.0], n_impacts)
    faces = np.column_stack((np.ones(n_impacts), -corners))
    weights = np.where(rng.random((n_impacts, 1)) < 0.5, edges, faces)
    normals = rng.normal(size=(n_impacts, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    proposed = 0.01 * rng.normal(size=(k, 3))
    masses = mass_ratio ** rng.random(k)
    return izo_ref.ZoneProblem(nodes, weights, normals, proposed, masses, thickness)


def large_zone(problem):
    """The `LargeZone` of a problem on its own."""
    system, _ = problem_system([problem])
    rows = scale_constraints(system)
    n = int(system.vertex_offsets[1])
    return LargeZone(rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths, n)


ONE = {
    "nodes": [[0, 1, 2, 3]],
    "weights": [[1.0, -0.5, -0.25, -0.25]],
    "normals": [[0.0, 0.0, 1.0]],
    "proposed": [[0, 0, -1.0], [0, 0, 0], [1, 0, 0], [0, 1, 0]],
    "masses": [1.0, 1.0, 2.0, 4.0],
    "thickness": 0.5,
}


def problem(**changes):
    return izo_ref.ZoneProblem(**(ONE | changes))


def opposed(gap):
    """Two rows that want the same vertices `gap` apart, and no farther than that."""
    return problem(
        nodes=ONE["nodes"] * 2,
        weights=ONE["weights"] * 2,
        normals=[[0, 0, 1.0], [0, 0, -1.0]],
        thickness=gap,
    )


def pinch(end_gap, bump=0.0):
    """A free sheet between two pinned ones that close to `end_gap`, or pass each other."""
    sheet, faces = grid(5)
    n = len(sheet)
    start = np.concatenate(
        [sheet + (0.0, 0.0, -0.1), sheet * (0.9, 0.9, 1) + (0.05, 0.04, 0.0), sheet + (0, 0, 0.1)]
    )
    end = start.copy()
    end[:n, 2] = -0.5 * end_gap
    end[2 * n :, 2] = 0.5 * end_gap
    end[n : 2 * n, 2] += bump
    pinned = np.ones(3 * n, bool)
    pinned[n : 2 * n] = False
    faces = np.concatenate([faces + k * n for k in range(3)])
    return izo_ref.Scene(start, end, faces, None, pinned)
