"""The zone problem, its solution, and the residuals that judge every solver."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from izo_ref.base import checks
from izo_ref.base.arrays import AnyArray, Floats, Multipliers, Offsets, Positions


class ZoneProblem:
    """Minimise 1/2 sum_i m_i |x_i - y_i|^2 subject to N_j . sum_k a_jk x[nodes_jk] >= d.

    Args:
        nodes: (n_impacts, 4) integers, the vertices of each impact as indices into `proposed`.
        weights: (n_impacts, 4), the weights a.
        normals: (n_impacts, 3), the normals N.
        proposed: (n, 3) [m], the proposed positions y.
        masses: (n,) [kg], the masses m > 0. A pinned vertex has an infinite mass and stays at its
            proposed position.
        thickness: The thickness d > 0 [m].

    Attributes:
        nodes: (n_impacts, 4) i4.
        weights: (n_impacts, 4) f8.
        normals: (n_impacts, 3) f8.
        proposed: (n, 3) f8 [m].
        masses: (n,) f8 [kg].
        thickness: The thickness [m].

    Raises:
        ShapeError: An array has the wrong shape or type.
        NonFiniteError: A number other than a mass is NaN or infinite.
        IndexRangeError: An index points at no vertex.
        MassError: A mass is not positive.
        ThicknessError: The thickness is not a positive, finite number.

    Source: docs/method sections 1 and 5.
    """

    def __init__(
        self,
        nodes: ArrayLike,
        weights: ArrayLike,
        normals: ArrayLike,
        proposed: ArrayLike,
        masses: ArrayLike,
        thickness: float,
    ) -> None:
        """Copy and check the arrays."""
        self.proposed = checks.floats("proposed", proposed, (None, 3))
        k = len(self.proposed)
        self.nodes = checks.indices("nodes", nodes, 4, k)
        n = len(self.nodes)
        self.weights = checks.floats("weights", weights, (n, 4))
        self.normals = checks.floats("normals", normals, (n, 3))
        self.masses = checks.masses(masses, k, infinite_allowed=True)
        self.thickness = checks.thickness(thickness)

    @property
    def inverse_sqrt_masses(self) -> Floats:
        """(n,) f8 [kg^-1/2], 1 / sqrt(m); 0 for pinned vertices."""
        return 1.0 / np.sqrt(self.masses)

    def gaps(self, positions: Positions) -> Floats:
        """Return how far each constraint is satisfied.

        Args:
            positions: (n, 3) f8 [m], end positions.

        Returns:
            (n_impacts,) f8 [m], frozen gap less the thickness; negative is a violation.
        """
        # Positions relative to the first node give the same gap, because the weights sum to zero,
        # and far from the origin they lose less to rounding.
        relative = positions[self.nodes] - positions[self.nodes[:, :1]]
        points = np.einsum("jk,jkx->jx", self.weights, relative)
        return np.einsum("jx,jx->j", self.normals, points) - self.thickness

    def pull(self, multipliers: Multipliers) -> Floats:
        """Compute A^T l: for each vertex i, sum_j a_ji N_j l_j.

        Args:
            multipliers: (n_impacts,) f8 [kg], the multipliers l.

        Returns:
            (n, 3) f8 [kg m].
        """
        forces = np.zeros_like(self.proposed)
        terms = self.weights[:, :, None] * (multipliers[:, None] * self.normals)[:, None, :]
        np.add.at(forces, self.nodes.ravel(), terms.reshape(-1, 3))
        return forces


class Residuals(NamedTuple):
    """How far positions and multipliers are from the optimum of a zone.

    The objective is p = 1/2 sum m |x - y|^2; the multipliers l belong to the constraints A x >= d.
    A residual is +inf where it is undefined.

    Attributes:
        violation_m: Largest d - A x, or 0 if no constraint is violated [m].
        violation: `violation_m` divided by the thickness.
        dual_violation: Largest -l divided by the largest |l|.
        stationarity: |M (x - y) - A^T l| divided by |M (x - y)|, in the norm of M^-1.
        complementarity: sum l |A x - d| divided by p.
        gap: Duality gap divided by p.
        violation_floor: Largest `violation` that rounding x to floats alone can cause.
        gap_floor: Largest `gap` that rounding x to floats alone can cause.
    """

    violation_m: float
    violation: float
    dual_violation: float
    stationarity: float
    complementarity: float
    gap: float
    violation_floor: float
    gap_floor: float

    def solved(self, gap_tolerance: float, violation_tolerance: float) -> bool:
        """Return whether gap and violation are within tolerance, or within the rounding of x.

        Args:
            gap_tolerance: Largest relative duality gap.
            violation_tolerance: Largest violation, as a fraction of the thickness.
        """
        return self.gap <= max(gap_tolerance, self.gap_floor) and self.feasible(violation_tolerance)

    def feasible(self, violation_tolerance: float) -> bool:
        """Return whether the violation is within tolerance, or within the rounding of x.

        Args:
            violation_tolerance: Largest violation, as a fraction of the thickness.
        """
        return self.violation <= max(violation_tolerance, self.violation_floor)


def residuals(problem: ZoneProblem, positions: Positions, multipliers: Multipliers) -> Residuals:
    """Judge positions and multipliers of a zone without asking the solver.

    The gap between p(x) and the dual function at l+ = max(l, 0) is, for any x and l,
    1/2 |M (x - y) - A^T l+|^2 + l+ . (A x - d), with the norm of M^-1. In this form nothing
    cancels. The second term is computed with |A x - d|, so that a violation cannot hide a gap.

    The floors: each coordinate of x is a float, with an error of up to u |x|, where u = 2^-53. Each
    product in a frozen gap has such an error, too. The absolute weights sum to 2, so a frozen gap
    has an error of up to 8 u |x| |N|_1. The bound uses the largest coordinate for |x| and sqrt 3
    for |N|_1. Far from the origin that is more than any tolerance.

    Args:
        problem: The zone problem.
        positions: (n, 3) f8 [m], the positions x.
        multipliers: (n_impacts,) f8 [kg], the multipliers l.

    Returns:
        The residuals.

    Source: docs/method section 8; S. Boyd, L. Vandenberghe, Convex Optimization (2004), 5.5.
    """
    whole = np.array([0, len(problem.nodes)]), np.array([0, len(positions)])
    return residuals_of_zones(problem, positions, multipliers, *whole)[0]


def residuals_of_zones(
    problem: ZoneProblem,
    positions: Positions,
    multipliers: Multipliers,
    impact_offsets: Offsets,
    vertex_offsets: Offsets,
) -> list[Residuals]:
    """Return the `residuals` of zones that lie side by side in one problem.

    Args:
        problem: The problem of all zones. Zones share pinned vertices only.
        positions: (n, 3) f8 [m], the positions x.
        multipliers: (n_impacts,) f8 [kg], the multipliers l.
        impact_offsets: (n_zones + 1,) i8, where the impacts of each zone begin, and the end.
        vertex_offsets: (n_zones + 1,) i8, where the unpinned vertices of each zone begin, and the
            end. Pinned vertices may be anywhere.
    """

    def of_impacts(ufunc: np.ufunc, values: AnyArray) -> AnyArray:
        return _reduced(ufunc, values, impact_offsets)

    def of_vertices(ufunc: np.ufunc, values: AnyArray) -> AnyArray:
        return _reduced(ufunc, values, 3 * vertex_offsets)

    wrong = of_vertices(np.logical_or, ~np.isfinite(positions).ravel())
    wrong |= of_impacts(np.logical_or, ~np.isfinite(multipliers))
    if wrong.any():  # compute with numbers, so that one zone does not disturb the others
        positions = np.where(np.isfinite(positions), positions, problem.proposed)
        multipliers = np.where(np.isfinite(multipliers), multipliers, 0.0)
    scale = problem.inverse_sqrt_masses[:, None]
    moved = np.zeros_like(problem.proposed)
    np.divide(positions - problem.proposed, scale, out=moved, where=scale > 0.0)
    objective = 0.5 * of_vertices(np.add, (moved**2).ravel())
    slack = problem.gaps(positions)
    clamped = np.maximum(multipliers, 0.0)
    errors = moved - scale * problem.pull(clamped)
    error = of_vertices(np.add, (errors**2).ravel())
    products = of_impacts(np.add, clamped * np.abs(slack))
    violation = of_impacts(np.maximum, np.maximum(-slack, 0.0))
    coordinates = np.abs(positions)
    largest_coordinate = np.maximum(
        of_vertices(np.maximum, coordinates.ravel()),
        of_impacts(np.maximum, coordinates[problem.nodes].max(axis=(1, 2), initial=0.0)),
    )
    rounding = 8.0 * math.sqrt(3.0) * 2.0**-53 * largest_coordinate
    largest = of_impacts(np.maximum, np.abs(multipliers))
    negative = of_impacts(np.maximum, np.maximum(-multipliers, 0.0))
    columns = (
        violation,
        violation / problem.thickness,
        _ratio(negative, largest),
        np.sqrt(_ratio(error, 2.0 * objective)),
        _ratio(products, objective),
        _ratio(0.5 * error + products, objective),
        rounding / problem.thickness,
        _ratio(rounding * of_impacts(np.add, clamped), objective),
    )
    infinite = Residuals(*[math.inf] * 6, violation_floor=0.0, gap_floor=0.0)
    rows = zip(*(column.tolist() for column in columns), wrong.tolist(), strict=True)
    return [infinite if is_wrong else Residuals(*row) for *row, is_wrong in rows]


def _reduced(ufunc: np.ufunc, values: AnyArray, offsets: Offsets) -> AnyArray:
    """Return the sum, the largest value or the like of each block; 0 for an empty block."""
    firsts, ends = offsets[:-1], offsets[1:]
    result = np.zeros(len(firsts), values.dtype)
    full = firsts < ends
    if full.any():
        result[full] = ufunc.reduceat(values[: offsets[-1]], firsts[full])
    return result


def _ratio(value: Floats, scale: Floats) -> Floats:
    """Return value / scale; where the scale is 0, return 0 for the value 0, else infinity."""
    result = np.where(value == 0.0, 0.0, math.inf)
    return np.divide(value, scale, out=result, where=scale > 0.0)


class ZoneSolution(NamedTuple):
    """What a solver returns for one zone; the residuals are computed outside of the solver.

    Attributes:
        positions: (n, 3) f8 [m].
        displacements: (n, 3) f8 [m], positions less the proposed positions, known more exactly
            than from the positions: a heavy vertex may move by less than the rounding of its
            position. At a mass ratio of 1e12 the rounding of positions is 1e-10 of the whole
            answer.
        multipliers: (n_impacts,) f8 [kg], for the objective 1/2 sum m |x - y|^2.
        residuals: Residuals of the positions and multipliers.
        method: The method that solved the zone.
        iterations: Number of its iterations.
        feasible: False if the solver showed that no positions satisfy the constraints.
        trace: (n_steps, 2) f8, after each step the objective 1/2 sum m |x - y|^2 [kg m^2] and the
            largest violation [m]. None if it was not asked for, or if the method keeps none.
    """

    positions: Positions
    displacements: Floats
    multipliers: Multipliers
    residuals: Residuals
    method: str
    iterations: int
    feasible: bool
    trace: Floats | None = None
