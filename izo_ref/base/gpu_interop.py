"""Arrays that other libraries keep on a GPU: CuPy, PyTorch, JAX, Warp, numba, and others."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

# installed with numba-cuda
from cuda.core.utils import StridedMemoryView  # pyright: ignore[reportMissingImports]
from numba import cuda
from numba.cuda.core import config

from izo_ref.base.arrays import GpuArray
from izo_ref.base.cuda.memory import DeviceArray
from izo_ref.base.cuda.simulated import array_of

LEGACY_STREAM = 1  # number in DLPack of the default stream, on which this package launches all


def viewed(array: Any) -> GpuArray:
    """Return the same memory as an array of numba, after what was launched on it has ended.

    Args:
        array: An array on a GPU with `__cuda_array_interface__` or DLPack.
    """
    if getattr(array, "__cuda_ndarray__", False):
        return array
    if isinstance(array, DeviceArray):
        return shared_array(array)
    interface = getattr(array, "__cuda_array_interface__", None)
    # The interfaces of PyTorch, JAX and Warp do not name the stream on which they write. With
    # DLPack they wait for it.
    if not hasattr(array, "__dlpack__") or (interface or {}).get("stream") is not None:
        return cuda.as_cuda_array(array)
    return cuda.as_cuda_array(described(array, LEGACY_STREAM))


def own_array(array: Any) -> GpuArray:
    """Return the memory of any array on a GPU as an array of ours, which kernels take."""
    own = viewed(array)
    # an array of the simulator is one of numpy
    interface = "__array_interface__" if config.ENABLE_CUDASIM else "__cuda_array_interface__"
    address = getattr(own, interface)["data"][0]
    return DeviceArray(address, own.shape, own.dtype, own, own.strides)


def shared_array(array: GpuArray) -> Any:
    """Return the memory of an array of ours as one of numba, for the user."""
    return array_of(array) if config.ENABLE_CUDASIM else cuda.as_cuda_array(array)


def described(array: Any, stream: int) -> Any:
    """Return an array with DLPack as an object with the interface that numba reads.

    The object keeps the array alive.

    Args:
        array: An array on a GPU, which waits for its own launches first.
        stream: Number of the stream on which it will be used.
    """
    view = StridedMemoryView.from_dlpack(array, stream_ptr=stream)
    strides = view.strides
    if strides is not None:
        strides = tuple(stride * view.dtype.itemsize for stride in strides)
    interface = {
        "shape": tuple(view.shape),
        "typestr": view.dtype.str,
        "data": (view.ptr, view.readonly),
        "strides": strides,
        "version": 3,
    }
    return SimpleNamespace(__cuda_array_interface__=interface, view=view)
