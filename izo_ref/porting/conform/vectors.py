"""Where the vectors are, and reading them: the only place of the harness that knows."""

from __future__ import annotations

import ast
import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from izo_ref.base.errors import FileFormatError
from izo_ref.porting.cases import Case, case_of
from izo_ref.porting.stages import STAGE, Stage

PACKAGE = Path(__file__).resolve().parents[2]
DEFAULT = PACKAGE.parent / "data" / "vectors" / "v1"


def load_cases(folder: Path | None = None) -> list[Case]:
    """Return all cases of a folder of vectors.

    Args:
        folder: The folder; that of the repository if None.

    Raises:
        FileFormatError: There are no vectors, or a file cannot be read.
    """
    folder = folder or DEFAULT
    paths = [folder / f"{stage}.json" for stage in STAGE]
    paths = [path for path in paths if path.is_file()]
    if not paths:
        raise FileFormatError(f"{folder}: has no vectors S1.json to S13.json; see --vectors")
    cases = []
    for path in paths:
        try:
            records = json.loads(path.read_text(encoding="utf-8"))["cases"]
            cases += [case_of(_with_arrays(folder, record)) for record in records]
        except OSError as error:
            raise FileFormatError(f"{path}: cannot be read: {error.strerror}") from None
        except (ValueError, KeyError, TypeError) as error:
            raise FileFormatError(f"{path}: is no file of vectors: {error!r}") from None
    return cases


def _with_arrays(folder: Path, record: Mapping[str, Any]) -> dict[str, Any]:
    """Return a record with the arrays that are files of their own."""
    arrays = partial(_array, folder)
    return {**record, **{name: arrays(record[name]) for name in ("input", "expected")}}


def _array(folder: Path, value: Any) -> Any:
    if isinstance(value, dict):
        if value.keys() == {"npy"}:
            import numpy as np

            return np.load(folder / value["npy"], allow_pickle=False).ravel().tolist()
        return {name: _array(folder, item) for name, item in value.items()}
    return value


def explain_flag(name: str, folder: Path | None = None) -> str:
    """Return what the dictionary of flags says about a flag; empty if there is no dictionary."""
    try:
        content = json.loads(((folder or DEFAULT) / "flags.json").read_text(encoding="utf-8"))
        entry = next(flag for flag in content["flags"] if flag["name"] == name)
        return f"{entry['mistake']} {entry['harm']}"
    except (OSError, ValueError, KeyError, TypeError, StopIteration):
        return ""


def source_line(stage: Stage) -> str:
    """Return `path:line (name)` of our implementation of a stage; no line if it is not there."""
    path, _, name = stage.source.partition(":")
    try:
        tree = ast.parse((PACKAGE.parent / path).read_text(encoding="utf-8"))
    except (OSError, SyntaxError):
        return f"{path} ({name})"
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            return f"{path}:{node.lineno} ({name})"
    return f"{path} ({name})"
