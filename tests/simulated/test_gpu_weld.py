"""A step with welded vertices on the GPU, compared with one on the CPU."""

import numpy as np
import pytest

import izo_ref
from izo_ref import Status
from izo_ref.base.gpu_arrays import to_cpu, to_gpu
from izo_ref.detection import gpu_detector
from tests.helpers.seams import crossing_cloths, cut, shuffled

pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


def soup(rng):
    """Return two small sheets without common vertices, one of which falls through the other."""
    mesh = crossing_cloths(rng, 2)
    mesh["pinned"] = np.arange(8) < 2
    return shuffled(rng, cut(mesh, np.arange(len(mesh["faces"]))))


def test_impacts_are_those_of_the_cpu(rng):
    scene = izo_ref.Scene(**soup(rng), weld=0)
    expected, found = izo_ref.find_impacts(scene), izo_ref.find_impacts(scene, device="cuda")
    assert len(expected.toi) > 0
    for own, other in zip(found, expected, strict=True):
        assert np.array_equal(own, other)


def test_copies_are_in_no_tree(rng):
    scene = izo_ref.Scene(**soup(rng), weld=0)
    vertices, *_ = gpu_detector.Detector(scene).trees
    assert sorted(to_cpu(vertices.order)) == np.unique(scene.copies).tolist()


@pytest.mark.parametrize("on_gpu", [False, True])
def test_a_step_ends_as_on_the_cpu(rng, on_gpu):
    mesh = soup(rng)
    scene = izo_ref.Scene(**mesh, weld=0)
    expected = izo_ref.resolve(scene, 1e-3)
    assert expected.status is Status.FREE
    assert len(expected.impacts.toi) > 0
    if on_gpu:
        mesh |= {name: to_gpu(mesh[name]) for name in ("positions_t0", "positions_t1")}
        scene = izo_ref.Scene(**mesh, weld=0)
        assert set(scene.on_gpu) == {"positions_t0", "positions_t1"}
    found = izo_ref.resolve(scene, 1e-3, "cuda")
    assert found.status is expected.status
    assert np.array_equal(found.positions, expected.positions)
    assert np.array_equal(to_cpu(found.positions_on_gpu), expected.positions)
    assert found.certificate.candidates == expected.certificate.candidates
    following = scene.after(found, found.positions_on_gpu)
    assert izo_ref.resolve(following, 1e-3, "cuda").status is Status.FREE


def test_positions_on_the_gpu_within_a_tolerance_are_joined(rng):
    mesh = soup(rng)
    mesh["positions_t0"] += rng.uniform(-1e-8, 1e-8, mesh["positions_t0"].shape)
    expected = izo_ref.resolve(izo_ref.Scene(**mesh, weld=1e-7), 1e-3)
    assert len(expected.impacts.toi) > 0
    mesh |= {name: to_gpu(mesh[name]) for name in ("positions_t0", "positions_t1")}
    scene = izo_ref.Scene(**mesh, weld=1e-7)
    found = izo_ref.resolve(scene, 1e-3, "cuda")
    assert np.array_equal(found.positions, expected.positions)
    assert np.array_equal(found.positions, found.positions[scene.copies])
