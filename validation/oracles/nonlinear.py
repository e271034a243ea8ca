"""The nonlinear problem of a zone, in which gaps are true distances at x instead of frozen gaps.

Question: is a point x a solution of the nonlinear problem, to first order?

The problem: minimise 1/2 sum m |x - y|^2 subject to distance_j(x) >= d for the pairs of a zone,
each pair on the side on which it began. The zone problem freezes normals and weights; here both
are functions of x. Where the closest points of a pair are unique, the gradient of the distance is
the normal N times the weights of the closest points. Moving the closest points along their elements
does not change the distance to first order, because it is minimal there. At a fixed point of
re-linearisation the frozen
constraints have exactly these gradients, so the fixed point must satisfy the conditions of Karush,
Kuhn and Tucker (KKT) of this problem.

Method: the distances are found by trying all sets of corners. SciPy's non-negative least squares
finds the multipliers that fit best. SciPy's SLSQP finds a solution near x.

Independent of `izo_ref`: nothing of the package is used but the arrays of the problem.

Limits: the gradient of a distance exists only where the closest points are unique and the distance
is not zero. The problem is not convex, so a KKT point need not be the global optimum.

Source: docs/method section 6.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from validation.oracles.answer import Flags, Floats, ZoneArrays


class KKT(NamedTuple):
    """How far x is from a point of Karush, Kuhn and Tucker; all numbers are relative."""

    violation: float  # largest d - distance, over d
    stationarity: float  # |M (x - y) - sum l grad|, least over l >= 0, over |M (x - y)|
    complementarity: float  # sum l |distance - d| over the objective
    multipliers: Floats  # (n_impacts,) f8 [kg], those that fit best


def closest_weights(is_edge_edge: bool, points: Floats) -> Floats:
    """Compute the weights of the closest points of the two sides of a pair.

    For each set of corners of one side and each set of the other, take the flats that they span
    and the closest points of these two flats. Keep them if both are inside their sets. The closest
    of all that are kept are the answer. This is slow and obvious.

    Args:
        is_edge_edge: Whether the points are the ends of two edges; otherwise they are a vertex and
            the corners of a face.
        points: (4, 3) f8 [m].

    Returns:
        (4,) f8, positive on the first side and negative on the second, with a sum of zero.
    """
    split = 2 if is_edge_edge else 1
    best, best_weights = np.inf, np.full(4, np.nan)
    for first in _subsets(range(split)):
        for second in _subsets(range(split, 4)):
            weights = _flat_weights(points, first, second)
            if weights is None:
                continue
            distance = np.linalg.norm(weights @ points)
            if distance < best:
                best, best_weights = distance, weights
    return best_weights


def _subsets(corners: Sequence[int]) -> list[tuple[int, ...]]:
    """Return all subsets of some corners but the empty one."""
    return [c for size in range(1, len(corners) + 1) for c in combinations(corners, size)]


def _flat_weights(points: Floats, first: tuple[int, ...], second: tuple[int, ...]) -> Floats | None:
    """Compute the closest points of the flats through two sets of corners.

    Args:
        points: (4, 3) f8 [m].
        first: Corners of the first side.
        second: Corners of the second side.

    Returns:
        (4,) f8, weights; None if one of the closest points is outside its set.
    """
    a, b = points[list(first)], points[list(second)]
    sides = np.vstack((a[1:] - a[0], -(b[1:] - b[0]))) if len(a) + len(b) > 2 else np.empty((0, 3))
    gap = a[0] - b[0]
    steps = np.linalg.lstsq(sides.T, -gap, rcond=None)[0] if len(sides) else np.empty(0)
    s, r = steps[: len(a) - 1], steps[len(a) - 1 :]
    on_first, on_second = np.append(1.0 - s.sum(), s), np.append(1.0 - r.sum(), r)
    if min(on_first.min(), on_second.min()) < 0.0:
        return None
    weights = np.zeros(4)
    weights[list(first)] = on_first
    weights[list(second)] = -on_second
    return weights


class NonlinearZone:
    """The pairs of a zone with distances that are functions of x, in numbers near 1.

    Args:
        problem: A zone problem; its normals only say on which side each pair began.
        is_edge_edge: (n_impacts,) b1, kind of each pair.
    """

    def __init__(self, problem: ZoneArrays, is_edge_edge: Flags) -> None:
        """Keep the problem, and the square roots of its masses."""
        self.problem = problem
        self.is_edge_edge = is_edge_edge
        self.unpinned = np.flatnonzero(np.isfinite(problem.masses))
        self.root = np.sqrt(problem.masses[self.unpinned])[:, None]

    def distances(self, positions: Floats) -> tuple[Floats, Floats]:
        """Compute signed distances and their gradients.

        Args:
            positions: (n, 3) f8 [m].

        Returns:
            (n_impacts,) f8 [m], and (n_impacts, n, 3) f8.
        """
        distances, gradients = [], np.zeros((len(self.is_edge_edge), len(positions), 3))
        for j, nodes in enumerate(self.problem.nodes):
            points = positions[nodes]
            weights = closest_weights(self.is_edge_edge[j], points)
            vector = weights @ points
            side = 1.0 if vector @ self.problem.normals[j] >= 0.0 else -1.0
            distances.append(side * np.linalg.norm(vector))
            normal = side * vector / np.linalg.norm(vector)
            np.add.at(gradients[j], nodes, weights[:, None] * normal)
        return np.array(distances), gradients

    def kkt(self, positions: Floats, touching: float = 1e-6) -> KKT:
        """Compute the KKT residuals at positions, with the multipliers that fit best.

        Args:
            positions: (n, 3) f8 [m].
            touching: Pairs may have a multiplier if their distance exceeds the thickness by at
                most this fraction of it.

        Returns:
            The residuals and the multipliers.
        """
        from scipy.optimize import nnls

        d = self.problem.thickness
        distances, gradients = self.distances(positions)
        offset = (self.root * (positions - self.problem.proposed)[self.unpinned]).ravel()
        rows = (gradients[:, self.unpinned] / self.root).reshape(len(distances), -1)
        near = np.flatnonzero(distances <= (1.0 + touching) * d)
        multipliers = np.zeros(len(distances))
        size = float(np.linalg.norm(offset))
        if len(near):
            multipliers[near] = nnls(rows[near].T / size, offset / size)[0]
        residual = float(np.linalg.norm(offset - multipliers @ rows))
        products = float(multipliers @ np.abs(distances - d))
        return KKT(
            max(0.0, float(np.max(d - distances))) / d,
            residual / size,
            products / (0.5 * size**2),
            multipliers,
        )

    def slsqp_from(
        self, positions: Floats, ftol: float = 1e-15, max_iterations: int = 200
    ) -> tuple[Floats, str]:
        """Solve the nonlinear problem by SLSQP, started at positions.

        Args:
            positions: (n, 3) f8 [m].
            ftol: Tolerance of SLSQP for the objective.
            max_iterations: Limit of iterations.

        Returns:
            (n, 3) f8 [m], where SLSQP ended, and its message.
        """
        from scipy.optimize import minimize

        d = self.problem.thickness
        offset = self.root * (positions - self.problem.proposed)[self.unpinned]
        unit = float(np.linalg.norm(offset))

        def at(z: Floats) -> Floats:
            x = self.problem.proposed.copy()
            x[self.unpinned] += unit * z.reshape(-1, 3) / self.root
            return x

        def constraint(z: Floats) -> Floats:
            return (self.distances(at(z))[0] - d) / d

        def jacobian(z: Floats) -> Floats:
            gradients = self.distances(at(z))[1][:, self.unpinned]
            return (unit / d * gradients / self.root).reshape(len(self.is_edge_edge), -1)

        found = minimize(
            lambda z: 0.5 * float(z @ z),
            (offset / unit).ravel(),
            jac=lambda z: z,
            method="SLSQP",
            constraints={"type": "ineq", "fun": constraint, "jac": jacobian},
            options={"ftol": ftol, "maxiter": max_iterations},
        )
        return at(found.x), found.message
