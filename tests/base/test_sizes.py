"""Which sizes are computed as they are, which are scaled, and which are refused: the borders."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from izo_ref.base.errors import MassError, SizeError, ThicknessError
from izo_ref.base.sizes import path_in_range, positions_back, scene_in_range, thickness_in_range
from izo_ref.base.units import Units

FACE = np.array([[1.0, 0.5, 0.25], [0.0, 0.125, 0.0], [0.5, 0.0, -0.75]])


def mesh(size, unused=(), end=None, masses=None):
    """Return a mesh of one face, whose largest coordinate is `size`, and of unused vertices."""
    start = np.concatenate((size * FACE, np.reshape(unused, (-1, 3))))
    n = len(start)
    return SimpleNamespace(
        positions_t0=start,
        positions_t1=start if end is None else end,
        masses=np.ones(n) if masses is None else np.array(masses),
        pinned=np.zeros(n, bool),
        faces=np.arange(3, dtype=np.int32)[None],
        on_gpu={},
    )


@pytest.mark.parametrize(
    ("size", "exponent"),
    [
        (1.0, 0),
        (2.0**99, 0),
        (np.nextafter(2.0**100, 0.0), 0),
        (2.0**100, -1),
        (2.0**150, -51),
        (2.0**1000, -901),
        (2.0**-100, 0),
        (2.0**-101, 0),
        (2.0**-102, 1),
        (2.0**-1000, 899),
    ],
)
def test_lengths_are_scaled_into_range_and_come_back(size, exponent):
    scene = mesh(size)
    twin, units = scene_in_range(scene)
    assert units == Units(exponent, 0)
    assert (twin is scene) == (exponent == 0)
    np.testing.assert_array_equal(twin.positions_t0, np.ldexp(scene.positions_t0, exponent))
    path, end = path_in_range(scene, 0.5 * scene.positions_t0)
    assert (path is scene) == (exponent == 0)
    np.testing.assert_array_equal(end, 0.5 * path.positions_t0)
    back = positions_back(scene, twin, 0.5 * twin.positions_t1, units)
    np.testing.assert_array_equal(back, 0.5 * scene.positions_t1)


def test_a_mesh_is_refused_beyond_the_border_and_not_at_it():
    for size in (2.0**1000, 2.0**-1000):
        scene_in_range(mesh(size))
    with pytest.raises(SizeError, match="first is vertex 0"):
        scene_in_range(mesh(np.nextafter(2.0**1000, np.inf)))
    with pytest.raises(SizeError, match="at least"):
        scene_in_range(mesh(np.nextafter(2.0**-1000, 0.0)))


def test_coordinates_that_would_lose_digits_are_refused():
    """A mesh of 2^900 is multiplied by 2^-801, where the least float is 2^-1074."""
    scene = mesh(2.0**900)
    scene.positions_t0[1, 2] = 2.0**-273
    scene_in_range(scene)
    scene.positions_t0[1, 2] = 2.0**-274
    with pytest.raises(SizeError, match="at vertex 1; set them to 0"):
        scene_in_range(scene)


@pytest.mark.parametrize("size", [1.0, 2.0**40, 2.0**-40])
def test_unused_vertices_stay_within_a_border_around_the_mesh(size):
    """The border is 2^100 times the power of two above the size of the mesh."""
    border = 2.0 * size * 2.0**100
    near = mesh(size, [[border, 0.0, 0.0]])
    assert scene_in_range(near)[0] is near
    twin, _ = scene_in_range(mesh(size, [[2.0 * border, 0.0, -(2.0**1000)]]))
    assert twin.positions_t0[3].tolist() == [border, 0.0, -border]
    np.testing.assert_array_equal(twin.positions_t0[:3], size * FACE)
    scene = mesh(size, [[4.0 * border, 0.0, 0.0]])
    scene.positions_t1 = scene.positions_t0.copy()
    scene.positions_t1[3, 0] = border
    with pytest.raises(SizeError, match="vertex 3"):
        scene_in_range(scene)


def test_a_thickness_is_measured_against_the_larger_end():
    start = mesh(1.0)
    for end in (1.0, 2.0**30, 2.0**-30):
        scene = mesh(1.0, end=end * FACE)
        exponent = math.frexp(max(1.0, end))[1]
        most, least = 2.0 ** (exponent + 200), 2.0 ** (exponent - 300)
        for thickness in (1e-3, most, least):
            assert thickness_in_range(thickness, scene, Units()) == thickness
        for thickness in (np.nextafter(most, np.inf), np.nextafter(least, 0.0)):
            with pytest.raises(ThicknessError):
                thickness_in_range(float(thickness), scene, Units())
    assert thickness_in_range(2.0**-60, start, Units(length=50)) == 2.0**-10


def test_masses_may_differ_by_two_to_the_hundredth():
    scene_in_range(mesh(1.0, masses=[2.0**50, 2.0**-50, 1.0]))
    with pytest.raises(MassError, match="at vertex 1"):
        scene_in_range(mesh(1.0, masses=[2.0**50, np.nextafter(2.0**-50, 0.0), 1.0]))
    twin, units = scene_in_range(mesh(1.0, masses=[2.0**299, 2.0**301, 2.0**300]))
    assert units.mass % 2 == 0
    np.testing.assert_array_equal(twin.masses, np.ldexp([2.0**299, 2.0**301, 2.0**300], units.mass))
    assert 2.0**-200 < twin.masses.min() < twin.masses.max() < 2.0**200
