"""Choose the step size along a direction of descent.

Along x + step p the augmented Lagrangian L is piecewise quadratic and convex, so its derivative
increases and is piecewise linear. A search needs nothing but `along_line`, which costs one pass
over the constraints and no product with their matrix.

    EXACT         the minimum of L along the line
    BACKTRACKING  the first of first, shrink first, shrink^2 first, ... with the Armijo condition
                  L(x + step p) - L(x) < c_1 step slope
    WOLFE         a step with the Armijo condition and |slope at x + step p| <= c_2 |slope at x|

A search may accept no step. This is what normally happens at the minimum of L, where only rounding
is left.

Source: J. Nocedal, S. Wright, Numerical Optimization (2006), sections 3.1 and 3.5; the page's
eqs. 14, 18 and 21. Eq. 21b takes the gradient at x + step p here, as the book does.
"""

import math

from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.lagrangian import Zone, along_line
from izo_ref.solvers.serial.settings import Settings

EXACT, BACKTRACKING, WOLFE = 0, 1, 2


@compiled
def search_line(
    zone: Zone,
    penalty: float,
    slope: float,
    curvature: float,
    first: float,
    settings: Settings,
) -> tuple[float, float]:
    """Search for a step size along p, beginning at the step `first`.

    EXACT and WOLFE keep an interval that holds the root of the derivative, or the steps that
    satisfy Wolfe's conditions. They take Newton's steps on the derivative, each of which leaves at
    least one linear piece behind. A step that leaves the interval is replaced by the middle of the
    interval, or by twice its lower end while it has no upper end.

    Args:
        zone: The zone, after `prepare_line`.
        penalty: mu.
        slope: Derivative of L along p at x.
        curvature: Second derivative there, without the active constraints.
        first: Step to try first.
        settings: Which search, and its parameters. Any code other than EXACT and BACKTRACKING runs
            as WOLFE; nothing is checked here, because `Options` checks the names on the host.

    Returns:
        The step and the change of L. If no step was accepted: the largest step tried that was not
        too long, or 0 if there was none.
    """
    exact = settings.line_search == EXACT
    wanted = (4.0 * settings.rounding if exact else settings.wolfe) * abs(slope)
    low, high, step, lowest = 0.0, math.inf, first, 0.0
    for _ in range(200):
        change, rise, second = along_line(zone, penalty, slope, curvature, step)
        enough = change < settings.armijo * step * slope
        if settings.line_search == BACKTRACKING:
            if enough:
                return step, change
            step *= settings.shrink
        else:
            too_far = rise > wanted or not (exact or enough)
            if not too_far and rise >= -wanted:
                return step, change
            if too_far:
                high = step
            else:
                low, lowest = step, change
            step -= rise / second
            if not low < step < high:
                step = 0.5 * (low + high) if high < math.inf else 2.0 * low
            if step <= low or step >= high:
                break  # no number is left between low and high
        if step < settings.smallest_step:
            break
    return low, lowest
