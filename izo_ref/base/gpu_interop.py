"""Arrays of others on the device: of CuPy, PyTorch, JAX, Warp, numba, and whatever has DLPack.

And sorts of ours, which are left to CuPy.
"""

from functools import cache
from importlib.util import find_spec

from cuda.core.utils import StridedMemoryView
from numba import cuda
from numba.cuda.core import config

LEGACY_STREAM = 1  # as DLPack numbers it: the default stream, on which all is launched here


def viewed(array):
    """The same memory as an array of numba; what was launched on it before is waited for."""
    if getattr(array, "__cuda_ndarray__", False):
        return array
    interface = getattr(array, "__cuda_array_interface__", None)
    # PyTorch, JAX and Warp do not say there on which stream they write, but wait by DLPack
    if not hasattr(array, "__dlpack__") or (interface or {}).get("stream") is not None:
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


@cache
def has_cupy() -> bool:
    """Whether CuPy is installed, and there is a device for it: the simulator has none."""
    return not config.ENABLE_CUDASIM and find_spec("cupy") is not None


def order_by_cupy(keys):
    """(n,) i8, the stable order that sorts keys, (n,) i8; of the same stream, the default one."""
    import cupy

    return viewed(cupy.argsort(cupy.asarray(keys)))
