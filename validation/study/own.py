"""Our own solvers, as contestants: a prepared system of zones, solved and judged."""

from typing import NamedTuple

import numpy as np

from izo_ref.base.options import Options
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.system import problem_system

DUAL = ("auto", "active-set", "interior-point", "pgs", "apgs")
FIRST_ORDER = ("pgs", "apgs")  # of the dual; they iterate, so their steps are bounded
DIRECTIONS = ("gradient", "jacobi", "chebyshev", "cg", "lbfgs", "newton")
LINE_SEARCHES = ("exact", "backtracking", "wolfe")
PRESETS = ("arcsim", "icloth", "xrtailor")


class Setting(NamedTuple):
    """One of our solvers, with its choices; the defaults are those of `Options`."""

    method: str = "auto"
    line_search: str = "backtracking"
    update: str = "every-step"
    penalty: str = "fixed"
    preset: str | None = None
    precision: str = "float64"

    @property
    def counts_steps(self):
        """Whether its work is bounded by a number of steps."""
        return self.method in FIRST_ORDER + DIRECTIONS or self.preset is not None

    def options(self, tolerance, max_steps=100_000) -> Options:
        return Options(
            method=self.method,
            line_search=self.line_search,
            multiplier_update=self.update,
            penalty=self.penalty,
            preset=self.preset,
            precision=self.precision,
            gap_tolerance=tolerance,
            violation_tolerance=tolerance,
            max_steps=max_steps,
        )


class Solved(NamedTuple):
    """The part of one problem in the solution of a system."""

    displacements: np.ndarray  # (n, 3) f8 [m]
    multipliers: np.ndarray  # (n_impacts,) f8 [kg]
    steps: int


def prepare(problems, options):
    """(call, read): `call()` is timed, `read` of what it returns gives a `Solved` a problem."""
    system, places = problem_system(problems)
    ends = np.cumsum([len(problem.masses) for problem in problems])

    def call():
        return solve_system(system, options)

    def read(solution):
        for number, (problem, end) in enumerate(zip(problems, ends, strict=True)):
            own = places[end - len(problem.masses) : end]
            rows = slice(*system.impact_offsets[number : number + 2])
            yield Solved(
                solution.displacements[own],
                solution.multipliers[rows],
                int(solution.iterations[number]),
            )

    return call, read
