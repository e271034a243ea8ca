"""Read and write steps and results.

A step is a numpy `.npz` archive with `positions_t0` and `positions_t1` (n, 3) [m], `faces` (m, 3),
and optionally `masses` (n,) [kg] and `pinned` (n,) bool. A result is an `.npz` archive with
`positions` (n, 3) [m]. Results of `izo resolve` also have the arrays that are needed to judge the
zones again: `thickness` [m], `multipliers` (k,) [kg] and the impacts, `impact_nodes` (k, 4),
`impact_is_edge_edge` (k,), `impact_toi` (k,), `impact_weights` (k, 4) and `impact_normals` (k, 3).
"""

import io
import json
import os
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, Protocol

import numpy as np

from izo_ref.base.archives import names_in, read_archive
from izo_ref.base.arrays import Multipliers, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import FilePath, open_input
from izo_ref.base.records import Impacts
from izo_ref.base.values import plain_text
from izo_ref.base.whole_files import write_whole
from izo_ref.scene import Scene

REQUIRED = ("positions_t0", "positions_t1", "faces")
OPTIONAL = ("masses", "pinned")

SHOWN = 8  # names of arrays that a message lists
ARCHIVE = b"PK"  # how an archive begins
MESHES = (".obj", ".ply", ".stl", ".off", ".gltf", ".glb", ".usd", ".usda", ".usdc", ".abc", ".fbx")


def load_scene(
    path: FilePath,
    initial_intersections: str = "raise",
    prescribed: str = "exclude",
    weld: float | None = None,
) -> Scene:
    """Read a step.

    Args:
        path: The archive.
        initial_intersections: `raise`, `ratchet` or `exclude`; see `Scene`.
        prescribed: `exclude` or `block`; see `Scene`.
        weld: How far apart vertices may be that are one vertex [m], or None; see `Scene`.

    Returns:
        The step.

    Raises:
        FileFormatError: The file cannot be read, or an array is missing.
        IzoError: `Scene` does not accept the arrays.
    """
    arrays = _load(path, REQUIRED, OPTIONAL)
    optional = {name: arrays[name] for name in OPTIONAL if name in arrays}
    required = [arrays[name] for name in REQUIRED]
    return Scene(
        *required,
        **optional,
        initial_intersections=initial_intersections,
        prescribed=prescribed,
        weld=weld,
    )


class SavedResult(NamedTuple):
    """A result as it is in a file; None for what is not in the file.

    Attributes:
        positions: (n, 3) [m], end of the path.
        thickness: The thickness [m].
        impacts: The impacts in zones.
        multipliers: (n_impacts,) [kg].
    """

    positions: Positions
    thickness: float | None
    impacts: Impacts | None
    multipliers: Multipliers | None


class ResultToSave(Protocol):
    """What `save_result` writes of a `Result` or a `SavedResult`."""

    @property
    def positions(self) -> Positions:
        """(n, 3) f8 [m], end of the path."""
        ...

    @property
    def thickness(self) -> float | None:
        """The thickness [m], or None."""
        ...

    @property
    def impacts(self) -> Impacts | None:
        """The impacts in zones, or None."""
        ...

    @property
    def multipliers(self) -> Multipliers | None:
        """(n_impacts,) f8 [kg], or None."""
        ...


