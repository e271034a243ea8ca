"""The processor or a GPU: which runs what is asked for, and arrays that are on the other."""

from izo_ref import checks

# Triangles from which `auto` takes a GPU. An iteration on meeting sheets of so many takes two
# threads of the processor 13 ms, and on a tenth of them 1.9; a GPU some 110 launches and 180 arrays
# (`reports/cuda/`): so it pays unless one of these takes 0.04 ms. No GPU was measured yet.
GPU_FACES = 100_000
CUDA_DEVICES = (2, 13)  # of DLPack: memory of a GPU, and managed memory


def chosen_device(device, scene) -> str:
    """`cpu` or `cuda`: the one asked for, or of `auto` the GPU if there is one and it pays.

    Raises:
        OptionError.
    """
    if checks.device(device) != "auto":
        return device
    from izo_ref.gpu.device import has_device

    return "cuda" if len(scene.faces) >= GPU_FACES and has_device() else "cpu"


def is_on_gpu(array) -> bool:
    """Whether its numbers are in the memory of a GPU."""
    if getattr(array, "__cuda_ndarray__", False) or hasattr(array, "__cuda_array_interface__"):
        return True
    where = getattr(array, "__dlpack_device__", None)
    return where is not None and int(where()[0]) in CUDA_DEVICES


def on_processor(array):
    """The array as it is, or a copy of one that is on a GPU.

    Raises:
        DeviceUnavailable.
    """
    if not is_on_gpu(array):
        return array
    from izo_ref.gpu.device import require_device

    require_device()
    from izo_ref.gpu.interop import viewed

    return viewed(array).copy_to_host()
