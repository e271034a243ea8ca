"""Run the tests on copies of the repository that have one fault each.

First a snapshot of the tree is taken, so edits during the run do not matter. The tests that should
notice run on the snapshot without any fault, and they have to pass, since otherwise a failure would
mean nothing. Then each fault gets a fresh copy, always at the same place, and a cache of compiled
code of its own. If a fault changes no compiled file, the cache starts with the code of the first
run, since that code is the same.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from izo_ref.app.files import save_json
from validation.mutants.fault import Fault
from validation.mutants.faults import FAULTS

ROOT = Path(__file__).resolve().parents[2]
LEFT_OUT = shutil.ignore_patterns(
    ".git", ".venv", ".cache", "build", "__pycache__", ".pytest_cache", ".ruff_cache", "*.egg-info"
)
# This test compares the list with the sources, so it notices every fault, which proves nothing.
LIST_TEST = "tests/validation/test_mutants.py"
COMPILED = re.compile(r"izo_ref/(\w+/(formulas|serial|cpu)/|base/compile\.py)")
WHOLE_SUITE_LIMIT_S = 3600.0
PASSED, FAILED, INTERRUPTED = 0, 1, 2  # exit codes of pytest


def run_mutants(
    names: Iterable[str] | None = None,
    json_path: str | Path | None = None,
    *,
    root: Path = ROOT,
    faults: Sequence[Fault] = FAULTS,
    whole: bool = True,
) -> list[dict[str, Any]]:
    """Apply each fault to a copy of the repository and run the tests there.

    Args:
        names: Names of the faults to run; all if None.
        json_path: File to which the rows are written after each of them; none if None.
        root: Root of the repository.
        faults: The faults.
        whole: If the tests that a fault names all pass, run the whole suite.

    Returns:
        One row for each fault: name, file, what, origin, caught, by (the first test that failed,
        or how the run ended), whole (whether the whole suite ran), seconds.

    Raises:
        ValueError: A name is unknown.
        RuntimeError: Tests fail without any fault, or pytest cannot run.
    """
    chosen = choose(names, faults)
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        bench = Bench(Path(folder), root)
        bench.check_without_fault(sorted({test for fault in chosen for test in fault.tests}))
        for fault in chosen:
            rows.append(_row(bench, fault, whole))
            print(_line(rows[-1]), flush=True)
            if json_path is not None:
                save_json(json_path, rows)
    return rows


def choose(names: Iterable[str] | None, faults: Sequence[Fault]) -> list[Fault]:
    """Return the faults with some names; all if None.

    Raises:
        ValueError: A name is unknown.
    """
    wanted = None if names is None else set(names)
    unknown = (wanted or set()) - {fault.name for fault in faults}
    if unknown:
        raise ValueError(f"mutants: no faults named {sorted(unknown)}")
    return [fault for fault in faults if wanted is None or fault.name in wanted]


class Bench:
    """Makes copies of the repository and runs tests in them.

    Args:
        folder: A folder for the copies.
        root: Root of the repository.

    Attributes:
        tree: The copy under test; it is always at the same place, on which numba's cache depends.
        snapshot: The repository as it was, without any fault.
    """

    def __init__(self, folder: Path, root: Path) -> None:
        """Take a snapshot of the repository."""
        self.tree, self.snapshot = folder / "tree", folder / "snapshot"
        self._cache, self._warm = folder / "cache", folder / "warm"
        self._data = os.environ.get("IZO_DATA", root.parent / "shared" / "data")
        shutil.copytree(root, self.snapshot, ignore=LEFT_OUT)

    def check_without_fault(self, tests: Sequence[str]) -> None:
        """Run tests on the snapshot, and keep the compiled code for faults outside that code.

        Args:
            tests: Arguments of pytest.

        Raises:
            RuntimeError: A test fails.
        """
        self.restore()
        begin = time.perf_counter()
        code, by, output = self.test(tests, WHOLE_SUITE_LIMIT_S)
        if code != PASSED:
            raise RuntimeError(f"mutants: without any fault: {by}\n{output}")
        print(f"without fault: passed, {time.perf_counter() - begin:.0f} s", flush=True)
        package = self._cache / "izo_ref"
        if package.is_dir():
            shutil.move(next(package.iterdir()), self._warm)

    def apply(self, fault: Fault) -> None:
        """Make a fresh copy with one fault.

        Raises:
            RuntimeError: The text of the fault does not occur exactly once in its file.
        """
        self.restore()
        path = self.tree / fault.file
        text = path.read_text()
        if text.count(fault.old) != 1:
            raise RuntimeError(
                f"mutants: {fault.name}: expected its text once in {fault.file}, "
                f"got it {text.count(fault.old)} times"
            )
        path.write_text(text.replace(fault.old, fault.new))
        if self._warm.is_dir() and not COMPILED.match(fault.file):
            shutil.copytree(self._warm, self._cache_folder(), dirs_exist_ok=True)

    def test(
        self, arguments: Sequence[str], limit_s: float, changes: Mapping[str, str] | None = None
    ) -> tuple[int | None, str, str]:
        """Run tests in the copy.

        Args:
            arguments: Arguments of pytest; the whole suite if there are none.
            limit_s: Seconds after which the tests are stopped.
            changes: Variables of the environment that are set besides.

        Returns:
            Exit code of pytest, None after a timeout; the first failure; the end of the output.
        """
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
        command += [f"--ignore={LIST_TEST}", *arguments]
        log = self.tree.with_name("log.txt")
        with open(log, "w") as out:
            process = subprocess.Popen(
                command,
                cwd=self.tree,
                env=self._environment() | dict(changes or {}),
                stdout=out,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            try:
                code = process.wait(limit_s)
            except subprocess.TimeoutExpired:
                code = None
            finally:
                if process.poll() is None:
                    os.killpg(process.pid, signal.SIGKILL)
                    process.wait()
        lines = log.read_text(errors="replace").splitlines()
        return code, _first_failure(code, lines), "\n".join(lines[-40:])

    def restore(self) -> None:
        """Make a fresh copy without any fault, and start with an empty cache."""
        for folder in (self.tree, self._cache):
            shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.snapshot, self.tree)

    def _environment(self) -> dict[str, str]:
        """Return the environment of the processes that run in the copy."""
        changes = {
            "IZO_DATA": str(self._data),
            "XDG_CACHE_HOME": str(self._cache),
            "PYTHONPATH": str(self.tree),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        return os.environ | changes

    def _cache_folder(self) -> Path:
        """Return the folder of the copy's compiled code; its name depends on the sources."""
        code = "from izo_ref.base.compile import CACHE_FOLDER; print(CACHE_FOLDER)"
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=self.tree,
            env=self._environment(),
            capture_output=True,
            text=True,
            check=True,
        )
        return Path(done.stdout.strip())