def load_result(path: FilePath) -> SavedResult:
    """Read a result of this or of another program; only the positions are required.

    Args:
        path: The archive.

    Returns:
        The result.

    Raises:
        FileFormatError: The file cannot be read, or has no positions, or has only some of the
            arrays that describe the zones.
    """
    names = ("thickness", "multipliers", *(f"impact_{name}" for name in Impacts._fields))
    arrays = _load(path, ("positions",), names)
    positions = arrays["positions"]
    if positions.ndim != 2 or positions.shape[1] != 3 or positions.dtype.kind not in "fiu":
        raise FileFormatError(
            f"{path}: expected positions of shape (n, 3), real numbers [m], got shape "
            f"{positions.shape} and type {positions.dtype}"
        )
    missing = [name for name in names if name not in arrays]
    if missing == list(names) or missing == list(names)[1:]:
        return SavedResult(arrays["positions"], _thickness(path, arrays), None, None)
    if missing:
        verb = "is" if len(missing) == 1 else "are"
        raise FileFormatError(
            f"{path}: has arrays of impacts, but {', '.join(missing)} {verb} missing; write all "
            "arrays that describe the zones, or none"
        )
    impacts = Impacts(*(arrays[name] for name in names[2:]))
    shapes = {name: arrays[name].shape for name in names[1:]}
    if len({shape[:1] for shape in shapes.values()}) != 1 or () in shapes.values():
        found = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise FileFormatError(f"{path}: expected a row for each impact, found the shapes {found}")
    return SavedResult(
        arrays["positions"], _thickness(path, arrays), impacts, arrays["multipliers"]
    )


def _thickness(path: FilePath, arrays: dict[str, Any]) -> float | None:
    if "thickness" not in arrays:
        return None
    array = arrays["thickness"]
    if array.shape != () or array.dtype.kind not in "fiu":
        raise FileFormatError(
            f"{path}: expected thickness to be one number [m], got shape {array.shape} and type "
            f"{array.dtype}"
        )
    return float(array)


def save_result(path: FilePath, result: ResultToSave) -> None:
    """Write a result; the file appears whole or not at all.

    Args:
        path: Where to write the archive.
        result: Positions, thickness, impacts and multipliers, as a `Result` or a `SavedResult` has
            them; all but the positions may be None.

    Raises:
        FileFormatError: The file cannot be written.
    """
    arrays: dict[str, Any] = {"positions": result.positions}
    if result.thickness is not None:
        arrays["thickness"] = result.thickness
    if result.impacts is not None:
        arrays["multipliers"] = result.multipliers
        columns = result.impacts._asdict().items()
        arrays |= {f"impact_{name}": column for name, column in columns}
    with replacing(path) as file:
        np.savez_compressed(file, **arrays)


def save_scene(path: FilePath, scene: Scene) -> None:
    """Write a step; the file appears whole or not at all.

    If vertices are welded, the file has all vertices, with the faces, masses and pinned vertices as
    they were passed in. It is the same step for who welds it again.

    Raises:
        FileFormatError: The file cannot be written.
    """
    arrays: dict[str, Any] = {name: getattr(scene, name) for name in REQUIRED + OPTIONAL}
    arrays |= scene.unwelded
    with replacing(path) as file:
        np.savez_compressed(file, **arrays)


def save_json(path: FilePath, content: Any) -> None:
    """Write a report as JSON; the file appears whole or not at all.

    Raises:
        FileFormatError: The file cannot be written.
    """
    save_text(path, json.dumps(content, indent=1) + "\n")


def check_writable(path: FilePath) -> None:
    """Check that a file can be written, before work is done that would be lost.

    Args:
        path: The file to write or to replace.

    Raises:
        FileFormatError: The file cannot be written; says why.
    """
    real = Path(os.path.realpath(path))
    problem = None
    try:
        if real.is_dir():
            problem = "it is a folder; name a file in it"
        elif not real.parent.is_dir():
            problem = f"there is no folder {_folder_of(path, real)}; create it"
        elif real.exists() and not os.access(real, os.W_OK):
            problem = "the file there is read-only"
        elif not _is_special(real) and not os.access(real.parent, os.W_OK | os.X_OK):
            problem = f"no permission to write to {_folder_of(path, real)}"
    except OSError as error:  # such as a name that is too long
        problem = error.strerror or str(error)
    if problem is not None:
        raise FileFormatError(f"{path}: cannot be written: {problem}")


def _folder_of(path: FilePath, real: Path) -> Path:
    """Return the folder of a file, as the user named it if it is no link."""
    return real.parent if Path(path).is_symlink() else Path(path).parent


