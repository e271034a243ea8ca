"""The processor or a GPU: which runs what is asked for, and arrays that are on the other."""

import numpy as np

from izo_ref import checks
from izo_ref.errors import ShapeError

# Triangles from which `auto` takes a GPU. An iteration on meeting sheets of so many takes two
# threads of the processor 12 ms, on a tenth of them 1.7 (`reports/speed/`, scale), and a GPU some
# 100 launches and 170 arrays (`reports/cuda/`): with less than 0.04 ms each it is faster here, and
# with more than 0.006 slower there. No GPU was measured yet.
GPU_FACES = 100_000
CUDA_DEVICES = (2, 13)  # of DLPack: memory of a GPU, and managed memory


def chosen_device(device, scene) -> str:
    """`cpu` or `cuda`: the one asked for; of `auto` a GPU, if there is one, for large scenes.

    Raises:
        OptionError.
    """
    if checks.device(device) != "auto":
        return device
    from izo_ref.gpu.device import has_device

    return "cuda" if len(scene.faces) >= GPU_FACES and has_device() else "cpu"


def plain(array):
    """The array without what PyTorch keeps to differentiate it."""
    return array.detach() if hasattr(array, "detach") else array


def is_on_gpu(array) -> bool:
    """Whether its numbers are in the memory of a GPU, and only there."""
    if isinstance(array, np.ndarray):  # managed and mapped memory of numba is
        return False
    if getattr(array, "__cuda_ndarray__", False) or hasattr(array, "__cuda_array_interface__"):
        return True
    where = getattr(array, "__dlpack_device__", None)
    try:
        return where is not None and int(where()[0]) in CUDA_DEVICES
    except (BufferError, ValueError):  # on several devices, or on none: numpy says what it is
        return False


def on_processor(name, array):
    """The array as it is, or a copy of one that is on a GPU.

    Raises:
        DeviceUnavailable, ShapeError.
    """
    if not is_on_gpu(array):
        return array
    from izo_ref.gpu.device import require_device

    require_device()
    from izo_ref.gpu.interop import viewed

    try:
        # on the default stream, so that it is here when this returns
        return viewed(array).bind().copy_to_host()
    except NotImplementedError as error:
        raise ShapeError(f"{name}: expected an array that can be copied: {error}") from None
