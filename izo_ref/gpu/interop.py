"""Arrays of others on the device: of CuPy, PyTorch, JAX, Warp, numba, and whatever has DLPack."""

from cuda.core.utils import StridedMemoryView
from numba import cuda

LEGACY_STREAM = 1  # as DLPack numbers it: the default stream, on which all is launched here


def viewed(array):
    """The same memory as an array of numba; what was launched on it before is waited for."""
    if getattr(array, "__cuda_ndarray__", False):
        return array
    if hasattr(array, "__cuda_array_interface__"):
        return cuda.as_cuda_array(array)
    return cuda.as_cuda_array(Described(array, LEGACY_STREAM))


class Described:
    """An array that has DLPack alone, with the interface that numba reads; keeps it alive."""

    def __init__(self, array, stream):
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
