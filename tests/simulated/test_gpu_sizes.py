"""Steps of extraordinary size on a GPU, compared with the same steps near 1."""

import numpy as np
import pytest

import izo_ref
from izo_ref.base.gpu_arrays import to_cpu, to_gpu
from tests.helpers.shapes import two_sheets

pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


@pytest.mark.parametrize("length", [-700, 700])
def test_arrays_of_a_gpu_have_the_same_bits_at_any_size(length):
    scene = two_sheets(np.random.default_rng(0), 3)
    other = izo_ref.resolve(scene, 1e-3, device="cuda")
    assert len(other.impacts.toi)
    start, end = (to_gpu(np.ldexp(p, length)) for p in (scene.positions_t0, scene.positions_t1))
    scaled = izo_ref.Scene(start, end, scene.faces, scene.masses)
    result = izo_ref.resolve(scaled, float(np.ldexp(1e-3, length)), device="cuda")
    assert result.status is other.status
    assert np.array_equal(result.positions, np.ldexp(other.positions, length))
    assert np.array_equal(to_cpu(result.positions_on_gpu), result.positions)
    found, expected = (izo_ref.find_impacts(s, device="cuda") for s in (scaled, scene))
    assert np.array_equal(found.nodes, expected.nodes)


def test_unused_vertices_far_out_change_nothing_on_a_gpu():
    scene = two_sheets(np.random.default_rng(0), 3)
    other = izo_ref.resolve(scene, 1e-3, device="cuda")
    far = np.full((1, 3), 1.79e308)
    start, end = (to_gpu(np.vstack((p, far))) for p in (scene.positions_t0, scene.positions_t1))
    masses = np.append(scene.masses, 1.0)
    result = izo_ref.resolve(izo_ref.Scene(start, end, scene.faces, masses), 1e-3, device="cuda")
    assert np.array_equal(result.positions, np.vstack((other.positions, far)))
    assert np.array_equal(to_cpu(result.positions_on_gpu), result.positions)
