"""The nonlinear problem that re-linearisation solves: pairs at their distance, as it is at x.

minimise 1/2 sum m |x - y|^2 subject to distance_j(x) >= d for the pairs of a zone, each on
the side on which it began. The zone problem freezes normals and weights; here they are
functions of x. Where the closest points are unique, the gradient of a distance is N times
the weights of the closest points: they are where it is least, so their own change does not
count. At a fixed point of re-linearisation the frozen rows are these gradients, so it has
to be a point of Karush, Kuhn and Tucker of this problem.

Source: SPEC section 6.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np


class KKT(NamedTuple):
    """How far x is from a point of Karush, Kuhn and Tucker; all relative."""

    violation: float  # largest d - distance, over d
    stationarity: float  # |M (x - y) - sum l grad|, least over l >= 0, over |M (x - y)|
    complementarity: float  # sum l |distance - d| over the objective
    multipliers: np.ndarray


def closest_weights(is_edge_edge, points):
    """Weights of the closest points of two sides, by trying every part of each side.

    For each set of corners of one side and of the other, the closest points of the flats
    they span; kept if inside both. Slow and obvious.
    """
    split = 2 if is_edge_edge else 1
    best, best_weights = np.inf, None
    for first in _parts(range(split)):
        for second in _parts(range(split, 4)):
            weights = _flat_weights(points, first, second)
            if weights is None:
                continue
            distance = np.linalg.norm(weights @ points)
            if distance < best:
                best, best_weights = distance, weights
    return best_weights


def _parts(corners):
    return [c for size in range(1, len(corners) + 1) for c in combinations(corners, size)]


def _flat_weights(points, first, second):
    """Closest points of the flats through two sets of corners, or None if outside."""
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
    """Pairs of a zone with distances that are functions of x, in numbers near 1.

    Args:
        problem: a zone problem; its normals only say on which side each pair began.
        is_edge_edge: (n_impacts,) of its pairs.
    """

    def __init__(self, problem, is_edge_edge):
        self.problem = problem
        self.is_edge_edge = is_edge_edge
        self.free = np.flatnonzero(np.isfinite(problem.masses))
        self.root = np.sqrt(problem.masses[self.free])[:, None]

    def distances(self, positions):
        """Signed distances [m] and their gradients (n_impacts, n, 3)."""
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

    def kkt(self, positions, touching=1e-6) -> KKT:
        """Residuals at positions, with the multipliers that fit best.

        Args:
            touching: pairs whose distance is above the thickness by less than this
                fraction may push.
        """
        from scipy.optimize import nnls

        d = self.problem.thickness
        distances, gradients = self.distances(positions)
        offset = (self.root * (positions - self.problem.proposed)[self.free]).ravel()
        rows = (gradients[:, self.free] / self.root).reshape(len(distances), -1)
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

    def slsqp_from(self, positions, ftol=1e-15, max_iterations=200):
        """Where SLSQP goes from positions: (n, 3), and what it says."""
        from scipy.optimize import minimize

        d = self.problem.thickness
        offset = self.root * (positions - self.problem.proposed)[self.free]
        unit = float(np.linalg.norm(offset))

        def at(z):
            x = self.problem.proposed.copy()
            x[self.free] += unit * z.reshape(-1, 3) / self.root
            return x

        def constraint(z):
            return (self.distances(at(z))[0] - d) / d

        def jacobian(z):
            gradients = self.distances(at(z))[1][:, self.free]
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
