"""Pairs whose nodes are coplanar at the start: what happens right after, and until the end."""

import numpy as np
import pytest

from izo_ref.detection.formulas.touching import (
    UNKNOWN,
    is_apart_after_start,
    volume_sign_after_start,
)


def relative(a, b):
    """Return nodes 1 to 3 at both ends, as tuples."""
    return [tuple(row) for row in (*a.tolist(), *b.tolist())]


def volume(a, b, t):
    return np.linalg.det((1.0 - t) * a + t * b)


@pytest.mark.parametrize("size", [1.0, 1e-90, 1e90])
def test_the_sign_right_after_the_start_is_that_of_the_slope(rng, size):
    signs = {-1: 0, 1: 0}
    for _ in range(100):
        a, b = rng.integers(-5, 6, (2, 3, 3)).astype(float)
        a[2] = a[0] + a[1]  # coplanar with node 0
        slope = sum(np.linalg.det(np.where(np.arange(3)[:, None] == k, b, a)) for k in range(3))
        found = volume_sign_after_start(0, *relative(size * a, size * b))
        if abs(slope) < 0.5:
            assert found == UNKNOWN
        else:
            assert found == np.sign(slope)
            signs[found] += 1
        for known in (-1, 1):
            assert volume_sign_after_start(known, *relative(size * a, size * b)) == known
    assert min(signs.values()) > 20


@pytest.mark.parametrize("size", [1.0, 1e-90, 1e90])
def test_a_pair_is_apart_after_the_start_if_its_volume_keeps_its_sign(rng, size):
    counts = {True: 0, False: 0}
    for _ in range(300):
        a, b = rng.normal(size=(2, 3, 3))
        a = np.round(8.0 * a) / 8.0  # sums are exact
        a[2] = a[0] + a[1]
        found = is_apart_after_start(*relative(size * a, size * b))
        counts[found] += 1
        if found:
            signs = {np.sign(volume(a, b, t)) for t in np.linspace(0.01, 1.0, 34)}
            assert len(signs) == 1
    assert min(counts.values()) > 50
    up = np.array([[1.0, 0, 0], [0, 1.0, 0], [1.0, 1.0, 0]])
    for side in (1.0, -1.0):
        rises, returns = up.copy(), up.copy()
        rises[2, 2] = side
        assert is_apart_after_start(*relative(up, rises))
        assert not is_apart_after_start(*relative(up, returns))
