"""The sparse Cholesky factorisation, compared with dense algebra."""

import numba
import numpy as np
import pytest

from izo_ref.solvers.serial.elimination import elimination_tree, factor_structure, postorder
from izo_ref.solvers.sparse import PARALLEL, SparseCholesky


def random_matrix(rng, n, size, density=3):
    """Draw a sparse positive definite matrix of n x n blocks.

    Returns:
        Entries, each in the upper or in the lower triangle, their values, and the whole matrix.
    """
    pairs = rng.integers(n, size=(density * n, 2))
    entries = np.concatenate((pairs, np.column_stack((np.arange(n), np.arange(n)))))
    _, kept = np.unique(np.sort(entries, axis=1), axis=0, return_index=True)
    entries = entries[rng.permutation(kept)]
    half = rng.normal(size=(len(entries), size, size))
    values = half + half.transpose(0, 2, 1)
    whole = np.zeros((n, size, n, size))
    whole[entries[:, 0], :, entries[:, 1], :] = values
    whole[entries[:, 1], :, entries[:, 0], :] = values
    whole = whole.reshape(n * size, n * size)
    shift = 1.0 - np.linalg.eigvalsh(whole)[0]
    values[entries[:, 0] == entries[:, 1]] += shift * np.eye(size)
    return entries, values, whole + shift * np.eye(n * size)


@pytest.mark.parametrize("size", [1, 3])
@pytest.mark.parametrize("n", [1, 2, 7, 40, 150])
def test_solutions_are_within_the_backward_error_bound(rng, n, size):
    entries, values, matrix = random_matrix(rng, n, size)
    factors = SparseCholesky(entries, n, size)
    for scale in (1.0, 10.0):  # the same pattern twice, with other values
        factors.factorize(scale * values)
        right = rng.normal(size=n * size)
        x = factors.solve(right)
        residual = np.linalg.norm(scale * matrix @ x - right)
        norm = np.linalg.norm(scale * matrix, 2)
        # The bound of tests/solvers/test_dense.py: the norm of |R^T||R| is at most n times that
        # of A.
        assert residual <= (3 * n * size + 1) * n * size * 2.0**-53 * norm * np.linalg.norm(x)


def test_one_thread_and_two_give_the_same_bits(rng):
    """The matrix needs enough work to be factored by all threads."""
    entries, values, _ = random_matrix(rng, 400, 3, density=2)
    right = rng.normal(size=1200)
    before, found = numba.get_num_threads(), []
    for threads in (1, min(2, numba.config.NUMBA_NUM_THREADS)):
        numba.set_num_threads(threads)
        factors = SparseCholesky(entries, 400, 3)
        factors.factorize(values)
        found.append(factors.solve(right))
    numba.set_num_threads(before)
    assert factors.flops > PARALLEL
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("size", [1, 3])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.9])
def test_a_matrix_without_some_rows_is_factored(rng, size, share):
    """Restrictions follow each other, and each one starts from the whole matrix."""
    n = 150
    entries, values, matrix = random_matrix(rng, n, size)
    factors = SparseCholesky(entries, n, size)
    whole = factors.flops
    for _ in range(3):
        chosen = rng.random(n) < share
        chosen[rng.integers(n)] = True
        factors.restrict(chosen)
        factors.factorize(values)
        rows = np.repeat(chosen, size)
        right = rng.normal(size=np.count_nonzero(rows))
        x = factors.solve(right)
        part = matrix[np.ix_(rows, rows)]
        # the bound of the test above, for a matrix of this size
        bound = (3 * len(part) + 1) * len(part) * 2.0**-53 * np.linalg.norm(part, 2)
        assert np.linalg.norm(part @ x - right) <= bound * np.linalg.norm(x)
        assert factors.flops < share * whole + 1e3


def test_disconnected_components_are_solved_independently(rng):
    entries, values, _ = random_matrix(rng, 30, 3)
    other = np.concatenate((entries, entries + 30, [[60, 60]]))
    both = np.concatenate((values, 2.0 * values, [np.eye(3)]))
    factors = SparseCholesky(other, 61, 3)
    factors.factorize(both)
    alone = SparseCholesky(entries, 30, 3)
    alone.factorize(values)
    right = rng.normal(size=90)
    x = factors.solve(np.concatenate((right, right, [1.0, 2.0, 3.0])))
    np.testing.assert_allclose(x[:90], alone.solve(right), rtol=1e-12)
    np.testing.assert_allclose(x[90:180], 0.5 * x[:90], rtol=1e-12)
    np.testing.assert_array_equal(x[180:], [1.0, 2.0, 3.0])


def test_a_grid_is_factored_in_few_operations():
    """The factorisation of a k x k grid in minimum-degree order takes about 10 k^3 operations.

    An order along the rows of the grid would take k^4, which is six times as many here.
    """
    k = 60
    number = np.arange(k * k).reshape(k, k)
    right = np.column_stack((number[:, :-1].ravel(), number[:, 1:].ravel()))
    down = np.column_stack((number[:-1].ravel(), number[1:].ravel()))
    itself = np.column_stack((number.ravel(), number.ravel()))
    factors = SparseCholesky(np.concatenate((right, down, itself)), k * k, 1)
    assert factors.flops < 15 * k**3


def test_the_structure_of_the_factor_is_that_of_elimination_on_sets(rng):
    """Tree and columns of the factor are compared with an elimination that is done on sets."""
    for n in (1, 5, 30):
        entries, _, matrix = random_matrix(rng, n, 1, density=2)
        neighbours = [set(np.flatnonzero(row).tolist()) - {i} for i, row in enumerate(matrix)]
        lists = [sorted(found) for found in neighbours]
        starts = np.cumsum([0, *map(len, lists)])
        indices = np.array([i for found in lists for i in found], np.int32)
        parent = elimination_tree(starts, indices)
        column_starts, rows = factor_structure(starts, indices, parent)
        for k in range(n):
            below = {i for i in neighbours[k] if i > k}
            found = rows[column_starts[k] : column_starts[k + 1]].tolist()
            assert found == sorted(below)
            assert parent[k] == min(below, default=-1)
            for i in below:
                neighbours[i] |= below - {i}
        order = postorder(parent).tolist()
        assert sorted(order) == list(range(n))
        assert all(order.index(p) > order.index(i) for i, p in enumerate(parent) if p >= 0)
        assert len(entries) > 0
