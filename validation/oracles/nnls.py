"""Zones as least-distance problems, by SciPy's non-negative least squares.

The closest point to zero with C z >= s: minimise |E u - f| over u >= 0 with E = [C^T; s^T]
and f = (0, ..., 0, 1). With the residual r = E u - f, the point is z = -r_head / r_last;
r_last = 0 means that no point satisfies the constraints. Rounding leaves some 1e-16 there, so
less than NOTHING counts as 0: the point would be a million times as far off as the largest
violation.

Source: C. L. Lawson, R. J. Hanson, Solving Least Squares Problems (1974), 23.4.
"""

import time

import numpy as np

from validation.oracles.answer import Answer, no_answer, scaled_zone

NOTHING = 1e-12  # |r|^2 = -r_last, and 1 / r_last = -(1 + |z|^2)


def solve(problem, max_iterations=None) -> Answer:
    from scipy.optimize import nnls

    begin = time.perf_counter()
    zone = scaled_zone(problem)
    matrix = np.vstack((zone.matrix.toarray().T, zone.rhs))
    target = np.zeros(len(matrix))
    target[-1] = 1.0
    try:
        u, _ = nnls(matrix, target, maxiter=max_iterations or 30 * matrix.shape[1])
    except RuntimeError as error:
        return no_answer(problem, str(error), time.perf_counter() - begin)
    residual = matrix @ u - target
    if not residual[-1] < -NOTHING:
        return no_answer(problem, "no feasible point", time.perf_counter() - begin)
    z = -residual[:-1] / residual[-1]
    multipliers = zone.multipliers(u / -residual[-1])
    return Answer(zone.displacements(z), multipliers, True, "solved", time.perf_counter() - begin)
