"""Read a dump: its arrays by name, checked where they come in."""

from __future__ import annotations

import os
import re
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Flags, Floats, Ints
from izo_ref.base.errors import FileFormatError
from izo_ref.base.options import Options
from izo_ref.base.records import Impacts
from izo_ref.detection.mesh import median_length
from izo_ref.porting.reference.rounded import EPS
from izo_ref.porting.trace_files import load_arrays, load_index
from izo_ref.scene import Scene

SCENE = "scene"
REQUIRED = ("positions_t0", "positions_t1", "faces")
ITERATION = re.compile(r"iteration-\d+")
KINDS = {"f": "floats", "i": "integers", "b": "flags, 0 or 1", "U": "a text"}
# The arrays that an iteration may have. The letter m counts the rows of `nodes` in the same folder.
SHAPES: dict[str, tuple[str, tuple[str | int, ...]]] = {
    "positions_t1": ("f", ("n", 3)),
    "vertex_face": ("i", ("k", 4)),
    "edge_edge": ("i", ("l", 4)),
    "found/nodes": ("i", ("m", 4)),
    "found/edge_edge_impacts": ("b", ("m",)),
    "found/toi": ("f", ("m",)),
    "found/weights": ("f", ("m", 4)),
    "found/normals": ("f", ("m", 3)),
    "found/hopeful": ("b", ("m",)),
    "found/deep": ("b", ("m",)),
    "found/selected": ("b", ("m",)),
    "selection": ("U", ()),
    "zones/nodes": ("i", ("m", 4)),
    "zones/edge_edge_impacts": ("b", ("m",)),
    "zones/toi": ("f", ("m",)),
    "zones/weights": ("f", ("m", 4)),
    "zones/normals": ("f", ("m", 3)),
    "zones/zone_of_impact": ("i", ("z",)),
    "positions": ("f", ("n", 3)),
    "multipliers": ("f", ("z",)),
    "objective": ("f", ()),
}
RESULT: dict[str, tuple[str, tuple[str | int, ...]]] = {
    "positions": ("f", ("n", 3)),
    "free": ("b", ()),
    "objective": ("f", ()),
}
# What a trace has besides; no stage is judged by it.
BESIDES = re.compile(
    r"scene/(copies|welded_\w+)|iteration-\d+/zones/(toi|edge_edge_impacts)|"
    r"result/(meeting/\w+|nodes|edge_edge_impacts|toi|weights|normals|multipliers|zone_of_impact)"
)


class Rows(NamedTuple):
    """Impacts of a dump; None for what it does not have.

    Attributes:
        nodes: (m, 4) i4.
        is_edge_edge: (m,) b1.
        toi: (m,) f8, or None.
        weights: (m, 4) f8, or None.
        normals: (m, 3) f8, or None.
    """

    nodes: Ints
    is_edge_edge: Flags
    toi: Floats | None
    weights: Floats | None
    normals: Floats | None

    def impacts(self) -> Impacts:
        """Return the impacts; what is missing is zero."""
        n = len(self.nodes)
        toi = np.zeros(n) if self.toi is None else self.toi
        weights = np.zeros((n, 4)) if self.weights is None else self.weights
        normals = np.zeros((n, 3)) if self.normals is None else self.normals
        return Impacts(self.nodes, self.is_edge_edge, toi, weights, normals)


