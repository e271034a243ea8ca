"""Step files: where they are, and how they are read.

A step file is a numpy archive. The folder is that of the environment variable IZO_DATA. If it does
not exist, the scenes of the project take its place (`scenes/stored.py`).
"""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.scene import Scene
from izo_ref.zones.problem import ZoneProblem
from validation.scenes import stored

FOLDER = Path(
    os.environ.get("IZO_DATA", Path(__file__).parent.parent.parent.parent / "shared" / "data")
)
STEP_ARRAYS = ("positions_t0", "positions_t1", "faces", "masses", "pinned")


def available() -> bool:
    """Return whether there is a folder of step files."""
    return FOLDER.is_dir()


def load(name: str) -> dict[str, Any]:
    """Read all arrays of a file of the folder, or of a scene of the project."""
    if name in stored.names():
        return stored.load(name)
    with np.load(FOLDER / f"{name}.npz") as archive:
        return {key: archive[key] for key in archive.files}


def step_names() -> list[str]:
    """Name the files that hold a step; if there is no folder, the scenes of the project."""
    if not available():
        return stored.names("step")
    names = []
    for path in sorted(FOLDER.glob("*.npz")):
        with np.load(path) as archive:
            if "positions_t0" in archive.files:
                names.append(path.stem)
    return names


# Modes of `Scene` for single steps. The pinned plates of these go through each other, which ends
# the step at once, as in the systems that they are compared with. By default the sheet between them
# would be resolved as far as it can be, in a hundred iterations.
MODES: dict[str, dict[str, Any]] = {
    name: {"prescribed": "block"} for name in ("pinch-blocked", "pinch-blocked-10k")
}


def load_step(name: str, **kwargs: Any) -> Scene:
    """Read a step.

    Args:
        name: Name of a step file or of a scene of the project.
        **kwargs: Further arguments of `Scene`.

    Returns:
        The step.

    Raises:
        IzoError: The step is not valid, for example because it intersects at the start.
    """
    arrays = load(name)
    own = {key: arrays[key] for key in STEP_ARRAYS if key in arrays}
    return Scene(**own, **(MODES.get(name, {}) | kwargs))


def load_zone(name: str) -> ZoneProblem:
    """Return the zone problem of a file, whose array `targets` has the proposed positions."""
    arrays = load(name)
    return ZoneProblem(proposed=arrays.pop("targets"), **arrays)


def peers() -> dict[str, Any]:
    """Read what was recorded of other systems: `{step: facts}`; empty if there is no record."""
    path = FOLDER / "peers.json"
    return json.loads(path.read_text()) if path.is_file() else {}
