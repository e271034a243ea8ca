"""Layout of the package, measured from its sources: rooms, floors, imports and sizes.

A *room* is a stage, which is a folder of `izo_ref`, or a file beside the stages. A room stands on
the floor above the highest room that it imports. An *arrow* is an import from one room by another.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
BEGIN, END = "<!-- floors:begin -->", "<!-- floors:end -->"
# The implementation of a function for a GPU is named by a string: `base/devices.py`.
NAMED = re.compile(r"(izo_ref(?:\.\w+)+):(\w+)")
# Files that only import names, so that others can import them from there.
FACES = ("__init__", "version")


class Import(NamedTuple):
    """One import of a module of the package by another."""

    importer: str
    imported: str
    line: int


class Lengths(NamedTuple):
    """Lengths [lines] of all functions of the package."""

    median: float
    percentile_90: float
    longest: tuple[int, str]


class Sizes(NamedTuple):
    """Lengths [lines] and parameters of the files and functions of the package."""

    files: int
    longest_file: tuple[int, str]
    functions: int
    whole: Lengths
    bodies: Lengths  # without signature and docstring
    many_parameters: int


@cache
def module_paths(root: Path = ROOT, package: str = "izo_ref") -> dict[str, Path]:
    """Return the file of each module of a package, by the module's full name."""
    paths = sorted((root / package).rglob("*.py"))
    return {_module_name(path.relative_to(root)): path for path in paths}


def _module_name(path: Path) -> str:
    """Return the full name of a module from its path, relative to the root."""
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def imports(root: Path = ROOT, package: str = "izo_ref") -> tuple[Import, ...]:
    """Return all imports between modules of a package.

    An import inside a function counts, and so does a module named by a string
    `izo_ref.module:name`. Imports by the package's own `__init__.py` do not count, because they
    only make names public.
    """
    modules = module_paths(root, package)
    return tuple(
        Import(importer, imported, line)
        for importer, path in modules.items()
        if importer != package
        for imported, line in _imported_modules(ast.parse(path.read_text()), modules)
    )


def _imported_modules(tree: ast.AST, modules: dict[str, Path]) -> Iterator[tuple[str, int]]:
    """Yield each of these modules that a file imports, and the line where it does."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                target = full if full in modules else node.module
                if target in modules:
                    yield target, node.lineno
        elif isinstance(node, ast.Import):
            yield from ((a.name, node.lineno) for a in node.names if a.name in modules)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            named = NAMED.fullmatch(node.value)
            if named:
                yield named[1], node.lineno


def room_of(module: str) -> str:
    """Return the room of a module: a stage, or a file beside the stages."""
    return module.split(".")[1] if "." in module else "__init__"


def arrows(root: Path = ROOT, package: str = "izo_ref") -> dict[str, set[str]]:
    """Return the rooms that each room of a package imports."""
    modules = module_paths(root, package)
    found: dict[str, set[str]] = {
        room_of(module): set() for module in modules if room_of(module) not in FACES
    }
    for importer, imported, _ in imports(root, package):
        a, b = room_of(importer), room_of(imported)
        if a != b and b not in FACES:
            found[a].add(b)
    return found


def floors(graph: dict[str, set[str]]) -> dict[str, int]:
    """Return the floor of each room; floor 1 imports nothing.

    Raises:
        ValueError: Some rooms import each other in a circle.
    """
    found: dict[str, int] = {}
    while len(found) < len(graph):
        ready = {
            room: 1 + max((found[other] for other in below), default=0)
            for room, below in graph.items()
            if room not in found and below <= found.keys()
        }
        if not ready:
            circle = sorted(graph.keys() - found.keys())
            raise ValueError(f"house: expected imports without a circle, found one among {circle}")
        found |= ready
    return found


def sizes(root: Path = ROOT) -> Sizes:
    """Return the lengths of files and functions, and how many functions take many parameters."""
    files, whole, bodies, many = [], [], [], 0
    for module, path in module_paths(root).items():
        text = path.read_text()
        files.append((len(text.splitlines()), module))
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef):
                name, end = f"{module}.{node.name}", node.end_lineno or node.lineno
                body = node.body[1:] if ast.get_docstring(node) else node.body
                first = body[0].lineno if body else end + 1
                whole.append((end - node.lineno + 1, name))
                bodies.append((end - first + 1, name))
                arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
                many += len(arguments) > 10
    return Sizes(len(files), max(files), len(whole), _lengths(whole), _lengths(bodies), many)


def _lengths(functions: list[tuple[int, str]]) -> Lengths:
    lines = [length for length, _ in functions]
    return Lengths(float(np.median(lines)), float(np.percentile(lines, 90)), max(functions))


def picture(root: Path = ROOT) -> str:
    """Return the floors as text, from the top: each room, what it is, and what it imports."""
    graph = arrows(root)
    floor_of = floors(graph)
    rooms = sorted(graph, key=lambda room: (-floor_of[room], room))
    names = {room: _folder_name(room, root) for room in rooms}
    below = {
        room: ", ".join(sorted(graph[room], key=lambda r: (-floor_of[r], r))) or "-"
        for room in rooms
    }
    width = max(map(len, names.values()))
    lines = []
    for room in rooms:
        lines.append(f"{floor_of[room]}  {names[room].ljust(width)}  {_first_line(room, root)}")
        lines.append(f"   {' ' * width}  imports {below[room]}")
    return "\n".join(lines)


def _folder_name(room: str, root: Path) -> str:
    return f"{room}/" if (root / "izo_ref" / room).is_dir() else f"{room}.py"


def _first_line(room: str, root: Path) -> str:
    """Return the first line of the docstring of a room."""
    path = root / "izo_ref" / room
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    lines = (ast.get_docstring(ast.parse(path.read_text())) or "").splitlines()
    return lines[0] if lines else ""


def summary(root: Path = ROOT) -> str:
    """Return the numbers of rooms, floors, imports, files and functions in a few lines."""
    graph = arrows(root)
    try:
        n_floors = str(max(floors(graph).values()))
    except ValueError as error:
        n_floors = f"none ({error})"
    found = sizes(root)
    return "\n".join(
        (
            f"rooms {len(graph)}, floors {n_floors}, arrows {sum(map(len, graph.values()))}",
            f"files {found.files}, the longest {found.longest_file[1]}: {found.longest_file[0]}",
            f"functions {found.functions}",
            f"lines of a function: {_in_words(found.whole)}",
            f"without signature and docstring: {_in_words(found.bodies)}",
            f"functions with more than ten parameters: {found.many_parameters}",
        )
    )


def _in_words(lengths: Lengths) -> str:
    length, name = lengths.longest
    return (
        f"median {lengths.median:g}, 90th percentile {lengths.percentile_90:g}, longest {length} "
        f"({name})"
    )


def with_picture(text: str, root: Path = ROOT) -> str:
    """Return a text in which the picture of the floors, between two marks, is up to date."""
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n```\n{picture(root)}\n```\n{END}{after}"
