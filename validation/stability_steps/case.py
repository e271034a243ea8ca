"""A step with everything that `resolve` is given, and its file.

The file is a step file that every command reads. Three more arrays, which other commands ignore,
hold what a step file has no room for: `more_t1` (k, n, 3) [m], the proposed positions of the steps
that follow; `thickness` [m]; and `settings`, a text of JSON with the modes of `Scene` and the
numbers and words of `Options`.
"""

import dataclasses
import json
import os
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from izo_ref import Options, Scene
from izo_ref.app.files import OPTIONAL, REQUIRED, replacing
from izo_ref.base.arrays import Faces, Flags, Masses, Positions
from izo_ref.base.errors import FileFormatError

FilePath: TypeAlias = str | os.PathLike[str]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Case:
    """Input of a step, or of a sequence of steps; nothing in it is checked.

    Attributes:
        positions_t0: (n, 3) [m], start.
        ends: (n, 3) [m] each, proposed end of the step, and of the steps that follow it.
        faces: (m, 3).
        masses: (n,) [kg], or None.
        pinned: (n,) bool, or None.
        thickness: [m], or None.
        modes: Keyword arguments of `Scene`.
        settings: Keyword arguments of `Options`.
    """

    positions_t0: Positions
    ends: tuple[Positions, ...]
    faces: Faces
    masses: Masses | None = None
    pinned: Flags | None = None
    thickness: float | None = None
    modes: dict[str, Any] = dataclasses.field(default_factory=dict)
    settings: dict[str, Any] = dataclasses.field(default_factory=dict)

    def scene(self) -> Scene:
        """Return the first step.

        Raises:
            IzoError: The arrays are not valid.
        """
        arrays = self.positions_t0, self.ends[0], self.faces, self.masses, self.pinned
        return Scene(*arrays, **self.modes)

    def options(self) -> Options:
        """Return the options.

        Raises:
            OptionError: They are not valid.
        """
        return Options(**self.settings)

    def change(self, **changed: Any) -> "Case":
        """Return the same case with other fields."""
        return dataclasses.replace(self, **changed)

    def take(self, kept_faces: Any) -> "Case":
        """Return the case with some faces only, and only the vertices of these faces.

        Args:
            kept_faces: (m,) bool, or indices.
        """
        faces = np.asarray(self.faces)[kept_faces]
        used, place = np.unique(faces, return_inverse=True)
        return self.take_vertices(used).change(faces=place.reshape(-1, 3).astype(np.int32))

    def take_vertices(self, kept: Any) -> "Case":
        """Return the case with some vertices only; the faces stay, and may not fit any more."""
        return self.change(
            positions_t0=self.positions_t0[kept],
            ends=tuple(end[kept] for end in self.ends),
            masses=None if self.masses is None else np.asarray(self.masses)[kept],
            pinned=None if self.pinned is None else np.asarray(self.pinned)[kept],
        )

    def save(self, path: FilePath) -> None:
        """Write the case as a step file; the file appears whole or not at all.

        Raises:
            FileFormatError: The file cannot be written.
        """
        arrays: dict[str, Any] = {
            "positions_t0": self.positions_t0,
            "positions_t1": self.ends[0],
            "faces": self.faces,
            "settings": json.dumps({"modes": self.modes, "options": self.settings}),
        }
        for name in (*OPTIONAL, "thickness"):
            if getattr(self, name) is not None:
                arrays[name] = getattr(self, name)
        if len(self.ends) > 1:
            arrays["more_t1"] = np.array(self.ends[1:])
        with replacing(path) as file:
            np.savez_compressed(file, **arrays)


def load_case(path: FilePath) -> Case:
    """Read a case; a plain step file is a case with the defaults.

    Args:
        path: The step file.

    Raises:
        FileFormatError: The file cannot be read, or an array is missing.
    """
    try:
        with np.load(Path(path), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        settings = json.loads(str(arrays.get("settings", "{}")))
    except (OSError, ValueError, EOFError) as error:
        raise FileFormatError(f"{path}: cannot be read: {error}") from None
    missing = [name for name in REQUIRED if name not in arrays]
    if missing:
        raise FileFormatError(f"{path}: expected arrays {REQUIRED}, {missing} are missing")
    options = settings.get("options", {})
    if isinstance(options.get("plan"), list):
        options["plan"] = tuple(options["plan"])
    thickness = arrays.get("thickness")
    return Case(
        positions_t0=np.asarray(arrays["positions_t0"], np.float64),
        ends=(np.asarray(arrays["positions_t1"], np.float64), *arrays.get("more_t1", ())),
        faces=arrays["faces"],
        masses=arrays.get("masses"),
        pinned=arrays.get("pinned"),
        thickness=None if thickness is None else float(thickness),
        modes=settings.get("modes", {}),
        settings=options,
    )
