"""Small scenes and zones, most of them with answers that can be worked out by hand."""

import numpy as np

import izo_ref
from izo_ref.solvers.scaled_constraints import LargeZone, scale_constraints
from izo_ref.zones.system import problem_system


def grid(n, z=0.0, size=1.0, jitter=None):
    """Return positions and faces of a flat square sheet of n x n vertices.

    Args:
        n: vertices along a side.
        z: height of the sheet [m].
        size: length of a side [m].
        jitter: (n * n, 3) added to the positions [m], or None.

    Returns:
        positions (n * n, 3) f8 [m] and faces (2 (n - 1)^2, 3).
    """
    x, y = np.meshgrid(np.linspace(0.0, size, n), np.linspace(0.0, size, n), indexing="ij")
    positions = np.column_stack((x.ravel(), y.ravel(), np.full(n * n, z)))
    if jitter is not None:
        positions += jitter
    i, j = np.divmod(np.arange((n - 1) ** 2), n - 1)
    a, b, c, d = i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1
    return positions, np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))


def vertex_over_face(drop=2.0, masses=(1.0, 1.0, 1.0, 1.0), pinned=(False,) * 4, at=(0.25, 0.25)):
    """Return a scene in which one vertex falls onto a face, and nothing else can meet.

    Vertices 0..2 are the face, in the plane z = 0. Vertex 3 starts 1 m above the point `at`
    and falls by `drop`. The triangle that vertex 3 belongs to reaches far up, so its edges
    meet nothing.

    Args:
        drop: length of the fall [m].
        masses: of the vertices 0..3 [kg].
        pinned: flags of the vertices 0..3.
        at: x and y of vertex 3 [m].
    """
    start = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [*at, 1], [*at, 9], [*at, 9]], float)
    start[4:, 0] += (-0.1, 0.1)
    end = start.copy()
    end[3, 2] -= drop
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    masses = np.array([*masses, 1.0, 1.0])
    return izo_ref.Scene(start, end, faces, masses, np.array([*pinned, False, False]))


def two_sheets(rng, n=8, gap=0.05, pinned_below=False):
    """Return a scene in which a rippled sheet is driven through another one.

    Args:
        rng: draws the ripples, the path and the masses.
        n: vertices along a side.
        gap: distance of the sheets at the start [m].
        pinned_below: whether all vertices of the lower sheet are pinned.
    """
    low, faces = grid(n, 0.0, jitter=0.002 * rng.normal(size=(n * n, 3)))
    high, _ = grid(n, gap, jitter=0.002 * rng.normal(size=(n * n, 3)))
    start = np.concatenate((low, high + (0.013, 0.021, 0.0)))
    end = start.copy()
    end[n * n :, 2] -= 2.0 * gap * (0.8 + 0.4 * rng.random(n * n))
    end[: n * n, 2] += 0.2 * gap * rng.random(n * n)
    pinned = np.arange(2 * n * n) < (n * n if pinned_below else 0)
    masses = 0.5 + rng.random(2 * n * n)
    return izo_ref.Scene(start, end, np.concatenate((faces, faces + n * n)), masses, pinned)


def falling_sheet(n_layers, depth, n=4, gap=0.05, rotation=None):
    """Return a scene in which the uppermost of some equal sheets falls through all others.

    Args:
        n_layers: number of sheets, each above the next one.
        depth: length of the fall [m].
        n: vertices along a side.
        gap: distance of neighbouring sheets [m].
        rotation: (3, 3) rotation of the whole scene, or None.
    """
    sheets = [grid(n, -gap * layer) for layer in range(n_layers)]
    start = np.concatenate([positions for positions, _ in sheets])
    faces = np.concatenate([faces + n * n * k for k, (_, faces) in enumerate(sheets)])
    end = start.copy()
    end[: n * n, 2] -= depth
    if rotation is not None:
        start, end = start @ rotation.T, end @ rotation.T
    return izo_ref.Scene(start, end, faces)


def random_problem(rng, n_impacts, mass_ratio=1.0, n_vertices=None, thickness=1e-3):
    """Return a zone problem of random impacts on few vertices, which may be infeasible.

    Args:
        rng: draws everything.
        n_impacts: number of impacts.
        mass_ratio: of the largest possible mass to the smallest.
        n_vertices: number of vertices; if None, about two for each impact.
        thickness: [m].
    """
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
    """Return the `LargeZone` of one zone problem."""
    system, _ = problem_system([problem])
    rows = scale_constraints(system)
    n = int(system.vertex_offsets[1])
    return LargeZone(rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths, n)


# One impact: vertex 0 is 1 m below its face and has to end 0.5 m above it.
ONE_IMPACT = {
    "nodes": [[0, 1, 2, 3]],
    "weights": [[1.0, -0.5, -0.25, -0.25]],
    "normals": [[0.0, 0.0, 1.0]],
    "proposed": [[0, 0, -1.0], [0, 0, 0], [1, 0, 0], [0, 1, 0]],
    "masses": [1.0, 1.0, 2.0, 4.0],
    "thickness": 0.5,
}


def one_impact_problem(**changes):
    """Return the zone problem of `ONE_IMPACT`, with some of its arguments replaced."""
    return izo_ref.ZoneProblem(**(ONE_IMPACT | changes))


def opposed_problem(gap):
    """Return an infeasible zone of two impacts with opposite normals.

    The first asks for a signed gap of at least `gap`, the second for one of at most -`gap`.
    """
    return one_impact_problem(
        nodes=ONE_IMPACT["nodes"] * 2,
        weights=ONE_IMPACT["weights"] * 2,
        normals=[[0, 0, 1.0], [0, 0, -1.0]],
        thickness=gap,
    )


def pinched_sheet(end_gap, bump=0.0, side=5):
    """Return a scene of an unpinned sheet between two pinned ones that approach each other.

    Args:
        end_gap: distance of the pinned sheets at the end [m]; if negative, they pass each other.
        bump: proposed displacement of the sheet between them, upwards [m].
        side: vertices along a side of each sheet.
    """
    sheet, faces = grid(side)
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
