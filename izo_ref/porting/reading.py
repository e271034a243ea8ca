"""Where to read about a stage: lines of our own implementation, and the page of the method."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path
from typing import NamedTuple

from izo_ref.porting.stages import Stage

ROOT = Path(__file__).resolve().parents[2]  # of the checkout, or the folder of installed packages


class Lines(NamedTuple):
    """Lines of a source file.

    Attributes:
        path: Path from the root of the repository.
        name: Function or class.
        first: Its first line, counted from 1.
        last: Its last line.
    """

    path: str
    name: str
    first: int
    last: int

    def __str__(self) -> str:
        """Return `path:first-last name`."""
        return f"{self.path}:{self.first}-{self.last} {self.name}"


def lines_of(stage: Stage) -> Lines:
    """Return the lines of our own implementation of a stage.

    Args:
        stage: The stage.
    """
    path, _, name = stage.source.partition(":")
    return _find(path, name)


@cache
def _find(path: str, name: str) -> Lines:
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            first = min([node.lineno, *(item.lineno for item in node.decorator_list)])
            return Lines(path, name, first, node.end_lineno or first)
    raise LookupError(f"{path}: expected a function or a class {name}, found none")


def method_page(stage: Stage) -> str:
    """Return the path of the page that explains a stage, from the root of the repository."""
    return f"docs/method/{stage.method}.md"


def shown_lines(stage: Stage) -> str:
    """Return file, lines and name of our own implementation, as they can be opened from here.

    Args:
        stage: The stage.
    """
    try:
        return _from_here(str(lines_of(stage)))
    except (OSError, LookupError):  # an installation without sources
        return stage.source


def shown_page(stage: Stage) -> str:
    """Return the page that explains a stage, as it can be opened from here.

    Args:
        stage: The stage.
    """
    page = method_page(stage)
    return _from_here(page) if (ROOT / page).is_file() else f"{page} of the repository"


def _from_here(path: str) -> str:
    """Return a path from the root as it is if the root is the current folder, else in full."""
    return path if Path.cwd() == ROOT else f"{ROOT}/{path}"
