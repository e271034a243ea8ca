"""The optimum of a zone as a least-distance problem, by SciPy's non-negative least squares.

Question: which point z with C z >= s is closest to zero (the scaled zone of `answer.py`)?

Method: minimise |E u - f| over u >= 0, with E = [C^T; s^T] and f = (0, ..., 0, 1). With the
residual r = E u - f, the answer is z = -r_head / r_last. If r_last = 0, no point satisfies the
constraints.

Independent of `izo_ref`: the scaled zone is written from the mathematics, and the solver is
SciPy's.

Limits: the matrix is dense, so it suits zones of up to about 256 impacts. Rounding leaves about
1e-16 in r_last even where it is zero. So r_last counts as zero if it is above -NOTHING. At the
minimum |r|^2 = -r_last, hence 1 + |z|^2 = -1 / r_last. So every point with |z| above 1e6 is given
up, where 1 is the largest violation of the scaled zone at z = 0.

Source: C. L. Lawson, R. J. Hanson, Solving Least Squares Problems (1974), 23.4.
"""

import time

import numpy as np

from validation.oracles.answer import Answer, ZoneArrays, no_answer, scaled_zone

# 1 + |z|^2 = -1 / r_last, so r_last = -1e-12 means |z| = 1e6.
NOTHING = 1e-12


def solve(problem: ZoneArrays, max_iterations: int | None = None) -> Answer:
    """Solve a zone.

    Args:
        problem: A zone problem.
        max_iterations: Limit of iterations; 30 times the number of impacts if None.

    Returns:
        The answer, without displacements if SciPy fails or no point satisfies the constraints.
    """
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
