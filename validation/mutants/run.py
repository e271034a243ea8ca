"""Run the tests on copies of the repository with one fault each.

A snapshot of the tree is taken first, so edits in the meantime do not matter. The tests
that should notice are first run on the snapshot as it is: they have to pass, or a failure
would mean nothing. Each fault then gets a fresh copy, at the same place, and a cache of
compiled code of its own; one that touches no compiled file starts with the cache of the
first run, because the compiled files, and so the code, are the same.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from validation.mutants.faults import FAULTS

ROOT = Path(__file__).resolve().parents[2]
LEFT_OUT = shutil.ignore_patterns(
    ".git", ".venv", "build", "__pycache__", ".pytest_cache", ".ruff_cache", "*.egg-info"
)
# It compares the list with the sources and so would notice every fault, for no merit.
LIST_TEST = "tests/validation/test_mutants.py"
COMPILED = re.compile(r"izo_ref/(\w+/(formulas|serial|cpu)/|base/compile\.py)")
WHOLE_SUITE_LIMIT_S = 3600.0
PASSED, FAILED, INTERRUPTED = 0, 1, 2  # exit codes of pytest


def run_mutants(names=None, json_path=None, *, root=ROOT, faults=FAULTS, whole=True):
    """Apply each fault to a copy of the repository and run the tests there.

    Args:
        names: of the faults to run; all if None.
        json_path: where the rows are written, after each of them; nowhere if None.
        root: of the repository.
        faults: list of `Fault`.
        whole: run the whole suite on what the tests named by a fault let pass.

    Returns:
        A list of dicts, one a fault: name, file, what, origin, caught, by (the first test
        that failed, or how it ended), whole (whether it took the whole suite), seconds.

    Raises:
        ValueError: an unknown name. RuntimeError: tests fail without any fault.
    """
    unknown = set(names or ()) - {fault.name for fault in faults}
    if unknown:
        raise ValueError(f"mutants: no faults named {sorted(unknown)}")
    chosen = [fault for fault in faults if names is None or fault.name in names]
    rows = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        bench = _Bench(Path(folder), root)
        bench.check_without_fault(sorted({test for fault in chosen for test in fault.tests}))
        for fault in chosen:
            rows.append(_row(bench, fault, whole))
            print(_line(rows[-1]), flush=True)
            if json_path is not None:
                Path(json_path).write_text(json.dumps(rows, indent=1) + "\n")
    return rows


class _Bench:
    """Where copies are made and tested.

    Attributes:
        tree: the copy under test, always at the same place: numba's cache depends on it.
    """

    def __init__(self, folder, root):
        self.tree, self._snapshot = folder / "tree", folder / "snapshot"
        self._cache, self._warm = folder / "cache", folder / "warm"
        self._data = os.environ.get("IZO_DATA", root.parent / "shared" / "data")
        shutil.copytree(root, self._snapshot, ignore=LEFT_OUT)

    def check_without_fault(self, tests):
        """Run tests on the snapshot; they pass, or this raises.

        What they compile is kept for faults outside the compiled files.
        """
        self._fresh()
        begin = time.perf_counter()
        code, by, output = self.test(tests, WHOLE_SUITE_LIMIT_S)
        if code != PASSED:
            raise RuntimeError(f"mutants: without any fault: {by}\n{output}")
        print(f"without fault: passed, {time.perf_counter() - begin:.0f} s", flush=True)
        package = self._cache / "izo_ref"
        if package.is_dir():
            shutil.move(next(package.iterdir()), self._warm)

    def apply(self, fault):
        """Make a fresh copy with one fault."""
        self._fresh()
        path = self.tree / fault.file
        text = path.read_text()
        if text.count(fault.old) != 1:
            raise RuntimeError(f"mutants: {fault.name}: its text is not once in {fault.file}")
        path.write_text(text.replace(fault.old, fault.new))
        if self._warm.is_dir() and not COMPILED.match(fault.file):
            shutil.copytree(self._warm, self._cache_folder(), dirs_exist_ok=True)

    def test(self, arguments, limit_s):
        """Exit code of pytest, None after a timeout; first failure; end of the output."""
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
        command += [f"--ignore={LIST_TEST}", *arguments]
        log = self.tree.with_name("log.txt")
        with open(log, "w") as out:
            process = subprocess.Popen(
                command,
                cwd=self.tree,
                env=self._environment(),
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

    def _fresh(self):
        for folder in (self.tree, self._cache):
            shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self._snapshot, self.tree)

    def _environment(self):
        changes = {
            "IZO_DATA": str(self._data),
            "XDG_CACHE_HOME": str(self._cache),
            "PYTHONPATH": str(self.tree),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        return os.environ | changes

    def _cache_folder(self):
        """Where the package in the copy keeps compiled code: named by its sources."""
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


def _row(bench, fault, whole):
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


def _first_failure(code, lines):
    """The test that failed first, or how the run ended instead."""
    if code is None:
        return "caught by timeout"
    if code < 0:
        return f"caught by signal {-code}"
    for line in lines:
        kind, _, rest = line.partition(" ")
        if kind in ("FAILED", "ERROR") and rest.startswith("tests/"):
            return rest.split(" - ")[0]
    return "" if code == PASSED else f"exit code {code}"


def _line(row):
    verdict = f"caught by {row['by'].removeprefix('caught by ')}" if row["caught"] else "SURVIVED"
    return f"{row['name']}: {verdict} ({row['seconds']:.0f} s)"
