"""The optimum of a zone, against which studies measure the errors of answers."""

import math

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.problem import ZoneProblem
from validation.oracles.answer import mass_norm
from validation.oracles.rational import (
    EXACT_IMPACTS,
    ExactZone,
    active_rows,
    rational,
    to_float,
)

# Largest number of impacts for which the distance to the optimum is proved: 47 s for 24,000. Above,
# the distance is computed from the duality gap.
PROVED_IMPACTS = 2048


class Truth:
    """The optimum of a zone: exact if the zone is small, else our best answer with a bound.

    Args:
        problem: The zone.

    Attributes:
        says: How the optimum is known. "exact": it was computed in rationals. "bound": the distance
            of our best answer to the optimum is proved. "gap": that distance is computed from the
            duality gap, and it assumes that constraints hold where they are off by rounding.
        objective: [kg m^2], 1/2 sum m |x* - y|^2; that of our best answer where not exact.
        bound: [m kg^1/2], distance of our best answer to the optimum at most; zero if exact.
    """

    def __init__(self, problem: ZoneProblem) -> None:
        """Solve the zone, and compute the optimum or a bound."""
        self.masses = problem.masses
        best = solve_zone(problem, tolerance=1e-12)
        self.high, self.low, self.bound = best.displacements, 0.0, 0.0
        size = len(problem.nodes)
        self.says = (
            "exact" if size <= EXACT_IMPACTS else "bound" if size <= PROVED_IMPACTS else "gap"
        )
        if self.says == "exact":
            optimum = ExactZone(problem).solve(active_rows(best.multipliers))
            if optimum is None:
                raise ValueError("problem: expected a zone that some positions satisfy")
            self.high = to_float(optimum.moves)
            self.low = to_float(
                [
                    [value - rational(high) for value, high in zip(*pair, strict=True)]
                    for pair in zip(optimum.moves, self.high, strict=True)
                ]
            )
        elif self.says == "bound":
            positions = problem.proposed + best.displacements
            self.bound = distance_bound(problem, positions, best.multipliers, best.displacements)
        self.size = mass_norm(problem.masses, self.high)
        self.objective = 0.5 * self.size**2
        if self.says == "gap":
            # |x - x*|^2 is at most twice the gap, and the relative gap is over 1/2 |x - y|^2
            self.bound = math.sqrt(best.residuals.gap) * self.size

    def error(self, displacements: Floats) -> float:
        """Compute |x - x*| over |x* - y| in the norm of the masses.

        An exact optimum is held in two floats for each number, which gives 32 digits. Where the
        optimum is not exact, the triangle inequality gives an upper bound: the distance to our best
        answer plus the bound of that answer.

        Args:
            displacements: (n, 3) f8 [m], from the proposed positions.

        Returns:
            The relative error, an upper bound of it where the optimum is not exact; infinity if a
            displacement is not finite.
        """
        if not np.isfinite(displacements).all():
            return math.inf
        away = mass_norm(self.masses, displacements - self.high - self.low)
        return (away + self.bound) / self.size
