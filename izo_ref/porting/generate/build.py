"""Make all files of the vectors from the generators, and write them whole or not at all.

The content of every file is made in memory first. So `izo vectors verify` compares it with a
folder without writing anything.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from izo_ref.base.errors import VectorsError
from izo_ref.base.whole_folder import replace_folder
from izo_ref.porting.cases import LARGE, Case, case_line
from izo_ref.porting.checks import check_cases
from izo_ref.porting.files import SUMS, listed_sums, sums_text
from izo_ref.porting.flags import flags_text
from izo_ref.porting.generate.readme import readme_text
from izo_ref.porting.lines import one_a_line
from izo_ref.porting.npy import npy_bytes
from izo_ref.porting.schema import schema_text
from izo_ref.porting.stages import STAGES

LARGEST = 10_000_000  # bytes of all files together

Contents = dict[str, bytes]


def generated_cases(stages: Iterable[str] | None = None) -> dict[str, list[Case]]:
    """Return the cases of the generators, by stage.

    Args:
        stages: Names of the stages; all if None.

    Raises:
        VectorsError: A stage has no generator.
    """
    names = [stage.name for stage in STAGES] if stages is None else stages
    return {name: _cases_of(name) for name in names}


def _cases_of(stage: str) -> list[Case]:
    module = f"izo_ref.porting.generate.s{int(stage[1:]):02d}"
    try:
        found = import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        raise VectorsError(f"{stage}: expected a generator {module}, found none") from None
    return found.cases()


def contents(cases: Mapping[str, list[Case]]) -> Contents:
    """Return the content of every file, by its name.

    Args:
        cases: The cases of each stage.

    Raises:
        VectorsError: A case is wrong, or the files are too large.
    """
    files: Contents = {}
    for stage, found in cases.items():
        check_cases(found, stage)
        lines = [case_line(_without_arrays(case, files)) for case in found]
        text = one_a_line({"version": 1, "stage": stage}, "cases", lines)
        files[f"{stage}.json"] = text.encode("ascii")
    files["flags.json"] = flags_text().encode("ascii")
    files["schema.json"] = schema_text().encode("ascii")
    every = [case for found in cases.values() for case in found]
    files["README.md"] = readme_text(every).encode("ascii")
    files[SUMS] = sums_text(files).encode("ascii")
    size = sum(len(content) for content in files.values())
    if size > LARGEST:
        name = max(files, key=lambda name: len(files[name]))
        raise VectorsError(
            f"expected at most {LARGEST:,} bytes in all files, found {size:,}; the largest file "
            f"is {name} with {len(files[name]):,}"
        )
    return files


def _without_arrays(case: Case, files: Contents) -> Case:
    """Return a case whose long arrays are replaced by the names of files, which are added."""
    inputs = {
        name: _outside(value, f"{case.id}.input.{name}.npy", files)
        for name, value in case.inputs.items()
    }
    expected = {
        name: {
            member: _outside(value, f"{case.id}.expected.{name}.{member}.npy", files)
            for member, value in members.items()
        }
        for name, members in case.expected.items()
    }
    return case._replace(inputs=inputs, expected=expected)


def _outside(value: Any, name: str, files: Contents) -> Any:
    if not isinstance(value, list) or len(value) <= LARGE or isinstance(value[0], str):
        return value
    try:
        files[name] = npy_bytes(value)
    except VectorsError as error:
        raise VectorsError(f"{name}: {error}") from None
    return {"npy": name}


def write_folder(files: Contents, folder: Path) -> None:
    """Write all files into a folder, in place of the vectors that it holds, or write nothing.

    Args:
        files: The content of each file, by its name.
        folder: The folder. It may exist if it is empty, or if it holds vectors and nothing else.

    Raises:
        VectorsError: The folder cannot be written, or holds something else.
    """
    folder = Path(folder)
    _require_vectors_alone(folder)
    if not folder.absolute().parent.is_dir():
        raise VectorsError(f"{folder}: cannot be written: create the folder above it first")
    try:
        replace_folder(files, Path(os.path.realpath(folder)))
    except OSError as error:
        raise VectorsError(f"{folder}: cannot be written: {error.strerror or error}") from None


def _require_vectors_alone(folder: Path) -> None:
    """Raise an error if something would be lost when a folder is replaced."""
    if not folder.exists():
        return
    if not folder.is_dir():
        raise VectorsError(f"{folder}: expected a folder, found a file")
    names = {path.name for path in folder.iterdir()}
    known = {SUMS, *listed_sums(folder)} if SUMS in names else set()
    others = sorted(names - known)
    if others:
        raise VectorsError(
            f"{folder}: would be replaced, and {others[0]} in it does not belong to vectors; name "
            "a new folder"
        )
