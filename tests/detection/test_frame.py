"""Weights and normals of impacts."""

import numpy as np
import pytest

import izo_ref
from tests.helpers.shapes import two_sheets, vertex_over_face


def test_a_frame_is_the_one_worked_out_by_hand():
    impacts = izo_ref.find_impacts(vertex_over_face())
    i = np.flatnonzero((impacts.nodes == [3, 0, 1, 2]).all(axis=1))
    assert len(i) == 1
    assert impacts.toi[i] == pytest.approx([0.5])
    np.testing.assert_allclose(impacts.weights[i], [[1, -0.5, -0.25, -0.25]], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(impacts.normals[i], [[0, 0, 1]], rtol=0.0, atol=1e-12)


def test_every_frame_has_a_unit_normal_and_a_gap_that_changes_sign(rng):
    scene = two_sheets(rng, 10)
    impacts = izo_ref.find_impacts(scene)
    assert len(impacts.toi) > 50
    np.testing.assert_allclose(impacts.weights.sum(axis=1), 0.0, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(impacts.normals, axis=1), 1.0, rtol=0.0, atol=1e-12)
    first = np.where(impacts.is_edge_edge, 2, 1)
    for weights, k in zip(impacts.weights, first, strict=True):
        assert (weights[:k] >= 0).all()
        assert (weights[k:] <= 0).all()

    def gaps(t):
        """Return the signed gap of each impact at time t."""
        x = (1 - t) * scene.positions_t0[impacts.nodes] + t * scene.positions_t1[impacts.nodes]
        return np.einsum("jk,jkx,jx->j", impacts.weights, x, impacts.normals)

    assert (gaps(0.0) > 0.0).all()
    np.testing.assert_allclose(gaps(impacts.toi[:, None, None]), 0.0, rtol=0.0, atol=1e-12)
    assert (gaps(1.0) < 0.0).all()


def test_a_contact_within_a_plane_gets_a_normal_in_the_plane():
    start = np.array([[-1, 0.2, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0.0], [-1, 0.2, 5], [-2, 0.2, 5]])
    end = start.copy()
    end[0, 0] = 1.0
    impacts = izo_ref.find_impacts(izo_ref.Scene(start, end, [[1, 2, 3], [0, 4, 5]]))
    i = np.flatnonzero((impacts.nodes == [0, 1, 2, 3]).all(axis=1))
    np.testing.assert_allclose(impacts.normals[i], [[-1, 0, 0]], rtol=0.0, atol=1e-9)
