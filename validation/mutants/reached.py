"""Which tests enter which functions of the package, and how long each takes in pure Python."""

import ast
import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from validation.mutants.draw import Drawn
from validation.mutants.reach import LIMIT, REACH

# The folders of tests that mirror the stages that faults are drawn from.
FOLDERS = ("base", "certificate", "detection", "loop", "solvers", "zones")
# Seconds for one test in pure Python, while its calls are watched. A slower test runs compiled.
TEST_S = 4
PURE = {"NUMBA_DISABLE_JIT": "1", "NUMBA_NUM_THREADS": "1", "PYTHONWARNINGS": "ignore"}


class Test(NamedTuple):
    """A test, and what it does in pure Python without any fault.

    Attributes:
        name: Its name for pytest.
        passed: Whether it passes in pure Python within the limit.
        seconds: How long it takes there while its calls are watched.
        entered: The functions that it enters, `stage/file.py:function`.
    """

    name: str
    passed: bool
    seconds: float
    entered: frozenset[str]


def watch_tests(root: Path, cache: Path) -> list[Test]:
    """Run the tests in pure Python and note what each of them enters.

    Args:
        root: Root of a copy of the repository without any fault.
        cache: Folder where the notes are kept. A file of tests is run again if it has changed, or
            any source of the package.
    """
    cache.mkdir(parents=True, exist_ok=True)
    sources = hashlib.sha256()
    for path in sorted((root / "izo_ref").rglob("*.py")):
        sources.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    found: list[Test] = []
    for file in sorted(path for name in FOLDERS for path in (root / "tests" / name).glob("test_*")):
        digest = sources.copy()
        digest.update(file.read_bytes())
        notes = cache / f"{file.stem}-{digest.hexdigest()[:16]}.jsonl"
        if not notes.is_file():
            print(f"watching {file.relative_to(root)}", flush=True)
            _watch(root, file, notes)
        found += [_test(line) for line in notes.read_text().splitlines()]
    return found


def _watch(root: Path, file: Path, notes: Path) -> None:
    """Run one file of tests, and write its notes."""
    partial = notes.with_suffix(".part")
    partial.unlink(missing_ok=True)
    changes = PURE | {REACH: str(partial), LIMIT: str(TEST_S), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "ignore"]
    command += ["-p", "validation.mutants.reach", str(file.relative_to(root))]
    with open(os.devnull, "w") as out:
        env = os.environ | changes | {"PYTHONPATH": str(root)}
        subprocess.run(command, cwd=root, env=env, stdout=out, stderr=out, check=False)
    partial.touch()
    partial.replace(notes)


def _test(line: str) -> Test:
    note = json.loads(line)
    return Test(note["test"], note["passed"], note["seconds"], frozenset(note["entered"]))


def tests_of(fault: Drawn, tests: Sequence[Test], users: Iterable[str]) -> list[Test]:
    """Return the tests that enter the code of a fault, the fastest first.

    Args:
        fault: The fault.
        tests: The tests.
        users: The functions that use the constants that the fault changes.
    """
    wanted = set(users) if fault.names else {f"{_inner(fault.file)}:{fault.where}"}
    # a function inside the function, or a comprehension
    inside = () if fault.names else tuple(f"{name}." for name in wanted)
    chosen = [
        test
        for test in tests
        if test.entered & wanted or (inside and any(one.startswith(inside) for one in test.entered))
    ]
    return sorted(chosen, key=lambda test: (test.seconds, test.name))


def users_of(root: Path, names: Iterable[str]) -> set[str]:
    """Return the functions of the package that use constants, `stage/file.py:function`.

    A constant that sets another constant is followed.

    Args:
        root: Root of the repository.
        names: Names of the constants.
    """
    wanted, found = set(names), set[str]()
    trees = {path: ast.parse(path.read_text()) for path in (root / "izo_ref").rglob("*.py")}
    for _ in range(3):
        for path, tree in trees.items():
            for node in tree.body:
                if not wanted & {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}:
                    continue
                if isinstance(node, ast.Assign):
                    wanted |= {one.id for one in node.targets if isinstance(one, ast.Name)}
                file = _inner(path.relative_to(root).as_posix())
                found |= {f"{file}:{name}" for name in _functions(node, wanted)}
    return found


def _functions(node: ast.stmt, wanted: set[str]) -> list[str]:
    """Return the functions and methods of a statement of a module that use some names."""
    owner = f"{node.name}." if isinstance(node, ast.ClassDef) else ""
    inner = node.body if isinstance(node, ast.ClassDef) else [node]
    return [
        owner + one.name
        for one in inner
        if isinstance(one, ast.FunctionDef)
        and wanted & {part.id for part in ast.walk(one) if isinstance(part, ast.Name)}
    ]


def _inner(file: str) -> str:
    return file.removeprefix("izo_ref/")
