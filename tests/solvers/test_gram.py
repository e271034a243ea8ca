"""Products of the constraints of a zone, compared with those of dense rows."""

import numpy as np

from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial.gram import gram_products
from izo_ref.zones.system import problem_system
from tests.helpers.shapes import random_problem
from validation.scenes.piles import stack_zone


def check(problem):
    """Compare the products of all pairs of constraints that share an unknown with dense algebra."""
    system, _ = problem_system([problem])
    rows = scale_constraints(system)
    n, m = int(system.vertex_offsets[-1]), len(rows.rhs)
    nodes = np.where(rows.unknowns < n, rows.unknowns, -1)
    matrix = np.zeros((m, n + 1, 3))
    for j, k in np.ndindex(m, 4):
        matrix[j, nodes[j, k]] += rows.coefficients[j, k] * system.normals[j]
    matrix = matrix[:, :n].reshape(m, 3 * n)
    pairs, products = gram_products(nodes, rows.coefficients, system.normals, n)
    assert (pairs[:, 0] <= pairs[:, 1]).all()
    assert len(np.unique(pairs, axis=0)) == len(pairs)
    diagonal = pairs[:, 0] == pairs[:, 1]
    np.testing.assert_array_equal(pairs[diagonal, 0], np.arange(m))
    found = np.zeros((m, m))
    found[pairs[:, 0], pairs[:, 1]] = products
    found[pairs[:, 1], pairs[:, 0]] = products
    # Each product is a sum of at most 12 products of numbers of at most 1, in two orders.
    np.testing.assert_allclose(found, matrix @ matrix.T, rtol=0.0, atol=24 * 2.0**-52)


def test_products_of_random_constraints_are_those_of_dense_rows(rng):
    check(random_problem(rng, 40))


def test_products_with_pinned_vertices_are_those_of_dense_rows(rng):
    check(stack_zone(rng, 3, 5))
