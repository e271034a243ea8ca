"""Whether there is a GPU that can be used."""

import os
from importlib.util import find_spec

from izo_ref.errors import DeviceUnavailable


def require_device():
    """Import nothing of `cuda/` before this.

    Raises:
        DeviceUnavailable: numba-cuda, a driver or a GPU is missing; says which.
    """
    if find_spec("numba_cuda") is None:
        raise DeviceUnavailable(
            "device 'cuda': numba-cuda is not installed; pip install 'izo-ref[cuda]'"
        )
    from numba import cuda

    if os.environ.get("NUMBA_ENABLE_CUDASIM", "0") != "0":
        return  # everything runs in Python, if slowly
    if not cuda.is_available():
        raise DeviceUnavailable(
            "device 'cuda': no NVIDIA GPU with a driver for CUDA 13 (580 or newer) was found; "
            f"install the driver, or use device 'cpu' ({_reason(cuda)})"
        )


def has_device() -> bool:
    """Whether there is one."""
    try:
        require_device()
    except DeviceUnavailable:
        return False
    return True


def blocks_at_once() -> int:
    """Blocks that surely run at the same time: one a multiprocessor."""
    from numba import cuda

    # the simulator has none, and runs one block after the other
    return getattr(cuda.get_current_device(), "MULTIPROCESSOR_COUNT", 1)


def _reason(cuda):
    error = getattr(cuda, "cuda_error", lambda: None)()
    return str(error).strip().splitlines()[0] if error else "the driver reports no device"
