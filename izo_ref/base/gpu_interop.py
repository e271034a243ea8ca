"""Arrays that other libraries keep on a GPU: CuPy, PyTorch, JAX, Warp, numba, and others."""

from __future__ import annotations

from typing import Any

# installed with numba-cuda
from cuda.core.utils import StridedMemoryView  # pyright: ignore[reportMissingImports]
from numba import cuda
from numba.cuda.core import config

from izo_ref.base.arrays import GpuArray
from izo_ref.base.cuda.memory import DeviceArray, array_at
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
    return cuda.as_cuda_array(Described(array, LEGACY_STREAM))


def own_array(array: Any) -> GpuArray:
    """Return the memory of any array on a GPU as an array of ours, which kernels take."""
    return array_at(viewed(array))


def shared_array(array: GpuArray) -> Any:
    """Return the memory of an array of ours as one of numba, for the user."""
    return array_of(array) if config.ENABLE_CUDASIM else cuda.as_cuda_array(array)


class Described:
    """An array with DLPack, described by the interface that numba reads; keeps the array alive.

    Args:
        array: An array on a GPU.
        stream: Number of the stream on which it will be used.

    Attributes:
        view: The view of the array's memory.
    """

    def __init__(self, array: Any, stream: int) -> None:
        """Ask the array for its memory; it waits for its own launches first."""
        self.view = StridedMemoryView.from_dlpack(array, stream_ptr=stream)
        strides = self.view.strides
        if strides is not None:
            strides = tuple(stride * self.view.dtype.itemsize for stride in strides)
        self.__cuda_array_interface__ = {
            "shape": tuple(self.view.shape),
            "typestr": self.view.dtype.str,
            "data": (self.view.ptr, self.view.readonly),
            "strides": strides,
            "version": 3,
        }
