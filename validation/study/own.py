"""The solvers of izo_ref as studies call them: zones are prepared, then solved on the clock."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Floats, Multipliers
from izo_ref.base.options import Options
from izo_ref.solvers.scaled_constraints import SystemSolution
from izo_ref.solvers.solve import solve_system
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.system import problem_system

DUAL = ("auto", "active-set", "interior-point", "pgs", "apgs")
FIRST_ORDER = ("pgs", "apgs")  # dual methods that iterate, so their number of steps is bounded
DIRECTIONS = ("gradient", "jacobi", "chebyshev", "cg", "lbfgs", "newton")
LINE_SEARCHES = ("exact", "backtracking", "wolfe")
PRESETS = ("arcsim", "icloth", "xrtailor")


class Setting(NamedTuple):
    """One of our solvers with its choices; the defaults are those of `Options`."""

    method: str = "auto"
    line_search: str = "backtracking"
    update: str = "every-step"
    penalty: str = "fixed"
    preset: str | None = None
    precision: str = "float64"

    @property
    def counts_steps(self) -> bool:
        """Whether the work of this solver is bounded by a number of steps."""
        return self.method in FIRST_ORDER + DIRECTIONS or self.preset is not None

    def options(self, tolerance: float, max_steps: int = 100_000) -> Options:
        """Return the options of this solver.

        Args:
            tolerance: For the relative gap, and for the violation over the thickness.
            max_steps: Limit of steps, for solvers that count them.
        """
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
    """The part of one problem in the solution of a system of zones."""

    displacements: Floats  # (n, 3) f8 [m], from the proposed positions
    multipliers: Multipliers  # (n_impacts,) f8 [kg]
    steps: int


def prepare(
    problems: Sequence[ZoneProblem], options: Options
) -> tuple[Callable[[], SystemSolution], Callable[[SystemSolution], Iterator[Solved]]]:
    """Put problems side by side, ready to be solved on the clock.

    Args:
        problems: Problems of the same thickness.
        options: Options of the solver.

    Returns:
        `call` and `read`. `call()` solves all problems and is what studies time. `read` takes its
        result and yields a `Solved` for each problem.
    """
    system, places = problem_system(problems)
    ends = np.cumsum([len(problem.masses) for problem in problems])

    def call() -> SystemSolution:
        return solve_system(system, options)

    def read(solution: SystemSolution) -> Iterator[Solved]:
        for number, (problem, end) in enumerate(zip(problems, ends, strict=True)):
            own = places[end - len(problem.masses) : end]
            rows = slice(*system.impact_offsets[number : number + 2])
            yield Solved(
                solution.displacements[own],
                solution.multipliers[rows],
                int(solution.iterations[number]),
            )

    return call, read
