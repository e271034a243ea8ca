"""Which impacts are between pinned points."""

import numpy as np

from izo_ref.detection.serial.prescribed import prescribed_impacts


def test_an_impact_is_prescribed_if_its_unpinned_vertices_have_no_weight(rng):
    """Below a weight of 1e-9 in all, they would have to move a billion times the gap."""
    nodes = np.array([rng.choice(12, 4, replace=False) for _ in range(200)], np.int32)
    weights, pinned = rng.normal(size=(200, 4)), rng.random(12) < 0.6
    weights[::3] *= np.where(pinned[nodes[::3]], 1.0, 1e-12)
    found = np.empty(200, bool)
    prescribed_impacts(nodes, weights, pinned, found)
    unpinned = (np.abs(weights) * ~pinned[nodes]).sum(axis=1)
    np.testing.assert_array_equal(found, unpinned < 1e-9)
    assert 20 < found.sum() < 180
    for weight, expected in ((0.9e-9, True), (1.1e-9, False)):
        one = np.array([[weight, weight - 1.0, 0.5, 0.5 - 2.0 * weight]])
        held = np.array([False, True, True, True])
        prescribed_impacts(np.arange(4, dtype=np.int32)[None], one, held, found[:1])
        assert found[0] == expected
