"""Dense Cholesky factorisation of whole matrices, and of their first pivots."""

import numpy as np
import pytest

from izo_ref.solvers.serial.dense import (
    CHUNK,
    LARGE,
    PANEL,
    SMALL,
    cholesky_solve,
    partial_cholesky,
    work_of_cholesky,
)

U = 2.0**-53
SIZES = [1, 2, 5, SMALL, SMALL + 1, 30, LARGE, 101, CHUNK + PANEL + 30]


def positive_definite(rng, n):
    """Return a random symmetric positive definite matrix."""
    half = rng.normal(size=(n, n + 3))
    return half @ half.T + 0.1 * np.eye(n)


def factored(matrix, n, n_pivots, smallest):
    """Factor a matrix in place, with work memory that begins as NaN."""
    partial_cholesky(matrix, n, n_pivots, smallest, np.full(work_of_cholesky(n), np.nan))


@pytest.mark.parametrize("n", SIZES)
def test_solutions_are_within_the_backward_error_bound(rng, n):
    matrix, right = positive_definite(rng, n), rng.normal(size=n)
    factor, x = matrix.copy(), right.copy()
    factored(factor, n, n, 0.0)
    cholesky_solve(factor, n, x)
    # Higham, Accuracy and Stability of Numerical Algorithms (2002), theorem 10.4: the backward
    # error is at most (3 n + 1) u |R^T||R|, and the norm of |R^T||R| at most n times that of A.
    residual = np.linalg.norm(matrix @ x - right)
    norm = np.linalg.norm(matrix, 2)
    assert residual <= (3 * n + 1) * n * U * norm * np.linalg.norm(x)


@pytest.mark.parametrize("n", SIZES)
def test_only_the_upper_triangle_is_touched(rng, n):
    factor = positive_definite(rng, n)
    factor[np.tril_indices(n, -1)] = np.nan
    factored(factor, n, n, 0.0)
    assert np.isfinite(np.triu(factor)).all()


@pytest.mark.parametrize(
    ("n", "pivots"),
    [(8, 3), (40, 1), (40, 7), (40, 12), (41, 40), (9, 0), (90, 45), (101, 7), (CHUNK + 50, 17)],
)
def test_first_pivots_leave_the_schur_complement(rng, n, pivots):
    matrix = positive_definite(rng, n)
    factor = matrix.copy()
    factored(factor, n, pivots, 0.0)
    head, side, rest = matrix[:pivots, :pivots], matrix[:pivots, pivots:], matrix[pivots:, pivots:]
    expected = rest - side.T @ np.linalg.solve(head, side)
    np.testing.assert_allclose(
        np.triu(factor[pivots:, pivots:]), np.triu(expected), rtol=0.0, atol=1e-10
    )


@pytest.mark.parametrize("n", [6, 40, 120])
def test_a_dependent_unknown_is_left_out(rng, n):
    """The third row is the sum of the first two; the others are solved as if it did not exist."""
    rows = rng.normal(size=(n, n))
    rows[2] = rows[0] + rows[1]
    matrix, right = rows @ rows.T, rng.normal(size=n)
    factor, x = matrix.copy(), right.copy()
    factored(factor, n, n, 1e-9)
    cholesky_solve(factor, n, x)
    kept = np.arange(n) != 2
    assert x[2] == 0.0
    expected = np.linalg.solve(matrix[np.ix_(kept, kept)], right[kept])
    np.testing.assert_allclose(x[kept], expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
