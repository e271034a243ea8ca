"""Find the impacts of a scene."""

from izo_ref.base.devices import choose_device, implementation
from izo_ref.base.records import Impacts, SceneArrays
from izo_ref.detection.detector import Detector


def find_impacts(scene, device="cpu") -> Impacts:
    """Every vertex-face and edge-edge pair that meets on the path of a scene.

    A pair that is only touched, at any time up to t = 1, meets; so does one that comes
    closer than rounding can tell from touching: some 1e-14 of its size, more for slivers.
    None is missed.

    Args:
        scene: `Scene`.
        device: `cpu`, `cuda` or `auto`, as of `resolve`.

    Returns:
        `Impacts`: vertex-face pairs by vertex and face, then edge-edge pairs by edges.

    Raises:
        OptionError, DeviceUnavailableError.

    Source: SPEC section 1; the proof is in `detection/formulas/advance.py`.
    """
    find = implementation(
        choose_device(device, scene), _find_on_cpu, "izo_ref.detection.gpu_detector:find_impacts"
    )
    return find(scene)


def _find_on_cpu(scene: SceneArrays) -> Impacts:
    detector = Detector(scene.positions_t0, scene.edges, scene.faces, scene.excluded)
    return detector.find(scene.positions_t1)
