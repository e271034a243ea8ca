"""The zone problem, its solution, and its residuals."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from izo_ref.base import checks
from izo_ref.base.arrays import Floats, Multipliers, Positions, Weights
from izo_ref.base.devices import copy_to_cpu, detach
from izo_ref.base.errors import OptionError, SizeError, WeightError
from izo_ref.base.records import Impacts

# Largest sum of four weights, over the largest of them, that is taken for rounding. A weight in
# float32 is off by 2^-24 of its size; ports compute weights with a few of these errors.
ROUNDED = 2.0**-20
# Exponent of the largest weight and of the largest component of a normal, and less that of the
# smallest. The solvers multiply both with lengths of up to 2^100 and roots of masses of up to
# 2^100; the squares of these products are floats.
FACTORS = 100


class ZoneProblem:
    """Minimise 1/2 sum_i m_i |x_i - y_i|^2 subject to N_j . sum_k a_jk x[nodes_jk] >= d.

    Args:
        nodes: (n_impacts, 4) integers, the vertices of each impact as indices into `proposed`.
        weights: (n_impacts, 4), the weights a. Those of an impact sum to zero, to the rounding of
            float32, so only the differences of its vertices count.
        normals: (n_impacts, 3), the normals N. Their lengths need not be 1.
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
        WeightError: The weights of an impact do not sum to zero.
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
        arrays = {
            "nodes": nodes,
            "weights": weights,
            "normals": normals,
            "proposed": proposed,
            "masses": masses,
        }
        taken = {name: copy_to_cpu(name, detach(array)) for name, array in arrays.items()}
        self.proposed = checks.floats("proposed", taken["proposed"], (None, 3))
        k = len(self.proposed)
        self.nodes = checks.indices("nodes", taken["nodes"], 4, k)
        n = len(self.nodes)
        self.weights = checks.floats("weights", taken["weights"], (n, 4))
        _require_sums(self.weights)
        self.normals = checks.floats("normals", taken["normals"], (n, 3))
        self.masses = checks.masses(taken["masses"], k, infinite_allowed=True)
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


def _require_sums(weights: Weights) -> None:
    """Raise an error if the weights of an impact do not sum to zero."""
    largest = np.abs(weights).max(axis=1, initial=0.0)
    largest[largest == 0.0] = 1.0
    sums = np.abs((weights / largest[:, None]).sum(axis=1))  # a sum of four floats may overflow
    off = np.flatnonzero(sums > ROUNDED)
    if len(off):
        raise WeightError(
            f"weights: expected four weights that sum to 0 for each impact, found {len(off)} "
            f"impacts with others, the first is impact {off[0]}: {weights[off[0]].tolist()}. The "
            "weights of one side sum to 1, those of the other side to -1"
        )


def require_factors(problem: ZoneProblem | Impacts) -> None:
    """Raise an error if weights or normals are too large or too small for the solvers.

    Args:
        problem: The problem, or impacts that are not yet in zones.

    Raises:
        SizeError: The largest weight of an impact, or the largest component of its normal, is not
            0 and not from 2^-100 to 2^100; names the first one.
    """
    low, high = 2.0**-FACTORS, 2.0**FACTORS
    for name, rows in (("weights", problem.weights), ("normals", problem.normals)):
        largest = np.abs(rows).max(axis=1, initial=0.0)
        off = np.flatnonzero((largest > high) | ((largest < low) & (largest > 0.0)))
        if len(off):
            raise SizeError(
                f"{name}: expected rows that are 0, or whose largest absolute value is from "
                f"{low:.3g} to {high:.3g}, found {len(off)} others, the first is row {off[0]}: "
                f"{rows[off[0]].tolist()}. Weights are at most 1, normals have length 1"
            )


def require_problem(problem: Any) -> None:
    """Raise an error if a value is no `ZoneProblem`.

    Args:
        problem: Anything.

    Raises:
        OptionError: It is none.
    """
    if not isinstance(problem, ZoneProblem):
        raise OptionError(
            f"problem: expected a ZoneProblem, got {type(problem).__name__}. Make one with "
            "izo_ref.ZoneProblem(nodes, weights, normals, proposed, masses, thickness)"
        )


class Residuals(NamedTuple):
    """How far positions and multipliers are from the optimum of a zone (`zones/residuals.py`).

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
