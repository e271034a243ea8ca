"""Random zone problems that have a solution, with constraints that make solvers fail."""

import numpy as np

from izo_ref.base.arrays import Floats, Masses
from izo_ref.zones.problem import ZoneProblem

THICKNESS_M = 1e-3


def random_zone(
    rng: np.random.Generator, n_impacts: int, mass_ratio: float = 1.0, fresh_only: bool = False
) -> ZoneProblem:
    """Draw a feasible zone of vertex-face and edge-edge impacts.

    Positions are drawn first, and all constraints hold there by a margin, so the problem is
    feasible. The proposed positions are others near by. The constraints are fresh ones and, one in
    six each: duplicates; redundant ones, between the same nodes and nearly parallel to another
    constraint or farther along it; and opposed ones, which push a vertex of another constraint
    back.

    Args:
        rng: Draws everything.
        n_impacts: Number of impacts, at least 1.
        mass_ratio: Mass of the heaviest vertex over that of the lightest.
        fresh_only: Leave out duplicate, redundant and opposed constraints.

    Returns:
        The problem, without pinned vertices; its proposed positions violate a constraint.
    """
    n = max(4, int(0.8 * n_impacts) + 3)
    free = 0.02 * rng.normal(size=(n, 3))  # all constraints hold here
    nodes, weights, normals = [], [], []
    while len(nodes) < n_impacts:
        kind = rng.integers(6) if nodes and not fresh_only else 5
        other = rng.integers(len(nodes)) if nodes else 0
        if kind == 0:
            row = nodes[other], weights[other], normals[other]
        elif kind == 1:  # nearly parallel: equal to the last digits, or to the first ones
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
    # the proposed positions are mirrored, which violates all constraints, and moved at random;
    # about half of the constraints are active at the optimum
    while True:
        proposed = 0.01 * rng.normal(size=(n, 3)) - rng.uniform(0.5, 2.0) * free
        points = np.einsum("jk,jkx->jx", weights, proposed[nodes])
        if (np.einsum("jx,jx->j", normals, points) < THICKNESS_M).any():
            break
    return ZoneProblem(nodes, weights, normals, proposed, masses(rng, n, mass_ratio), THICKNESS_M)


def masses(rng: np.random.Generator, n: int, ratio: float) -> Masses:
    """Draw masses over all decades from 1 kg to the ratio; both ends occur.

    Args:
        rng: Draws the masses.
        n: Number of masses, at least 2.
        ratio: The largest mass over the smallest.

    Returns:
        (n,) f8 [kg].
    """
    exponents = rng.random(n)
    exponents[rng.permutation(n)[:2]] = 0.0, 1.0
    return ratio**exponents


def _weights(rng: np.random.Generator) -> Floats:
    """Draw (4,) f8 weights of a vertex and a face, or of two edges."""
    if rng.random() < 0.5:
        a, b, c = rng.dirichlet([1.0, 1.0, 1.0])
        return np.array([1.0, -a, -b, -c])
    s, r = rng.random(2)
    return np.array([1.0 - s, s, -(1.0 - r), -r])
