"""Find, read and check the folder of the vectors.

In an installed package the folder is `vectors_v1` beside this file; in a checkout it is
`data/vectors/v1`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from izo_ref.base.errors import FileFormatError, VectorsError
from izo_ref.base.input_files import read_bytes, read_text
from izo_ref.base.values import shown
from izo_ref.porting.cases import Case, case_of, require_cases
from izo_ref.porting.npy import npy_numbers
from izo_ref.porting.stages import STAGES

VERSION = "v1"
SUMS = "SHA256SUMS"
INSTALLED = Path(__file__).resolve().parent / f"vectors_{VERSION}"
CHECKOUT = Path(__file__).resolve().parents[2] / "data" / "vectors" / VERSION


def vectors_folder() -> Path:
    """Return the folder of the vectors that belong to this package.

    Raises:
        VectorsError: There is none.
    """
    for folder in (INSTALLED, CHECKOUT):
        if folder.is_dir():
            return folder
    raise VectorsError(
        f"expected the vectors in {CHECKOUT} or {INSTALLED}, found neither folder; "
        "`izo vectors make -o FOLDER` makes them"
    )


def load_cases(folder: Path | None = None, stages: Iterable[str] | None = None) -> list[Case]:
    """Read cases, in the order of the stages and of the files.

    Args:
        folder: The folder of the vectors; the one of this package if None.
        stages: Names of stages; all if None.

    Raises:
        VectorsError: A file is missing or damaged.
    """
    folder = vectors_folder() if folder is None else Path(folder)
    names = [stage.name for stage in STAGES] if stages is None else stages
    return [case for name in names for case in _load_stage(folder, name)]


def load_case(case_id: str, folder: Path | None = None) -> Case:
    """Read one case.

    Args:
        case_id: Its id.
        folder: The folder of the vectors; the one of this package if None.

    Raises:
        VectorsError: There is no such case; the message names the nearest ids.
    """
    import difflib

    stage = case_id.partition("-")[0]
    stages = [stage] if stage in (s.name for s in STAGES) else None
    cases = {case.id: case for case in load_cases(folder, stages)}
    if case_id not in cases:
        near = ", ".join(difflib.get_close_matches(case_id, cases, cutoff=0.3)) or "none"
        raise VectorsError(f"expected the id of a case, found {case_id!r}; near ids are: {near}")
    return cases[case_id]


def _load_stage(folder: Path, stage: str) -> list[Case]:
    path = folder / f"{stage}.json"
    try:
        records = json.loads(read_text(path, "ascii"))["cases"]
        cases = [case_of(_with_arrays(record, folder)) for record in records]
        require_cases(cases, stage)
        return cases
    except FileFormatError as error:
        raise VectorsError(str(error)) from None
    except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError) as error:
        raise _damaged(path, error) from None
    except RecursionError:
        raise _damaged(path, "lists in lists in lists, too deep to read") from None


def _damaged(path: Path, error: object) -> VectorsError:
    return VectorsError(f"{path}: is damaged: {shown(error)}; `izo vectors verify` says more")


def _with_arrays(value: Any, folder: Path) -> Any:
    """Return a value of JSON with the arrays of `.npy` files in it."""
    if isinstance(value, list):
        return (
            value
            if not value or not isinstance(value[0], dict)
            else [_with_arrays(item, folder) for item in value]
        )
    if not isinstance(value, dict):
        return value
    if value.keys() == {"npy"}:
        name = value["npy"]
        if not isinstance(name, str) or not _is_name(name):
            raise ValueError(f"npy: expected the name of a file of this folder, got {shown(name)}")
        path = folder / name
        try:
            return npy_numbers(_content(path))
        except VectorsError as error:
            raise VectorsError(f"{path}: {error}") from None
    return {name: _with_arrays(item, folder) for name, item in value.items()}


def sums_text(contents: dict[str, bytes]) -> str:
    """Return the content of SHA256SUMS, which `sha256sum -c` reads.

    Args:
        contents: The content of each file, by its name.
    """
    lines = (f"{hashlib.sha256(contents[name]).hexdigest()}  {name}\n" for name in sorted(contents))
    return "".join(lines)


def listed_sums(folder: Path) -> dict[str, str]:
    """Return the sum of each file that SHA256SUMS names.

    Args:
        folder: The folder of the vectors.

    Raises:
        VectorsError: The file is missing or damaged.
    """
    path = folder / SUMS
    try:
        lines = read_text(path, "ascii").splitlines()
    except FileFormatError as error:
        raise VectorsError(str(error)) from None
    pairs = [line.split("  ", 1) for line in lines]
    other = [i for i, pair in enumerate(pairs, 1) if len(pair) != 2 or not _is_name(pair[1])]
    if other:
        raise VectorsError(
            f"{path}, line {other[0]}: expected lines of a sum, two spaces and a name of a file "
            f"of this folder, got {shown(lines[other[0] - 1])}"
        )
    return {name: total for total, name in pairs}


def _is_name(name: str) -> bool:
    """Return whether a name is that of a file in a folder, and not of one elsewhere."""
    return "\0" not in name and name == Path(name).name


def _content(path: Path) -> bytes:
    try:
        return read_bytes(path)
    except FileFormatError as error:
        raise VectorsError(str(error)) from None


def wrong_files(folder: Path) -> list[str]:
    """Return a line for each file that is missing, changed, or not named in SHA256SUMS.

    Args:
        folder: The folder of the vectors.

    Raises:
        VectorsError: SHA256SUMS itself is missing or damaged.
    """
    sums = listed_sums(folder)
    problems = []
    for name, expected in sums.items():
        path = folder / name
        if not path.is_file():
            problems.append(f"{name}: is missing")
        elif hashlib.sha256(_content(path)).hexdigest() != expected:
            problems.append(f"{name}: differs from its sum in {SUMS}")
    others = sorted(path.name for path in folder.iterdir() if path.name not in {*sums, SUMS})
    return problems + [f"{name}: is not named in {SUMS}" for name in others]
