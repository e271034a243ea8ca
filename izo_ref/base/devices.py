"""The one door to a GPU: whether there is one, what runs on it, and which arrays are there."""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any, TypeVar

import numpy as np

from izo_ref.base import checks
from izo_ref.base.errors import DeviceUnavailableError, ShapeError
from izo_ref.base.records import SceneArrays

# `device="auto"` takes a GPU for scenes with this many triangles or more. The detection of 10,000
# triangles takes an H200 2.2 ms and 16 cores 9 ms, that of 100,000 takes 2.4 and 34 ms
# (`reports/cuda/`). Whole steps on a GPU were not timed since launches became cheap, so the number
# stays where a GPU gains most by detection.
GPU_FACES = 100_000
# Device types of DLPack for the memory of a GPU and for managed memory.
DLPACK_CUDA_DEVICES = (2, 13)
# Threads of a launch in the simulator whose size depends on no count. Each is a thread of Python.
SIMULATED_THREADS = 3

Function = TypeVar("Function", bound=Callable[..., Any])


def choose_device(device: str, scene: SceneArrays) -> str:
    """Turn the option `device` into `cpu` or `cuda`.

    Args:
        device: `cpu`, `cuda` or `auto`; `auto` takes a GPU if there is one and the scene has at
            least `GPU_FACES` triangles.
        scene: The scene to run on.

    Returns:
        `cpu` or `cuda`.

    Raises:
        OptionError: `device` has another value.
    """
    if checks.device(device) != "auto":
        return device
    return "cuda" if len(scene.faces) >= GPU_FACES and has_gpu() else "cpu"


def implementation(device: str, on_cpu: Function, on_gpu: str) -> Function:
    """Choose the implementation of a function for a device.

    The implementation for a GPU is named, not passed, because its module imports numba.cuda. It
    is imported here, when it is first needed, after a GPU was found.

    Args:
        device: `cpu` or `cuda`.
        on_cpu: The implementation for the CPU.
        on_gpu: `module:name` of the implementation for a GPU, which takes the same arguments.

    Returns:
        One of the two.

    Raises:
        DeviceUnavailableError: `device` is `cuda`, and numba-cuda, a driver or a GPU is missing.
    """
    return on_cpu if device == "cpu" else import_for_gpu(on_gpu)


def import_for_gpu(name: str) -> Any:
    """Import a function that works on a GPU, after a GPU was found.

    Args:
        name: `module:function`.

    Raises:
        DeviceUnavailableError: numba-cuda, a driver or a GPU is missing.
    """
    require_gpu()
    module, function = name.split(":")
    return getattr(import_module(module), function)


def require_gpu() -> None:
    """Check that a GPU can be used; modules that import numba.cuda are imported after this.

    Raises:
        DeviceUnavailableError: numba-cuda, a driver or a GPU is missing; says which.
    """
    if find_spec("numba_cuda") is None:
        raise DeviceUnavailableError(
            "device 'cuda': numba-cuda is not installed; pip install 'izo-ref[cuda]'"
        )
    from numba import cuda

    if _is_simulated():
        return  # the simulator runs every kernel in Python, slowly
    if not cuda.is_available():
        raise DeviceUnavailableError(
            "device 'cuda': no NVIDIA GPU with a driver for CUDA 13 (580 or newer) was found; "
            f"install the driver, or use device 'cpu' ({_driver_message(cuda)})"
        )


def _is_simulated() -> bool:
    return os.environ.get("NUMBA_ENABLE_CUDASIM", "0") != "0"


def has_gpu() -> bool:
    """Return whether a GPU can be used."""
    try:
        require_gpu()
    except DeviceUnavailableError:
        return False
    return True


def count_resident_blocks() -> int:
    """Return how many blocks certainly run at the same time: one a multiprocessor."""
    from numba import cuda

    # the simulator has no multiprocessors, and runs one block after the other
    return getattr(cuda.get_current_device(), "MULTIPROCESSOR_COUNT", 1)


def fixed_launch(blocks_each: int, n_threads: int) -> tuple[int, int]:
    """Return the blocks of a launch, and the threads of a block, that suit any amount of work.

    Args:
        blocks_each: Blocks for each multiprocessor. With 1, all blocks certainly run at the same
            time, so that they may wait for each other.
        n_threads: Threads of a block.
    """
    if _is_simulated():
        return 1, SIMULATED_THREADS
    return blocks_each * count_resident_blocks(), n_threads


def largest_shared_bytes() -> int:
    """Return the most shared memory that a block can ask for [bytes]."""
    from numba import cuda

    # the simulator has no such limit; every GPU has at least this much
    return getattr(cuda.get_current_device(), "MAX_SHARED_MEMORY_PER_BLOCK_OPTIN", 48 << 10)


def _driver_message(cuda: Any) -> str:
    error = getattr(cuda, "cuda_error", lambda: None)()
    return str(error).strip().splitlines()[0] if error else "the driver reports no device"


def detach(array: Any) -> Any:
    """Return an array without the record that PyTorch keeps to differentiate it."""
    return array.detach() if hasattr(array, "detach") else array


def is_on_gpu(array: Any) -> bool:
    """Return whether the numbers of an array are in the memory of a GPU, and only there."""
    # numba's managed and mapped arrays are ndarrays: the CPU can read them
    if isinstance(array, np.ndarray):
        return False
    if getattr(array, "__cuda_ndarray__", False) or hasattr(array, "__cuda_array_interface__"):
        return True
    device_of = getattr(array, "__dlpack_device__", None)
    try:
        return device_of is not None and int(device_of()[0]) in DLPACK_CUDA_DEVICES
    except (BufferError, ValueError):
        # the array is on several devices or on none: numpy's error will say what it is
        return False


def copy_to_cpu(name: str, array: Any) -> Any:
    """Return an array as it is, or a copy on the CPU of one that is on a GPU.

    Args:
        name: The name of the array in messages.
        array: Anything that numpy takes, or an array on a GPU.

    Raises:
        DeviceUnavailableError: The array is on a GPU that cannot be used.
        ShapeError: The array cannot be copied.
    """
    if not is_on_gpu(array):
        return array
    view = import_for_gpu("izo_ref.base.gpu_interop:viewed")
    try:
        # bound to the default stream, so that the copy is complete when this returns
        return view(array).bind().copy_to_host()
    except NotImplementedError as error:
        raise ShapeError(f"{name}: expected an array that can be copied: {error}") from None
