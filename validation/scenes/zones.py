"""Random zone problems that have a solution, with rows that make solvers fail."""

import numpy as np

from izo_ref.zones.problem import ZoneProblem

THICKNESS_M = 1e-3


def random_zone(rng, n_impacts, mass_ratio=1.0, fresh_only=False) -> ZoneProblem:
    """A feasible zone of vertex-face and edge-edge impacts.

    All impacts hold, by a margin, at positions drawn first, so the problem is feasible; the
    proposed positions are others near by. Beside fresh rows there are, one in six each:
    duplicates; redundant rows, between the same nodes and nearly parallel to another or
    farther along it; and opposed rows, which push a vertex of another row back.

    Args:
        rng: `numpy.random.Generator`.
        n_impacts: at least 1.
        mass_ratio: of the heaviest vertex to the lightest, at most.
        fresh_only: leave out duplicates, redundant and opposed rows.
    """
    n = max(4, int(0.8 * n_impacts) + 3)
    free = 0.02 * rng.normal(size=(n, 3))  # where all impacts hold
    nodes, weights, normals = [], [], []
    while len(nodes) < n_impacts:
        kind = rng.integers(6) if nodes and not fresh_only else 5
        other = rng.integers(len(nodes)) if nodes else 0
        if kind == 0:
            row = nodes[other], weights[other], normals[other]
        elif kind == 1:  # nearly the same, to the last digits or to some
            normal = normals[other] + 10.0 ** rng.uniform(-12, -1) * rng.normal(size=3)
            row = nodes[other], weights[other], normal
        elif kind == 2:
            chosen = rng.choice(np.setdiff1d(np.arange(n), nodes[other][:1]), 3, replace=False)
            row = np.append(nodes[other][:1], chosen), _weights(rng), -normals[other]
        else:
            row = rng.choice(n, 4, replace=False), _weights(rng), rng.normal(size=3)
        node, weight, normal = row
        normal = normal / np.linalg.norm(normal)
        gap = normal @ (weight @ free[node])
        if kind >= 3 and gap < 0.0:
            normal, gap = -normal, -gap
        if gap >= 1.01 * THICKNESS_M:
            nodes.append(node)
            weights.append(weight)
            normals.append(normal)
    nodes, weights, normals = np.array(nodes), np.array(weights), np.array(normals)
    # mirrored, which violates all, and moved about: about half of the rows end active
    violated = False
    while not violated:
        proposed = 0.01 * rng.normal(size=(n, 3)) - rng.uniform(0.5, 2.0) * free
        points = np.einsum("jk,jkx->jx", weights, proposed[nodes])
        violated = (np.einsum("jx,jx->j", normals, points) < THICKNESS_M).any()
    return ZoneProblem(nodes, weights, normals, proposed, masses(rng, n, mass_ratio), THICKNESS_M)


def masses(rng, n, ratio):
    """(n,) f8 [kg], drawn over all decades up to the ratio, with both ends present."""
    exponents = rng.random(n)
    exponents[rng.permutation(n)[:2]] = 0.0, 1.0
    return ratio**exponents


def _weights(rng):
    if rng.random() < 0.5:
        a, b, c = rng.dirichlet([1.0, 1.0, 1.0])
        return np.array([1.0, -a, -b, -c])
    s, r = rng.random(2)
    return np.array([1.0 - s, s, -(1.0 - r), -r])
