"""Parameters of the augmented-Lagrangian loop."""

import sys
from typing import NamedTuple

# A tolerance of 0 is one: nothing but the exact answer is within it. Solvers divide by tolerances.
LEAST_TOLERANCE = sys.float_info.min


class Settings(NamedTuple):
    """Parameters of the loop; `solvers/presets.py` says where their values are from."""

    direction: int  # GRADIENT to NEWTON of solvers/serial/descent.py
    line_search: int  # EXACT, BACKTRACKING or WOLFE of solvers/serial/line_search.py
    every_step: bool  # update multipliers after every step, not after an inner solve
    preconditioned: bool  # divide by the diagonal of the generalised Hessian
    begin: int  # first step of a line search: LAST, UNIT or MODEL of solvers/serial/descent.py
    armijo: float  # c_1: fraction of the predicted decrease that a step must reach
    wolfe: float  # c_2: fraction of the slope that a step may leave
    shrink: float  # backtracking multiplies a step that is too long by this
    grow: float  # a search that begins at the last step multiplies it by this
    smallest_step: float  # a search that reaches a smaller step has failed
    faithful: bool  # follow a preset: end where a search fails, without guards and restarts
    max_steps: int
    gap_tolerance: float  # relative duality gap to reach
    violation_m: float  # [m], largest violation to reach
    rounding: float  # half a unit in the last place of 1, in the type of the arrays
    inner_steps: int  # largest number of steps between updates of the multipliers
    inner_accuracy: float  # delta, see `is_inner_solve_done` of solvers/serial/stopping.py
    eps_x: float  # ARCSim stops an inner solve at a step of this length; negative: never
    eps_f: float  # ARCSim stops an inner solve at this relative change of L; negative: never
    eps_g: float  # ARCSim stops an inner solve at this norm of the gradient
    penalty_growth: float  # factor by which mu grows; 1: it is fixed
    delay: int  # steps before omega of Chebyshev's acceleration differs from 1
    rho: float  # estimate of the spectral radius, of Chebyshev's acceleration
    linear_tolerance: float  # relative residual of Newton's linear systems
    linear_steps: int  # products with the Hessian in each such system, over the unknowns
