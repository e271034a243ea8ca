"""Step sizes along a direction of descent.

All ask `along_line` alone, which costs a pass over the rows and no product with them. A
step of 0 says that none was found, which at the minimum of L to rounding is the rule.

Source: J. Nocedal, S. Wright, Numerical Optimization (2006), sections 3.1 and 3.5; the
page's eqs. 14, 18 and 21, with the gradient of 21b at x + step p, as it is in the book.
"""

import math

from izo_ref.base.compile import compiled
from izo_ref.solvers.serial.lagrangian import along_line

EXACT, BACKTRACKING, WOLFE = 0, 1, 2


@compiled
def search_line(zone, penalty, slope, curvature, first, settings):
    """Step by the line search of the settings, which begins at `first`; and the change of L.

    Exact and Wolfe: the derivative increases along the line, piece by piece linear, so an
    interval holds its root, or steps that satisfy Wolfe's conditions. Newton's steps leave
    at least one piece behind each; where they leave the interval it is halved.
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
                break  # no number is left between
        if step < settings.smallest_step:
            break
    return low, lowest
