"""The optimum of a problem, to measure answers against."""

import math

import numpy as np

from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.distance import distance_bound
from validation.oracles.answer import mass_norm
from validation.oracles.rational import ExactZone, active_rows, rational, to_float

EXACT_IMPACTS = 64  # up to which the optimum is computed in rationals: a second or less
# Up to which the distance is proved; 47 s for 24,000. Above, the gap's word is taken for it.
PROVED_IMPACTS = 2048


class Truth:
    """The optimum, exact for small zones, else our best answer and its distance at most.

    Args:
        problem: `ZoneProblem`.

    Attributes:
        says: "exact"; "bound", proved; or "gap": what its duality gap says, which takes for
            granted that rows hold where they are off by rounding.
        objective: [kg m^2], 1/2 sum m |x* - y|^2; of our best answer where not exact.
    """

    def __init__(self, problem):
        self.masses = problem.masses
        best = solve_zone(problem, tolerance=1e-12)
        self.high, self.low, self.bound = best.displacements, 0.0, 0.0
        size = len(problem.nodes)
        self.says = (
            "exact" if size <= EXACT_IMPACTS else "bound" if size <= PROVED_IMPACTS else "gap"
        )
        if self.says == "exact":
            moves = ExactZone(problem).solve(active_rows(best.multipliers)).moves
            self.high = to_float(moves)
            self.low = to_float(
                [
                    [value - rational(high) for value, high in zip(*pair, strict=True)]
                    for pair in zip(moves, self.high, strict=True)
                ]
            )
        elif self.says == "bound":
            positions = problem.proposed + best.displacements
            self.bound = distance_bound(problem, positions, best.multipliers, best.displacements)
        self.size = mass_norm(problem.masses, self.high)
        self.objective = 0.5 * self.size**2
        if self.says == "gap":  # |x - x*|^2 is at most twice the gap, and it is over 1/2 |x - y|^2
            self.bound = math.sqrt(best.residuals.gap) * self.size

    def error(self, displacements) -> float:
        """|x - x*| over |x* - y| in the norm of the masses; at most, where not exact.

        An exact optimum is held in two floats, 32 digits. By the triangle inequality the
        error is at most the distance to our best answer and that answer's own bound.
        """
        if not np.isfinite(displacements).all():
            return math.inf
        away = mass_norm(self.masses, displacements - self.high - self.low)
        return (away + self.bound) / self.size
