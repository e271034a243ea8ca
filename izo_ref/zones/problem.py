"""The zone problem, its solution, and the residuals that judge every solver."""

import math
from typing import NamedTuple

import numpy as np

from izo_ref.base import checks


class ZoneProblem:
    """Minimise 1/2 sum_i m_i |x_i - y_i|^2 subject to N_j . sum_k a_jk x[nodes_jk] >= d.

    Args:
        nodes: (n_impacts, 4) indices into proposed.
        weights: (n_impacts, 4), a.
        normals: (n_impacts, 3), N.
        proposed: (n, 3) [m], the proposed positions y.
        masses: (n,) [kg], m > 0; infinite for a pinned vertex, which stays at its target.
        thickness: [m], d > 0.

    Raises:
        ShapeError, NonFiniteError, IndexRangeError, MassError, ThicknessError.

    Source: SPEC sections 1 and 5.
    """

    def __init__(self, nodes, weights, normals, proposed, masses, thickness):
        self.proposed = checks.floats("proposed", proposed, (None, 3))
        k = len(self.proposed)
        self.nodes = checks.indices("nodes", nodes, 4, k)
        n = len(self.nodes)
        self.weights = checks.floats("weights", weights, (n, 4))
        self.normals = checks.floats("normals", normals, (n, 3))
        self.masses = checks.masses(masses, k, infinite_allowed=True)
        self.thickness = checks.thickness(thickness)

    @property
    def inverse_sqrt_masses(self):
        """(n,) f8 [kg^-1/2], 0 for pinned vertices."""
        return 1.0 / np.sqrt(self.masses)

    def gaps(self, positions):
        """(n_impacts,) f8 [m], frozen gap less the thickness; negative is a violation."""
        # relative to the first node: weights sum to zero, and far off less is rounded away
        relative = positions[self.nodes] - positions[self.nodes[:, :1]]
        points = np.einsum("jk,jkx->jx", self.weights, relative)
        return np.einsum("jx,jx->j", self.normals, points) - self.thickness

    def pull(self, multipliers):
        """(n, 3) f8 [kg m], A^T multipliers: sum_j a_ji N_j l_j."""
        forces = np.zeros_like(self.proposed)
        terms = self.weights[:, :, None] * (multipliers[:, None] * self.normals)[:, None, :]
        np.add.at(forces, self.nodes.ravel(), terms.reshape(-1, 3))
        return forces


class Residuals(NamedTuple):
    """How far (positions, multipliers) are from the optimum; +inf where undefined.

    With objective p = 1/2 sum m |x - y|^2, rows A and multipliers l of A x >= d:
    """

    violation_m: float  # [m], largest d - A x
    violation: float  # violation_m over the thickness
    dual_violation: float  # largest -l over the largest |l|
    stationarity: float  # |M (x - y) - A^T l| over |M (x - y)|, in the norm of M^-1
    complementarity: float  # sum l |A x - d| over p
    gap: float  # duality gap over p
    violation_floor: float  # what rounding x to floats alone can make of the violation
    gap_floor: float  # and of the gap

    def solved(self, gap_tolerance, violation_tolerance):
        """Whether gap and violation are within tolerance, or within rounding of x."""
        return self.gap <= max(gap_tolerance, self.gap_floor) and self.feasible(violation_tolerance)

    def feasible(self, violation_tolerance):
        """Whether the violation is within tolerance, or within rounding of x."""
        return self.violation <= max(violation_tolerance, self.violation_floor)


def residuals(problem: ZoneProblem, positions, multipliers) -> Residuals:
    """Judge a solution without asking the solver.

    The gap of p(x) over the dual function at l+ = max(l, 0) is, for any x and l,
    1/2 |M (x - y) - A^T l+|^2 + l+ . (A x - d), the norm in M^-1: written so, nothing
    cancels. The second term is taken with |A x - d|, so a violation cannot hide a gap.

    The floors: each coordinate of x is a float, off by up to u |x|, and so is each product
    in a gap; with weights of 2 in all, a gap is off by up to 8 u |x| |N|_1, taken with the
    largest coordinate and sqrt 3. Far from the origin that is more than any tolerance.

    Source: SPEC section 8; S. Boyd, L. Vandenberghe, Convex Optimization (2004), 5.5.
    """
    if not (np.isfinite(positions).all() and np.isfinite(multipliers).all()):
        return Residuals(*[math.inf] * 6, violation_floor=0.0, gap_floor=0.0)
    scale = problem.inverse_sqrt_masses[:, None]
    free = scale[:, 0] > 0.0
    moved = np.zeros_like(problem.proposed)
    moved[free] = (positions - problem.proposed)[free] / scale[free]
    objective = 0.5 * float(np.sum(moved**2))
    slack = problem.gaps(positions)
    clamped = np.maximum(multipliers, 0.0)
    error = float(np.sum((moved - scale * problem.pull(clamped)) ** 2))
    products = float(np.sum(clamped * np.abs(slack)))
    violation = max(0.0, float(np.max(-slack, initial=0.0)))
    largest_coordinate = float(np.max(np.abs(positions), initial=0.0))
    rounding = 8.0 * math.sqrt(3.0) * 2.0**-53 * largest_coordinate
    largest = float(np.max(np.abs(multipliers), initial=0.0))
    negative = max(0.0, float(np.max(-multipliers, initial=0.0)))
    return Residuals(
        violation_m=violation,
        violation=violation / problem.thickness,
        dual_violation=_ratio(negative, largest),
        stationarity=math.sqrt(_ratio(error, 2.0 * objective)),
        complementarity=_ratio(products, objective),
        gap=_ratio(0.5 * error + products, objective),
        violation_floor=rounding / problem.thickness,
        gap_floor=_ratio(rounding * float(np.sum(clamped)), objective),
    )


def _ratio(value, scale):
    if scale > 0.0:
        return value / scale
    return 0.0 if value == 0.0 else math.inf


class ZoneSolution(NamedTuple):
    """What a solver returns; `residuals` are computed outside of it."""

    positions: np.ndarray  # (n, 3) f8 [m]
    # (n, 3) f8 [m], from the proposed positions. A heavy vertex moves by less than its position can
    # say: at a mass ratio of 1e12 the rounding of positions is 1e-10 of the whole answer.
    displacements: np.ndarray
    multipliers: np.ndarray  # (n_impacts,) f8 [kg], of 1/2 sum m |x - y|^2
    residuals: Residuals
    method: str
    iterations: int
    feasible: bool  # False: the solver showed that nothing satisfies the constraints
    # (steps, 2) f8, after each step the objective 1/2 sum m |x - y|^2 [kg m^2] and the largest
    # violation [m]; None if it was not asked for or the method keeps none
    trace: np.ndarray | None = None
