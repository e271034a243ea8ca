"""Cholesky factors by a thread group: one thread here, several in tests/simulated."""

import numpy as np
import pytest

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.serial.group_cholesky import factorize, packed_size, solve


@pytest.mark.parametrize("n", [0, 1, 2, 3, 4, 7, 33, 130])
def test_solves_have_the_residuals_of_a_stable_method(rng, n):
    rows = rng.normal(size=(n, n + 2))
    matrix, right = rows @ rows.T, rng.normal(size=n)
    packed, scales = matrix[np.tril_indices(n)], np.full(n, np.nan)
    assert packed.size == packed_size(n)
    factorize(ALONE, packed, n, scales)
    x = right.copy()
    solve(ALONE, packed, n, scales, x, np.full(n, np.nan))
    # Higham, theorem 10.4: the residual is at most 4 n (3 n + 1) u |R^T| |R| |x|, to first order.
    factor = np.zeros((n, n))
    factor[np.tril_indices(n, -1)] = packed[np.not_equal(*np.tril_indices(n))]
    factor[np.diag_indices(n)] = 1.0 / scales
    bound = 4 * n * (3 * n + 1) * 2.0**-53 * np.abs(factor) @ np.abs(factor.T) @ np.abs(x)
    assert (np.abs(matrix @ x - right) <= bound).all()
    np.testing.assert_allclose(factor, np.linalg.cholesky(matrix), rtol=1e-9, atol=1e-12)


def test_a_pivot_that_is_not_positive_leaves_its_unknown_out():
    packed, scales = np.array([4.0, 2.0, 1.0, 0.0, 0.0, 9.0]), np.full(3, np.nan)
    factorize(ALONE, packed, 3, scales)
    assert scales.tolist() == [0.5, 0.0, 1.0 / 3.0]
    x = np.array([8.0, 4.0, 18.0])
    solve(ALONE, packed, 3, scales, x, np.empty(3))
    assert x.tolist() == [2.0, 0.0, 2.0]