def _row(bench: Bench, fault: Fault, whole: bool) -> dict[str, Any]:
    """Run the tests with one fault and return its row."""
    begin = time.perf_counter()
    bench.apply(fault)
    code, by, output = bench.test(fault.tests, fault.limit_s)
    took_all = whole and code == PASSED
    if took_all:
        code, by, output = bench.test((), WHOLE_SUITE_LIMIT_S)
    if code is not None and code > INTERRUPTED:
        raise RuntimeError(f"mutants: {fault.name}: pytest could not run\n{output}")
    return {
        "name": fault.name,
        "file": fault.file,
        "what": fault.what,
        "origin": fault.origin,
        "caught": code != PASSED,
        "by": by,
        "whole": took_all,
        "seconds": round(time.perf_counter() - begin, 1),
    }


def _first_failure(code: int | None, lines: Sequence[str]) -> str:
    """Return the test that failed first, or how the run ended instead."""
    if code is None:
        return "caught by timeout"
    if code < 0:
        return f"caught by signal {-code}"
    for line in lines:
        kind, _, rest = line.partition(" ")
        if kind in ("FAILED", "ERROR") and rest.startswith("tests/"):
            return rest.split(" - ")[0]
    return "" if code == PASSED else f"exit code {code}"


def _line(row: dict[str, Any]) -> str:
    """Return the line that is printed for a row."""
    verdict = f"caught by {row['by'].removeprefix('caught by ')}" if row["caught"] else "SURVIVED"
    return f"{row['name']}: {verdict} ({row['seconds']:.0f} s)"
