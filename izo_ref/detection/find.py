"""Find the impacts of a scene."""

from izo_ref.base import checks
from izo_ref.base.devices import choose_device, implementation
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.base.sizes import scene_in_range
from izo_ref.detection.detector import Detector


def find_impacts(scene: SceneArrays, device: str = "cpu") -> Impacts:
    """Find every vertex-face and edge-edge pair that meets on the path of a scene.

    The path leads from `positions_t0` to `positions_t1`. A pair meets if its sides touch at any
    time up to and including t = 1. No such pair is missed. A pair also counts as an impact if
    rounding cannot tell whether it touches after the start. That happens at distances below about
    1e-14 of its size; the distance is larger for slivers and for a vertex that slides just past a
    corner of a face. Pairs that start nearer than that are decided exactly (`detection/doubts.py`).

    Args:
        scene: The `Scene`.
        device: `cpu`, `cuda` or `auto`; `auto` takes a GPU for large scenes if there is one.

    Returns:
        `Impacts`: first the vertex-face pairs, sorted by vertex and face, then the edge-edge pairs,
        sorted by their edges. Last come those pairs that touch at the start (`Scene.touching`) and
        do not come apart, or meet again.

    Raises:
        OptionError: `device` has another value, or `scene` is no scene.
        SizeError: A coordinate is too large or too small to compute with.
        DeviceUnavailableError: `device` is `cuda`, and no GPU can be used.

    Source: docs/method section 1; the proof is in `detection/formulas/advance.py`.
    """
    checks.scene(scene)
    find = implementation(
        choose_device(device, scene), _find_on_cpu, "izo_ref.detection.gpu_detector:find_impacts"
    )
    return find(scene_in_range(scene)[0])


def _find_on_cpu(scene: SceneArrays) -> Impacts:
    return Detector.of_scene(scene).find(scene.positions_t1)
