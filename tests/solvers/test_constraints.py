"""Constraints in scaled variables and the numbers that solvers judge themselves by, in numpy."""

import math

import numpy as np
import pytest

from izo_ref.solvers.serial import constraints, interior

FIRST = 4  # unknowns of the zone begin here


def zone(rng, m=8, n=5):
    """Draw a zone of m constraints on n vertices, some of which are pinned, and its matrix."""
    nodes = np.array([rng.choice(n, 4, replace=False) for _ in range(m)], np.int32) + FIRST
    nodes[rng.random((m, 4)) < 0.2] = -1
    coefficients, normals = rng.normal(size=(m, 4)), rng.normal(size=(m, 3))
    matrix = np.zeros((m, 3 * n))
    for j, k in np.argwhere(nodes >= 0):
        at = 3 * (nodes[j, k] - FIRST)
        matrix[j, at : at + 3] += coefficients[j, k] * normals[j]
    return (FIRST, nodes, coefficients, normals), matrix


def test_products_with_the_matrix_are_those_of_numpy(rng):
    for _ in range(20):
        own, matrix = zone(rng)
        m, n = matrix.shape
        z, u, s = rng.normal(size=n), rng.normal(size=m) * (rng.random(m) < 0.7), rng.normal(size=m)
        out, pulled, missing = np.empty(m), np.full(n, 9.0), np.empty(m)
        constraints.products(*own, z, out)
        constraints.pull(*own, u, pulled)
        constraints.violations(*own, s, z, missing)
        np.testing.assert_allclose(out, matrix @ z, atol=1e-13)
        np.testing.assert_allclose(pulled, matrix.T @ u, atol=1e-13)
        np.testing.assert_allclose(missing, s - matrix @ z, atol=1e-13)
        before = z.copy()
        constraints.add_constraint(2.5, 3, *own, z)
        np.testing.assert_allclose(z, before + 2.5 * matrix[3], atol=1e-13)


def test_residuals_are_the_violation_in_metres_and_the_relative_gap(rng):
    for _ in range(20):
        own, matrix = zone(rng)
        m, n = matrix.shape
        z, u, s, metres = rng.normal(size=n), rng.random(m), rng.normal(size=m), rng.random(m)
        missing = s - matrix @ z
        violation, gap = constraints.residuals(*own, s, metres, u, z)
        assert violation == pytest.approx(max(0.0, (missing * metres).max()))
        assert gap == pytest.approx(u @ np.abs(missing) / (0.5 * z @ z))
    still, ones = np.zeros(n), np.ones(m)
    assert constraints.residuals(*own, ones, ones, 0.0 * ones, still) == (1.0, 0.0)
    assert constraints.residuals(*own, ones, ones, ones, still) == (1.0, math.inf)


def test_the_size_of_a_constraint_bounds_its_terms(rng):
    for _ in range(20):
        (first, nodes, coefficients, _), matrix = zone(rng)
        m, n = matrix.shape
        z, s = rng.normal(size=n), rng.normal(size=m)
        lengths = np.linalg.norm(z.reshape(-1, 3), axis=1)
        for j in range(m):
            used = nodes[j] >= 0
            expected = abs(s[j]) + np.abs(coefficients[j, used]) @ lengths[nodes[j, used] - first]
            found = constraints.constraint_size(j, first, nodes, coefficients, s, z)
            assert found == pytest.approx(expected)


def test_a_scaled_constraint_has_unit_length_and_the_same_meaning(rng):
    for _ in range(20):
        nodes = np.array([[2, 0, 3, 1]], np.int32)
        inside = rng.dirichlet([1.0, 1.0, 1.0])
        weights, normals = np.array([[1.0, *-inside]]), rng.normal(size=(1, 3))
        proposed, inverse = rng.normal(size=(4, 3)), rng.uniform(0.5, 2.0, 4)
        inverse[rng.integers(4)] = 0.0
        unknowns, scaled = np.empty((1, 4), np.int32), np.empty((1, 4))
        own = 0, nodes, weights, normals, proposed, inverse, 0.1, unknowns, scaled
        s, length, hopeless = constraints.scale_constraint(*own)
        assert not hopeless
        np.testing.assert_array_equal(unknowns[0], np.where(inverse[nodes[0]] > 0.0, nodes[0], -1))
        assert np.linalg.norm(scaled) * np.linalg.norm(normals) == pytest.approx(1.0)
        np.testing.assert_allclose(length * scaled[0], weights[0] * inverse[nodes[0]])
        gap = normals[0] @ (weights[0] @ proposed[nodes[0]])
        assert length * s == pytest.approx(0.1 - gap)
        held = np.zeros(4)
        for thickness, expected in ((gap - 1e-6, False), (gap + 1e-6, True)):
            own = 0, nodes, weights, normals, proposed, held, thickness, unknowns, scaled
            assert constraints.scale_constraint(*own) == (-thickness, 1.0, expected)
            assert unknowns.tolist() == [[-1] * 4]


def test_the_interior_point_measures_itself_as_numpy_does(rng):
    for _ in range(20):
        m, n = 6, 9
        z, pull, rows, s, slack = (rng.normal(size=k) for k in (n, n, m, m, m))
        multipliers, dual, primal = rng.random(m), np.empty(n), np.empty(m)
        violation, objective, gap, bound = interior.residuals(
            z, pull, rows, s, slack, multipliers, dual, primal
        )
        np.testing.assert_array_equal(dual, z - pull)
        np.testing.assert_allclose(primal, rows - slack - s, atol=1e-15)
        assert violation == pytest.approx((s - rows).max())
        assert objective == pytest.approx(0.5 * z @ z)
        expected = 0.5 * (z - pull) @ (z - pull) + multipliers @ np.abs(rows - s)
        assert gap == pytest.approx(expected)
        assert bound == pytest.approx(multipliers @ s / np.linalg.norm(pull))


def test_a_step_to_the_boundary_makes_the_first_number_zero(rng):
    for _ in range(20):
        slack, multipliers = rng.uniform(0.5, 1.0, (2, 6))
        dw, du = rng.normal(size=(2, 6))
        length = interior.to_boundary(slack, multipliers, dw, du)
        least = min((slack + length * dw).min(), (multipliers + length * du).min())
        assert least == pytest.approx(0.0, abs=1e-13)
    assert interior.to_boundary(slack, multipliers, np.abs(dw), np.zeros(6)) == math.inf
