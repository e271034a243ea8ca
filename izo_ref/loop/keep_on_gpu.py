"""The door to scenes that stay on a GPU; importing this needs no package of a GPU."""

from __future__ import annotations

from izo_ref.base.devices import import_for_gpu
from izo_ref.base.options import Options
from izo_ref.loop.simulation import GpuScene
from izo_ref.scene import Scene


def keep_on_gpu(
    scene: Scene, thickness: float | None = None, options: Options | None = None
) -> GpuScene:
    """Put a scene on a GPU, where it stays from step to step.

    Args:
        scene: The first step. Its start is checked by `Scene`; no pair may be left out or touch at
            the start, and no vertices may be welded.
        thickness: Distance that impacts keep at the end [m]; None as for `resolve`.
        options: Choices and tolerances; the defaults if None.

    Returns:
        The scene on the GPU; its `resolve` takes the proposed positions of a step.

    Raises:
        DeviceUnavailableError: No GPU can be used.
        OptionError: The scene is not of this kind.
        ThicknessError: As for `resolve`.
    """
    make = import_for_gpu("izo_ref.loop.gpu_scene:ResidentScene")
    return make(scene, thickness, options)
