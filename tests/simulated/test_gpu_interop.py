"""Scenes whose arrays are already on a GPU."""

from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest
from numba import cuda

import izo_ref
from izo_ref.base import gpu_arrays as arrays
from izo_ref.base import gpu_interop as interop
from izo_ref.base.devices import is_on_gpu
from izo_ref.base.errors import NonFiniteError, ShapeError
from izo_ref.base.gpu_interop import described, viewed
from tests.helpers.shapes import two_sheets


def arguments(scene, send=cuda.to_device):
    """Return the arrays of a scene, each sent to the GPU."""
    columns = scene.positions_t0, scene.positions_t1, scene.faces, scene.masses, scene.pinned
    return [send(column) for column in columns]


def test_a_scene_from_gpu_arrays_ends_as_one_from_the_cpu(rng):
    scene = two_sheets(rng, 3, pinned_below=True)
    own = izo_ref.Scene(*arguments(scene))
    for name in ("positions_t0", "positions_t1", "faces", "masses", "pinned"):
        assert np.array_equal(getattr(own, name), getattr(scene, name))
        assert isinstance(getattr(own, name), np.ndarray)
    found = izo_ref.resolve(own, 1e-3, "cuda")
    expected = izo_ref.resolve(scene, 1e-3)
    assert np.array_equal(found.positions, expected.positions)
    assert np.array_equal(found.positions_on_gpu.copy_to_host(), expected.positions)
    assert expected.positions_on_gpu is None
    certificate = izo_ref.certify_path(own, found.positions_on_gpu, device="cuda")
    assert certificate.free


def test_positions_on_the_gpu_are_not_sent_again(rng, monkeypatch):
    import_module("izo_ref.certificate.gpu_filter")  # so that it has `to_gpu` as it is now
    scene = izo_ref.Scene(*arguments(two_sheets(rng, 3)))
    sent, send = [], arrays.to_gpu
    modules = "base.gpu_arrays", "loop.gpu_step", "detection.gpu_detector"

    def noted(array):
        sent.append(getattr(array, "shape", None))
        return send(array)

    for module in modules:
        monkeypatch.setattr(f"izo_ref.{module}.to_gpu", noted)
    izo_ref.resolve(scene, 1e-3, "cuda")
    assert sent
    # Only the certificate, which is not recorded here, takes the positions returned on the CPU.
    assert (len(scene.masses), 3) not in sent


def test_float32_positions_are_accepted(rng):
    scene = two_sheets(rng, 3)
    positions = [array.astype(np.float32) for array in (scene.positions_t0, scene.positions_t1)]
    own = izo_ref.Scene(*map(cuda.to_device, positions), scene.faces)
    expected = izo_ref.resolve(izo_ref.Scene(*positions, scene.faces), 1e-3)
    assert np.array_equal(izo_ref.resolve(own, 1e-3, "cuda").positions, expected.positions)


def test_scaled_back_positions_are_returned_on_the_gpu_too(rng):
    scene, options = two_sheets(rng, 2), izo_ref.Options(max_iterations=1)
    found = izo_ref.resolve(scene, 1e-3, "cuda", options)
    assert found.scaled_back
    assert np.array_equal(found.positions_on_gpu.copy_to_host(), found.positions)


def test_bad_gpu_arrays_are_named(rng):
    scene = two_sheets(rng, 2)
    start, _, *others = arguments(scene)
    bad = scene.positions_t1.copy()
    bad[2, 1] = np.nan
    with pytest.raises(NonFiniteError, match=r"positions_t1: .*nan at \[2, 1\]"):
        izo_ref.Scene(start, cuda.to_device(bad), *others)
    with pytest.raises(ShapeError, match="positions_t1"):
        izo_ref.Scene(start, cuda.to_device(bad[:3]), *others)


class OfDlpack:
    """An array with DLPack alone, as PyTorch and others have them, here in memory of the CPU."""

    def __init__(self, array, device):
        self._array, self._device = array, device

    def __dlpack__(self, **kwargs):
        """Return the capsule of the array."""
        return self._array.__dlpack__()

    def __dlpack_device__(self):
        """Return the kind and the number of the device that the array claims to be on."""
        return self._device


def test_an_array_with_dlpack_alone_is_described():
    values = np.arange(12.0, dtype=np.float32).reshape(4, 3)[::2]
    found = described(OfDlpack(values, (1, 0)), -1).__cuda_array_interface__
    same = np.array(values, copy=False).__array_interface__
    for name in ("shape", "typestr", "strides", "data"):
        assert found[name] == same[name]


@pytest.mark.parametrize(
    ("stream", "has_dlpack", "by_dlpack"),
    [(None, True, True), (1, True, False), (None, False, False), (1, False, False)],
)
def test_arrays_still_being_written_are_waited_for(monkeypatch, stream, has_dlpack, by_dlpack):
    """The array names a stream, or DLPack waits; with neither, no caller can wait."""
    array = SimpleNamespace(__cuda_array_interface__={"version": 3, "stream": stream})
    if has_dlpack:
        array.__dlpack__ = None
    monkeypatch.setattr(interop.cuda, "as_cuda_array", lambda a: a, raising=False)
    monkeypatch.setattr(interop, "described", lambda a, stream: ("described", a, stream))
    assert viewed(array) == (("described", array, 1) if by_dlpack else array)


class OfTorch:
    """A tensor that requires gradients: its values can be read only after `detach`."""

    requires_grad = True

    def __init__(self, values):
        self._values = values

    def detach(self):
        """Return the values."""
        return self._values

    @property
    def __cuda_array_interface__(self):
        """Refuse to describe the array."""
        raise RuntimeError("requires grad")

    def __array__(self, *_, **__):
        """Refuse to become a numpy array."""
        raise RuntimeError("requires grad")


@pytest.mark.parametrize("send", [np.asarray, cuda.to_device])
def test_tensors_that_require_gradients_are_detached(rng, send):
    scene = two_sheets(rng, 2)
    start, end = (OfTorch(send(a)) for a in (scene.positions_t0, scene.positions_t1))
    own = izo_ref.Scene(start, end, scene.faces)
    assert np.array_equal(own.positions_t1, scene.positions_t1)
    assert len(own.on_gpu) == (2 if send is cuda.to_device else 0)
    assert izo_ref.certify_path(own, OfTorch(send(scene.positions_t0))).free


class Managed(np.ndarray):
    """An array in managed memory, which numpy can read."""

    __cuda_ndarray__ = True


class Spread:
    """An array that is spread over several devices."""

    def __dlpack_device__(self):
        """Refuse to name one device."""
        raise BufferError("on several devices")


class Backwards:
    """An array of a GPU with negative strides, which cannot be copied."""

    __cuda_ndarray__ = True

    def bind(self):
        """Return the array itself."""
        return self

    def copy_to_host(self):
        """Refuse the copy."""
        raise NotImplementedError("negative strides")


def test_arrays_that_cannot_be_copied_are_named(rng):
    scene = two_sheets(rng, 2)
    with pytest.raises(ShapeError, match=r"positions_t1: .*negative strides"):
        izo_ref.Scene(scene.positions_t0, Backwards(), scene.faces)


def test_arrays_of_a_gpu_are_recognised():
    values = np.zeros(3)
    assert not is_on_gpu(values)
    assert not is_on_gpu([1.0])
    assert not is_on_gpu(OfDlpack(values, (1, 0)))
    assert is_on_gpu(OfDlpack(values, (2, 0)))
    assert not is_on_gpu(values.view(Managed))
    assert not is_on_gpu(Spread())
    own = cuda.to_device(values)
    assert is_on_gpu(own)
    assert viewed(own) is own
