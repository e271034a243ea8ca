"""The cubic of coplanar nodes: no root is passed over, and simple roots are found."""

import numpy as np
import pytest

from izo_ref.detection.formulas.coplanar import (
    bernstein_coefficients,
    crosses_soon,
    hull_root_bound,
    newton_root,
    root_free_until,
    split,
)

ERROR = 1e-14  # covers the rounding of coefficients that are computed from roots


def from_roots(roots, scale=1.0):
    """Return the Bernstein coefficients on [0, 1] of scale times the product of all (t - r)."""
    r, s, q = roots
    e1, e2, e3 = r + s + q, r * s + s * q + q * r, r * s * q
    return (
        scale * -e3,
        scale * (-e3 + e2 / 3),
        scale * (-e3 + 2 * e2 / 3 - e1 / 3),
        scale * (1 - e1 + e2 - e3),
    )


def value(c, t):
    """Return the value of a cubic from its definition, the sum of Bernstein polynomials."""
    s = 1.0 - t
    return c[0] * s**3 + 3 * c[1] * s * s * t + 3 * c[2] * s * t * t + c[3] * t**3


def test_coefficients_are_those_of_the_volume_on_the_path(rng):
    for _ in range(50):
        a, b = rng.integers(-5, 6, (2, 3, 3)).astype(float)
        c = bernstein_coefficients(*(tuple(row.tolist()) for row in (*a, *b)))
        for t in (0.0, 0.25, 0.5, 0.75, 1.0):
            expected = np.linalg.det((1.0 - t) * a + t * b)
            assert value(c, t) == pytest.approx(expected, abs=1e-11)


def test_both_parts_of_a_cubic_are_the_cubic(rng):
    for _ in range(50):
        c, t = tuple(rng.normal(size=4).tolist()), float(rng.random())
        head, rest = split(c, t)
        for x in (0.0, 0.3, 0.6, 1.0):
            assert value(head, x) == pytest.approx(value(c, x * t), abs=1e-14)
            assert value(rest, x) == pytest.approx(value(c, t + x * (1.0 - t)), abs=1e-14)


def roots_of(rng):
    """Draw three roots: anywhere, near each other, or double."""
    roots = rng.uniform(-0.5, 1.5, 3)
    kind = rng.integers(3)
    if kind == 1:
        roots[1] = roots[0] + 10.0 ** rng.uniform(-8, -1)
    elif kind == 2:
        roots[1] = roots[0]
    return roots


def test_no_root_is_passed_over_and_most_are_reached(rng):
    reached = simple = 0
    for _ in range(1500):
        roots, t = roots_of(rng), float(rng.choice([0.0, rng.random()]))
        c = from_roots(roots, rng.choice([-1.0, 1.0]))
        ahead = roots[(roots > t) & (roots <= 1.0)]
        first = ahead.min() if len(ahead) else 2.0
        found = root_free_until(c, t, ERROR)
        assert found >= t
        assert found <= first + 1e-15
        double = np.diff(np.sort(roots)).min() < 1e-3
        far = np.abs(roots - t).min() > 1e-3 and np.abs(roots - 1.0).min() > 1e-3
        if far and not double:
            simple += 1
            reached += abs(found - first) < 1e-6
    print(f"{reached} of {simple} simple roots are reached at once")
    assert simple > 500
    assert reached > 0.88 * simple


def test_the_hull_is_left_before_the_first_root(rng):
    none = 0
    for _ in range(1000):
        roots = roots_of(rng)
        c = from_roots(roots)
        if abs(c[0]) < 1e-3:
            continue
        sign = 1.0 if c[0] > 0.0 else -1.0
        inside = roots[(roots >= 0.0) & (roots <= 1.0)]
        first = inside.min() if len(inside) else 2.0
        found = hull_root_bound(c, sign, ERROR)
        assert 0.0 < found <= first
        points = [(k / 3, sign * c[k] - ERROR) for k in range(4)]
        falls = [
            x0 + (x1 - x0) * y0 / (y0 - y1)
            for i, (x0, y0) in enumerate(points)
            for x1, y1 in points[i + 1 :]
            if y0 > 0.0 >= y1
        ]
        assert found == pytest.approx(min(falls, default=2.0), abs=1e-12)
        none += not falls
        assert hull_root_bound(c, -sign, ERROR) == 0.0
    assert none > 20


def test_newton_ends_where_the_cubic_is_twice_its_error(rng):
    found = 0
    for _ in range(300):
        c = from_roots(roots_of(rng), 3.0)
        sign = 1.0 if c[0] > 0.0 else -1.0
        for error in (1e-14, 1e-4):
            x = newton_root(c, sign, error)
            if x != 2.0:
                found += 1
                assert sign * value(c, x) == pytest.approx(
                    2.0 * error, abs=1e-9 * (1 + abs(x) ** 3)
                )
    print(f"{found} of 600")
    assert found > 100


@pytest.mark.parametrize("scale", [1.0, -1.0])
def test_a_cubic_crosses_soon_if_a_root_with_a_slope_is_near(scale):
    for root, t, expected in (
        (0.5, 0.5 - 1e-12, True),
        (0.5, 0.5 - 1e-10, True),
        (0.5, 0.5 - 1e-6, False),
        (0.5, 0.5 + 1e-6, False),
        (0.999, 0.999 - 0.9e-9, True),
        (0.999, 0.999 - 1.1e-9, False),
    ):
        assert crosses_soon(from_roots((root, 3.0, -2.0), scale), t, 1e-15) is expected
    assert not crosses_soon(from_roots((0.5, 0.5, 3.0), scale), 0.5 - 1e-10, 1e-15)
