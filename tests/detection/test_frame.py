"""Weights and normals of impacts."""

import numpy as np
import pytest

import izo_ref
from izo_ref.detection.cpu.frames import renew_tight_frames
from tests.helpers.shapes import two_sheets, vertex_over_face


def test_a_frame_is_the_one_worked_out_by_hand():
    impacts = izo_ref.find_impacts(vertex_over_face())
    i = np.flatnonzero((impacts.nodes == [3, 0, 1, 2]).all(axis=1))
    assert len(i) == 1
    assert impacts.toi[i] == pytest.approx([0.5])
    np.testing.assert_allclose(impacts.weights[i], [[1, -0.5, -0.25, -0.25]], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(impacts.normals[i], [[0, 0, 1]], rtol=0.0, atol=1e-12)


def crossing_edges(first, second, approach):
    """Return a scene in which edge 0 1 meets edge 2 3 at the origin, halfway, and nothing else.

    Edge 0 1 is parallel to `first`. It starts 1 m off, on the side of the unit vector `approach`,
    and moves by 2 m against it. Edge 2 3 is parallel to `second` and at rest. The third vertices of
    the two faces are far away, on the two sides.
    """
    first, second, approach = np.array(first), np.array(second), np.array(approach)
    above = [-0.5 * first, 1.5 * first, 9.0 * approach]
    below = [-1.5 * second, 0.5 * second, -9.0 * approach]
    start = np.array([*above, *below])[[0, 1, 3, 4, 2, 5]]
    moved = np.array([1, 1, 0, 0, 1, 0])[:, None] * approach
    return izo_ref.Scene(start + moved, start - moved, [[0, 1, 4], [2, 3, 5]])


X, Y, Z = np.eye(3)


@pytest.mark.parametrize(
    ("first", "second", "approach", "normal"),
    [
        (X, Y, Z, (0, 0, 1)),
        (X, Y, -Z, (0, 0, -1)),
        (Y, X, Z, (0, 0, 1)),  # the cross product of the edges is -z
        (Y, Z, -X, (-1, 0, 0)),
        (X + Y, X - Y, Z, (0, 0, 1)),
        (X, Y + Z, Z, (0, -np.sqrt(0.5), np.sqrt(0.5))),  # moves obliquely to its normal
    ],
)
def test_a_frame_of_two_edges_is_the_one_worked_out_by_hand(first, second, approach, normal):
    impacts = izo_ref.find_impacts(crossing_edges(first, second, approach))
    assert impacts.nodes.tolist() == [[0, 1, 2, 3]]
    assert impacts.is_edge_edge.all()
    assert impacts.toi == pytest.approx([0.5])
    np.testing.assert_allclose(impacts.weights, [[0.75, 0.25, -0.25, -0.75]], atol=1e-12)
    np.testing.assert_allclose(impacts.normals, [normal], atol=1e-12)


def test_the_normal_of_two_edges_is_orthogonal_to_both(rng):
    """Bound of the rounding, with u = 2^-53, the largest coordinate X and the angle of the edges.

    Let a, b be the edges in floats from which the normal is the cross product. A component of the
    product has an error of 4 u |a| |b|, so the product has one of 7 u |a| |b|. Over its length
    |a| |b| sin(angle), that is 7 u / sin(angle); making it a unit vector adds 4 u. So its product
    with a unit vector along a or b is at most (7 / sin(angle) + 4) u. An edge of two nodes relative
    to a third one has components of at most 4 X. Each of the two ways to compute it, that of the
    detector and the one below, is off by at most 6 roundings of that size: together 48 u X in a
    component, and 84 u X in length. The bound has 8 and 96 for the terms in u^2.
    """
    scene = two_sheets(rng, 10)
    impacts = izo_ref.find_impacts(scene)
    impacts = impacts.take(impacts.is_edge_edge & (impacts.weights != 0.0).all(axis=1))
    assert len(impacts.toi) > 50
    toi = impacts.toi[:, None, None]
    x = (1 - toi) * scene.positions_t0[impacts.nodes] + toi * scene.positions_t1[impacts.nodes]
    first, second = x[:, 1] - x[:, 0], x[:, 3] - x[:, 2]
    lengths = np.linalg.norm([first, second], axis=2)
    sines = np.linalg.norm(np.cross(first, second), axis=1) / lengths.prod(axis=0)
    largest = max(np.abs(scene.positions_t0).max(), np.abs(scene.positions_t1).max())
    for edge, length in zip((first, second), lengths, strict=True):
        off = np.abs((impacts.normals * edge).sum(axis=1))
        assert (off <= 2.0**-53 * (8.0 * (1.0 / sines + 1.0) * length + 96.0 * largest)).all()


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


def test_tight_impacts_alone_get_the_frame_at_their_closest_points():
    """Two equal impacts at the thickness are both tight, whichever of them pushes."""
    positions = np.array([[0.2, 0.2, 0.1], [0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, 0.2]])
    nodes = np.array([[0, 1, 2, 3], [0, 1, 2, 3], [4, 1, 2, 3], [4, 1, 2, 3]], np.int32)
    weights = np.tile([1.0, -0.4, -0.3, -0.3], (4, 1))
    normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.8, 0.6]])
    before = weights.copy(), normals.copy()
    renew_tight_frames(positions, nodes, np.zeros(4, bool), 0.1, weights, normals)
    np.testing.assert_allclose(weights[:2], [[1.0, -0.6, -0.2, -0.2]] * 2, atol=1e-15)
    np.testing.assert_allclose(normals[:2], [[0.0, 0.0, 1.0]] * 2, atol=1e-15)
    np.testing.assert_array_equal(weights[2], before[0][2])
    np.testing.assert_array_equal(normals[2], before[1][2])
    # the last impact has slack along the true normal, but none along its own
    np.testing.assert_allclose(normals[3], [0.0, 0.0, 1.0], atol=1e-15)
