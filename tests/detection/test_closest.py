"""The closest points of a pair, against a search over all features, and the normal there."""

import numpy as np
import pytest

from izo_ref.detection.formulas.closest import pair_weights, weighted_sum
from izo_ref.detection.formulas.frame import feature_normal, plane_normal
from tests.naive.closest import closest_vector


def draw(rng):
    """Draw nodes 1 to 3 relative to node 0; closest points are on features of all kinds."""
    q = rng.normal(size=(3, 3)) * rng.choice([0.3, 1.0, 3.0], (3, 1))
    return q + rng.choice([0.0, 1.0]) * rng.normal(size=3)


@pytest.mark.parametrize("is_edge_edge", [False, True])
def test_weights_name_the_closest_points(rng, is_edge_edge):
    zeros = set()
    for _ in range(600):
        q = draw(rng)
        rows = [tuple(row) for row in q.tolist()]
        weights = pair_weights(is_edge_edge, *rows)
        sides = (weights[:2], weights[2:]) if is_edge_edge else (weights[:1], weights[1:])
        assert sum(sides[0]) == pytest.approx(1.0, abs=1e-15)
        assert sum(sides[1]) == pytest.approx(-1.0, abs=1e-15)
        assert min(sides[0]) >= 0.0 >= max(sides[1])
        between = np.array(weighted_sum(weights, *rows))
        np.testing.assert_allclose(between, np.array(weights[1:]) @ q, rtol=0.0, atol=1e-14)
        expected = np.linalg.norm(closest_vector(is_edge_edge, np.vstack((np.zeros(3), q))))
        assert np.linalg.norm(between) == pytest.approx(float(expected), abs=1e-9)
        zeros.add(tuple(weight == 0.0 for weight in weights))
    assert len(zeros) == (9 if is_edge_edge else 7)  # every pair of features occurs


@pytest.mark.parametrize("is_edge_edge", [False, True])
def test_the_normal_is_that_of_the_features_with_the_closest_points(rng, is_edge_edge):
    counts = {"both": 0, "one": 0, "none": 0}
    for _ in range(600):
        q = draw(rng)
        rows = [tuple(row) for row in q.tolist()]
        weights = pair_weights(is_edge_edge, *rows)
        n = np.array(weights[1:]) @ q
        n /= np.linalg.norm(n)
        m = np.array(feature_normal(is_edge_edge, weights, *rows, tuple(n.tolist())))
        assert np.linalg.norm(m) == pytest.approx(1.0, abs=1e-14)
        edges = {0: q[0], 1: q[2] - q[1]} if is_edge_edge else {}
        inside = [k for k in edges if all(w != 0.0 for w in weights[2 * k : 2 * k + 2])]
        if not is_edge_edge:
            edges = {3: q[1] - q[0], 1: q[2] - q[1], 2: q[0] - q[2]}
            zero = [k for k in (1, 2, 3) if weights[k] == 0.0]
            inside = [0, 1] if not zero else zero[:1] if len(zero) == 1 else []
        if len(inside) == 2:
            counts["both"] += 1
            plane = np.array(plane_normal(is_edge_edge, *rows))
            assert abs(m @ plane) == pytest.approx(1.0, abs=1e-14)
            assert m @ n > 0.0
        elif len(inside) == 1:
            counts["one"] += 1
            edge = edges[inside[0]]
            assert abs(m @ edge) < 1e-14 * np.linalg.norm(edge)
            assert m @ n > 1.0 - 1e-9
        else:
            counts["none"] += 1
            assert m @ n > 1.0 - 1e-9 or not is_edge_edge
    assert min(counts.values()) > 20, counts
