"""The scenes of `data/scenes`, which come with the project."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref import Scene

FOLDER = Path(__file__).parent.parent.parent / "data" / "scenes"
STEP_ARRAYS = ("positions_t0", "positions_t1", "faces", "masses", "pinned")


@cache
def index() -> dict[str, Any]:
    """Read what is known of each scene: `{name: facts}`, as `data/README.md` describes them."""
    return json.loads((FOLDER / "index.json").read_text())


def names(kind: str | None = None, status: str | None = None) -> list[str]:
    """Name the scenes.

    Args:
        kind: `step` or `sequence`; both if None.
        status: Name of the `Status` in which the last step of the scene ends; any if None.
    """
    return [
        name
        for name, facts in index().items()
        if kind in (None, facts["kind"])
        and status in (None, facts["steps"][-1]["answer"]["status"])
    ]


def load(name: str) -> dict[str, Any]:
    """Read all arrays of a scene, with the pairs that meet."""
    with np.load(FOLDER / f"{name}.npz") as archive:
        return {key: archive[key] for key in archive.files}


def load_step(name: str) -> Scene:
    """Read a scene of the kind `step`."""
    arrays = load(name)
    return Scene(**{key: arrays[key] for key in STEP_ARRAYS})


def thickness(name: str) -> float:
    """Return the thickness with which the answer of a scene is recorded [m]."""
    return index()[name]["thickness_m"]