class Dump:
    """The arrays of a dump.

    Args:
        folder: A folder of .npy files, or one .npz archive.

    Attributes:
        scene: The scene.
        thickness: The thickness [m].
        dtype: `f8`, or `f4` if an array has float32 numbers.
        iterations: Names of the iterations, in order.
        selections: The rule of selection of an iteration, where the dump says it.
        notes: What there is to say about the dump itself.

    Raises:
        FileFormatError: A file cannot be read, an array of the scene is missing, or an array has
            another shape or type.
        IzoError: `Scene` does not accept the arrays of the scene.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        """Read the dump, and check its scene."""
        self._where, self._arrays = folder, load_arrays(folder)
        index = load_index(folder)
        missing = [name for name in REQUIRED if f"{SCENE}/{name}" not in self._arrays]
        if missing:
            raise FileFormatError(
                f"{folder}: expected the arrays {', '.join(f'{SCENE}/{n}' for n in REQUIRED)}, "
                f"{', '.join(f'{SCENE}/{name}' for name in missing)} missing, found "
                f"{', '.join(sorted(self._arrays)[:8]) or 'no array'}"
            )
        optional = {n: self.get(f"{SCENE}/{n}") for n in ("masses", "pinned")}
        required = [self.get(f"{SCENE}/{name}") for name in REQUIRED]
        modes = {n: v for n, v in index.get("scene", {}).items() if v is not None}
        self.scene = Scene(*required, **optional, **modes)
        self.notes: list[str] = []
        self.thickness = self._thickness()
        is_float32 = any(array.dtype == np.float32 for array in self._arrays.values())
        self.dtype = "f4" if is_float32 else "f8"
        names = {key.partition("/")[0] for key in self._arrays}
        self.iterations = sorted(name for name in names if ITERATION.fullmatch(name))
        self.selections = {
            row["folder"]: row["selection"]
            for row in index.get("iterations", [])
            if "selection" in row
        }
        self._check_arrays()

    @property
    def eps(self) -> float:
        """The machine epsilon of the floats of the dump."""
        return EPS[self.dtype]

    def get(self, key: str) -> Any:
        """Return an array, or None."""
        return self._arrays.get(key)

    def floats(self, key: str) -> Any:
        """Return an array as float64, or None."""
        values = self.get(key)
        return None if values is None else np.ascontiguousarray(values, np.float64)

    def flags(self, key: str) -> Any:
        """Return an array as bool, or None."""
        values = self.get(key)
        return None if values is None else np.asarray(values).astype(bool)

    def rows(self, place: str) -> Rows | None:
        """Return the impacts at a place such as `iteration-0001/found`, or None."""
        nodes = self.get(f"{place}/nodes")
        if nodes is None:
            return None
        kinds = self.flags(f"{place}/edge_edge_impacts")
        if kinds is None:
            raise FileFormatError(
                f"{self._where}: {place}/nodes is there, but {place}/edge_edge_impacts, which says "
                "of which kind each impact is, is missing"
            )
        n = len(self.scene.positions_t0)
        off = np.argwhere((nodes < 0) | (nodes >= n))
        if len(off):
            row, column = off[0].tolist()
            raise FileFormatError(
                f"{self._where}: {place}/nodes: expected vertices from 0 to {n - 1}, got "
                f"{nodes[row, column]} in row {row}"
            )
        columns = (self.floats(f"{place}/{name}") for name in ("toi", "weights", "normals"))
        return Rows(np.ascontiguousarray(nodes, np.int32), kinds, *columns)

    def _thickness(self) -> float:
        value = self.get(f"{SCENE}/thickness")
        if value is not None:
            self._require(f"{SCENE}/thickness", "f", ())
            return float(value)
        thickness = Options().thickness_fraction
        thickness *= median_length(self.scene.positions_t0, self.scene.edges)
        self.notes.append(
            f"{SCENE}/thickness is missing, so the default of izo_ref was taken: {thickness:g} m"
        )
        return thickness

    def _check_arrays(self) -> None:
        """Check the shapes and types of all arrays, and note those that no stage takes."""
        unknown = []
        for key in sorted(self._arrays):
            place, _, name = key.partition("/")
            shapes = SHAPES if ITERATION.fullmatch(place) else RESULT if place == "result" else {}
            if name in shapes:
                self._require(key, *shapes[name])
            elif not (place == SCENE and name in (*REQUIRED, "masses", "pinned", "thickness")):
                unknown += [] if BESIDES.fullmatch(key) else [key]
        if unknown:
            self.notes.append(f"no stage takes these arrays: {', '.join(unknown)}")

    def _require(self, key: str, kind: str, shape: tuple[str | int, ...]) -> None:
        """Raise an error if an array has another shape or type."""
        array = self._arrays[key]
        counts = self._counts(key)
        wanted = tuple(counts.get(n, n) if isinstance(n, str) else n for n in shape)
        right = array.ndim == len(wanted) and all(
            isinstance(want, str) or want == size
            for want, size in zip(wanted, array.shape, strict=True)
        )
        if right and _is_of_kind(array, kind):
            return
        text = f"({', '.join(map(str, wanted))}{',' if len(wanted) == 1 else ''})"
        raise FileFormatError(
            f"{self._where}: {key}: expected shape {text} of {KINDS[kind]}, got {array.shape} of "
            f"{array.dtype}"
        )

    def _counts(self, key: str) -> dict[str, int]:
        """Return the counts that the letters in shapes stand for, as far as the dump has them."""
        place = key.rpartition("/")[0]
        counts = {"n": len(self.scene.positions_t0)}
        nodes = self.get(f"{place}/nodes")
        if nodes is not None and nodes.ndim == 2:
            counts["m"] = len(nodes)
        zones = self.get(f"{key.partition('/')[0]}/zones/nodes")
        if zones is not None and zones.ndim == 2:
            counts["z"] = len(zones)
        return counts


def _is_of_kind(array: Any, kind: str) -> bool:
    if kind == "f":
        return array.dtype in (np.float32, np.float64)
    if kind == "b" and array.dtype.kind in "iu":
        return bool(np.isin(array, (0, 1)).all())
    return array.dtype.kind in {"i": "iu", "b": "b", "U": "U"}[kind]