def _is_special(path: Path) -> bool:
    """Return whether a path is a device or a pipe, such as `/dev/null`, which holds no file."""
    return path.exists() and not path.is_file() and not path.is_dir()


def make_folder(path: FilePath) -> None:
    """Create a folder for outputs, and those above it, unless it exists; check that it is writable.

    Raises:
        FileFormatError: It cannot be created, or nothing can be written to it.
    """
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise FileFormatError(f"{path}: expected a folder, found a file") from None
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be created: {error.strerror or error}") from None
    if not os.access(path, os.W_OK | os.X_OK):
        raise FileFormatError(f"{path}: no permission to write to this folder")


def check_outputs(inputs: dict[str, FilePath | None], outputs: dict[str, FilePath | None]) -> None:
    """Check that outputs can be written, and that none replaces an input or another output.

    Args:
        inputs: The files that are read, by what the user calls them; None for one that is not
            given.
        outputs: The files that will be written, in the same way.

    Raises:
        FileFormatError: A file cannot be written, or two of the files are the same.
    """
    names = {_real(path): name for name, path in inputs.items() if path is not None}
    for name, path in outputs.items():
        if path is None:
            continue
        check_writable(path)
        if _is_special(Path(path)):
            continue  # nothing is lost there
        other = names.setdefault(_real(path), name)
        if other != name:
            raise FileFormatError(
                f"{path}: {name} is the same file as {other}, which would be lost; name another "
                "file"
            )


def _real(path: FilePath) -> str:
    """Return the name of a file without links, in the way that the system compares names."""
    return os.path.normcase(os.path.realpath(path))


def _load(path: FilePath, names: Sequence[str], optional: Collection[str] = ()) -> dict[str, Any]:
    """Read the arrays of an archive that has to have some names, and may have others."""
    with open_input(path) as file:
        _require_archive(path, file.read(len(ARCHIVE)))
    found = names_in(path)
    missing = [name for name in names if name not in found]
    if missing:
        listed = ", ".join(map(plain_text, found[:SHOWN])) or "no array"
        raise FileFormatError(
            f"{path}: expected the arrays {', '.join(names)}; {', '.join(missing)} missing, "
            f"found {listed}"
        )
    arrays = read_archive(path, {*names, *optional})
    texts = [name for name, array in arrays.items() if array.dtype.kind == "U"]
    if texts:
        raise FileFormatError(f"{path}: the array {texts[0]}: expected numbers, found texts")
    return arrays


def _require_archive(path: FilePath, begin: bytes) -> None:
    """Raise an error if a file does not begin like an .npz archive."""
    if begin == ARCHIVE:
        return
    suffix = Path(path).suffix.lower()
    if not begin:
        found = "an empty file"
    elif begin == np.lib.format.MAGIC_PREFIX[: len(begin)]:
        found = "a single array of numpy"
    elif suffix in ("", ".npz"):
        found = "something else"
    else:
        found = f"a file of another format ({suffix})"
    advice = ""
    if suffix in MESHES:
        advice = (
            ". Load the meshes of the start and of the proposed end with a library such as "
            "trimesh, and save their arrays with numpy.savez"
        )
    raise FileFormatError(
        f"{path}: expected an .npz archive, which is the only format that is read, found "
        f"{found}{advice}"
    )


@contextmanager
def replacing(path: FilePath) -> Iterator[BinaryIO]:
    """Collect the content of a file, which takes the place of `path` when the block ends.

    If the block raises an error, or the file cannot be written, an old file stays as it was.

    Args:
        path: The file to write or to replace.

    Raises:
        FileFormatError: The file cannot be written.
    """
    content = io.BytesIO()
    yield content
    try:
        write_whole(path, content.getbuffer())
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be written: {error.strerror or error}") from None


def save_text(path: FilePath, text: str) -> None:
    """Write a text; the file appears whole or not at all.

    Raises:
        FileFormatError: The file cannot be written.
    """
    with replacing(path) as file:
        file.write(text.encode())
