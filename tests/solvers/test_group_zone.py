"""Products with the constraints of a zone by a thread group, compared with a dense matrix."""

import numpy as np
import pytest

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.serial.group_zone import (
    Zone,
    add_gram_row,
    link_entries,
    product,
    pull,
    row_sum,
)


def random_zone(rng, n, n_vertices, first):
    """Return a zone of random vertices, some of them pinned, and its matrix C."""
    nodes = np.array([rng.choice(n_vertices, 4, replace=False) for _ in range(n)]) + first
    nodes = np.where(rng.random((n, 4)) < 0.3, -1, nodes).astype(np.int32)
    coefficients, normals = rng.normal(size=(n, 4)), rng.normal(size=(n, 3))
    heads, chain = np.full(n_vertices, -7, np.int32), np.full(4 * n, -7, np.int32)
    zone = Zone(ALONE, first, nodes, coefficients, normals, np.zeros(n), heads, chain)
    link_entries(zone)
    matrix = np.zeros((n, n_vertices, 3))
    for j, k in np.argwhere(nodes >= 0):
        matrix[j, nodes[j, k] - first] = coefficients[j, k] * normals[j]
    return zone, matrix


@pytest.mark.parametrize("first", [0, 2])
@pytest.mark.parametrize("n", [1, 2, 25])
def test_products_are_those_of_the_matrix(rng, n, first):
    zone, matrix = random_zone(rng, n, 8, first)
    u, z, flat = rng.normal(size=n), np.full(24, np.nan), matrix.reshape(n, 24)
    pull(zone, u, z)
    # n terms of three factors in both sums: n + 3 roundings of each, to first order
    bound = 2 * (n + 3) * 2.0**-53
    assert (np.abs(z - flat.T @ u) <= bound * (np.abs(flat.T) @ np.abs(u))).all()
    found = [product(zone, j, z) for j in range(n)]
    bound = 2 * (24 + 3) * 2.0**-53
    assert (np.abs(found - flat @ z) <= bound * (np.abs(flat) @ np.abs(z))).all()


@pytest.mark.parametrize("first", [0, 2])
@pytest.mark.parametrize("n", [1, 2, 25])
def test_rows_are_those_of_the_gram_matrix(rng, n, first):
    zone, matrix = random_zone(rng, n, 8, first)
    shares = np.einsum("iva,jva->ijv", matrix, matrix)  # of each vertex
    sizes = np.einsum("iva,jva->ij", np.abs(matrix), np.abs(matrix))
    # 24 terms of five factors in both sums of an entry; a row adds 4 n terms
    bound = 2 * (24 + 5 + 4 * n) * 2.0**-53
    places = np.where(rng.random(n) < 0.7, rng.permutation(n), -1).astype(np.int32)
    for i in range(n):
        expected = np.abs(shares[i]).sum()
        assert abs(row_sum(zone, i) - expected) <= bound * sizes[i].sum()
        if places[i] >= 0:
            row = np.full(2 * n, 0.5)
            add_gram_row(zone, i, places, row, 2)
            assert (row[1::2] == 0.5).all()
            for j in range(n):
                is_before = 0 <= places[j] <= places[i]
                expected = 0.5 + (shares[i, j].sum() if is_before else 0.0)
                found = row[2 * places[j]] if places[j] >= 0 else 0.5
                assert abs(found - expected) <= bound * (0.5 + sizes[i, j])
