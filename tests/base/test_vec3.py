"""Vectors of three numbers, against numpy; whole numbers have no rounding."""

import math

import numpy as np
import pytest

from izo_ref.base.formulas.vec3 import (
    cross3,
    det3,
    dot3,
    lerp3,
    max_abs3,
    power_of_two_for,
    scale3,
    sub3,
    sum_abs3,
    unit3,
)


def test_products_and_norms_are_those_of_numpy(rng):
    for _ in range(50):
        a, b, c = rng.integers(-9, 10, (3, 3)).astype(float)
        x, y, z = (tuple(v.tolist()) for v in (a, b, c))
        assert sub3(x, y) == tuple(a - b)
        assert scale3(-3.0, x) == tuple(-3.0 * a)
        assert dot3(x, y) == a @ b
        assert cross3(x, y) == tuple(np.cross(a, b))
        assert det3(x, y, z) == a @ np.cross(b, c)
        assert max_abs3(x) == np.abs(a).max()
        assert sum_abs3(x) == np.abs(a).sum()
        assert lerp3(x, y, 0.25) == tuple(0.75 * a + 0.25 * b)


def test_a_segment_begins_and_ends_exactly_at_its_ends(rng):
    for _ in range(20):
        a, b = (tuple(v) for v in rng.normal(size=(2, 3)).tolist())
        assert lerp3(a, b, 0.0) == a
        assert lerp3(a, b, 1.0) == b


@pytest.mark.parametrize("size", [1.0, 0.5, 0.75, 3.0, 1e-300, 1e300, 5e-324])
def test_a_size_is_scaled_to_near_one(size):
    factor = power_of_two_for(size)
    assert math.frexp(factor)[0] == 0.5
    assert factor <= 2.0**1000
    assert factor * size < 1.0
    assert factor * size >= 0.5 or factor == 2.0**1000


@pytest.mark.parametrize("size", [1.0, 1e-300, 1e300, 5e-324])
def test_a_direction_has_length_one_at_any_size(rng, size):
    for axis in range(3):
        a = rng.uniform(-1.0, 1.0, 3)
        a[axis] = 2.0
        unit = np.array(unit3(tuple((size * a).tolist())))
        assert np.linalg.norm(unit) == pytest.approx(1.0, abs=1e-15)
        if size > 1e-310:
            np.testing.assert_allclose(unit, a / np.linalg.norm(a), rtol=0.0, atol=1e-15)
    assert unit3((0.0, 0.0, 0.0)) == (0.0, 0.0, 0.0)
