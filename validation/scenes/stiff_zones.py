"""Zones whose constraints are nearly dependent, opposed, copied, or act through a small weight."""

import numpy as np

from izo_ref.base.arrays import Floats, Normals
from izo_ref.zones.problem import ZoneProblem
from validation.scenes.zones import THICKNESS_M, masses

SIZE_M = 0.02  # of the faces
DEPTH_M = 0.01  # how far the proposed positions are pushed, with multipliers from 0.5 to 2


def wedge_zone(rng: np.random.Generator, angle: float, mass_ratio: float = 1.0) -> ZoneProblem:
    """Draw a vertex that two half-spaces push out of a face, with normals at an angle.

    Both constraints push at the optimum, which is on the edge where the two planes meet. With equal
    masses, and for a small angle, the condition number is (2 / angle)^2.

    Args:
        rng: Draws everything.
        angle: Between the normals [rad].
        mass_ratio: Mass of the heaviest vertex over that of the lightest.

    Returns:
        The problem, of 2 impacts on the same four vertices.
    """
    frame = _frame(rng)
    turned = np.cos(angle) * frame[0] + np.sin(angle) * frame[1]
    return _pushed_into(rng, np.array([frame[0], turned]), mass_ratio)


def cone_zone(
    rng: np.random.Generator, angle: float, n_impacts: int, mass_ratio: float = 1.0
) -> ZoneProblem:
    """Draw a vertex that many half-spaces push out of a face, with normals around an axis.

    All planes go through one point, and all constraints push at the optimum. So their matrix has
    rank 3 at most, and its condition number grows with 1 / angle^2.

    Args:
        rng: Draws everything.
        angle: Between each normal and the axis [rad].
        n_impacts: Number of half-spaces.
        mass_ratio: Mass of the heaviest vertex over that of the lightest.

    Returns:
        The problem, of `n_impacts` impacts on the same four vertices.
    """
    frame, around = _frame(rng), rng.uniform(0.0, 2.0 * np.pi, n_impacts)[:, None]
    aside = np.cos(around) * frame[1] + np.sin(around) * frame[2]
    normals = np.cos(angle) * frame[0] + np.sin(angle) * aside
    return _pushed_into(rng, normals, mass_ratio)


def slab_zone(rng: np.random.Generator, width: float, mass_of_walls: float = np.inf) -> ZoneProblem:
    """Draw a vertex between two parallel faces that push it toward each other.

    Args:
        rng: Draws everything.
        width: Room that is left for the vertex, over the thickness; negative if there is none.
        mass_of_walls: Mass of each vertex of the faces, over that of the vertex; infinite for
            pinned faces, where a negative width has no solution.

    Returns:
        The problem, of 2 impacts on 7 vertices.
    """
    corners = rng.dirichlet([3.0, 3.0, 3.0], 2)
    proposed = rng.uniform(-SIZE_M, SIZE_M, (7, 3))
    proposed[:, 2] = 0.0
    proposed[4:, 2] = (2.0 + width) * THICKNESS_M
    proposed[0, 2] = -0.4 * THICKNESS_M
    return ZoneProblem(
        [[0, 1, 2, 3], [0, 4, 5, 6]],
        np.column_stack(([1.0, 1.0], -corners)),
        [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]],
        proposed,
        [1.0, *[mass_of_walls] * 6],
        THICKNESS_M,
    )


def copied_zone(rng: np.random.Generator, problem: ZoneProblem, copies: int) -> ZoneProblem:
    """Return a problem with each impact many times over, in a random order.

    Args:
        rng: Draws the order.
        problem: The problem; its optimum is that of the one that is returned.
        copies: How many times each impact occurs.
    """
    order = rng.permutation(np.repeat(np.arange(len(problem.nodes)), copies))
    return ZoneProblem(
        problem.nodes[order],
        problem.weights[order],
        problem.normals[order],
        problem.proposed,
        problem.masses,
        problem.thickness,
    )


def lever_zone(rng: np.random.Generator, weight: float, pinned: bool) -> ZoneProblem:
    """Draw a vertex at a face, whose first corner has a small weight.

    Args:
        rng: Draws everything.
        weight: Weight of the first corner, from 0 to 1.
        pinned: Whether all other vertices are pinned. Then the first corner alone has to move, by
            the depth over the weight; with a weight of 0 there is no solution.

    Returns:
        The problem, of one impact.
    """
    normal = _frame(rng)[0]
    proposed = SIZE_M * rng.normal(size=(4, 3))
    weights = np.array([1.0, -weight, -0.5 * (1.0 - weight), -0.5 * (1.0 - weight)])
    proposed[0] -= (weights @ proposed @ normal + 0.4 * THICKNESS_M) * normal
    weight_kg = [np.inf, 1.0, np.inf, np.inf] if pinned else [1.0] * 4
    return ZoneProblem([[0, 1, 2, 3]], [weights], [normal], proposed, weight_kg, THICKNESS_M)


def edge_zone(rng: np.random.Generator, place: float, mass_ratio: float = 1.0) -> ZoneProblem:
    """Draw two edges that cross near an end of each.

    Args:
        rng: Draws everything.
        place: Where they cross, as a fraction of the length of each, from its first vertex.
        mass_ratio: Mass of the heaviest vertex over that of the lightest.

    Returns:
        The problem, of one impact.
    """
    normal = _frame(rng)[0]
    proposed = SIZE_M * rng.normal(size=(4, 3))
    weights = np.array([1.0 - place, place, place - 1.0, -place])
    proposed[:2] -= (weights @ proposed @ normal + 0.4 * THICKNESS_M) * normal
    own = masses(rng, 4, mass_ratio)
    return ZoneProblem([[0, 1, 2, 3]], [weights], [normal], proposed, own, THICKNESS_M)


def _frame(rng: np.random.Generator) -> Floats:
    """Draw three orthogonal unit vectors, (3, 3) f8."""
    return np.linalg.qr(rng.normal(size=(3, 3)))[0]


def _pushed_into(rng: np.random.Generator, normals: Normals, mass_ratio: float) -> ZoneProblem:
    """Return a vertex at a face, pushed into planes that have a point in common.

    The proposed positions are those where every constraint holds with equality, less what positive
    multipliers move. So all constraints push at the optimum, up to rounding.
    """
    n, corners = len(normals), rng.dirichlet([3.0, 3.0, 3.0])
    weights = np.array([1.0, *-corners])
    touching = np.zeros((4, 3))
    touching[1:] = SIZE_M * rng.normal(size=(3, 3))
    axis = normals.sum(axis=0)
    axis /= np.linalg.norm(axis)
    touching[0] = corners @ touching[1:] + THICKNESS_M / (normals @ axis).mean() * axis
    own = masses(rng, 4, mass_ratio)
    push = (rng.uniform(0.5, 2.0, n) / n) @ normals
    moves = weights[:, None] / own[:, None] * push
    proposed = touching - DEPTH_M / np.abs(moves).max() * moves
    return ZoneProblem(
        np.tile(np.arange(4), (n, 1)), np.tile(weights, (n, 1)), normals, proposed, own, THICKNESS_M
    )
