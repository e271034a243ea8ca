"""Run the tests on copies of the repository that have one drawn fault each.

For each fault, the tests that enter its function run first, in pure Python, the fastest first,
until one fails. All drawn faults go through this stage, because it takes seconds. Those that
survive go through two more: the tests that are too slow in pure Python run compiled, among them
whole steps, and then the vectors of the porting kit.

Rows are written after each fault, so a run can be resumed: a fault that was caught is not tried
again, nor one that survived the same tests.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from validation import json_rows
from validation.mutants.chosen import CHOSEN
from validation.mutants.draw import Drawn, draw
from validation.mutants.reached import FOLDERS, PURE, Test, tests_of, users_of, watch_tests
from validation.mutants.run import INTERRUPTED, PASSED, ROOT, Bench
from validation.mutants.survivors import reason_of
from validation.mutants.vectors import LIMIT_S, vectors_find
from validation.provenance import Made
from validation.rows import Row

WORKERS = 2  # faults that are tried at the same time
# Seconds of tests in pure Python for one fault, as measured without any fault.
PURE_S = 30.0
NO_TESTS = 5  # exit code of pytest
COMPILED_LIMIT_S = 1200.0
STAGES = TESTS, COMPILED, VECTORS = "tests in pure Python", "compiled tests", "vectors"


def run_random(
    n: int,
    seed: int,
    path: Path,
    made: Made,
    *,
    root: Path = ROOT,
    deep: bool = True,
) -> list[Row]:
    """Draw faults and run the tests on each.

    Args:
        n: How many faults are drawn.
        seed: The seed of the draw.
        path: JSON file of the rows; rows that are there are kept.
        made: What makes the rows.
        root: Root of the repository.
        deep: Whether faults that survive in pure Python go through the two slower stages.

    Returns:
        A row for each fault that was tried, in the order of the draw: number, seed, group, file,
        line, where, operator, old, new, caught, by, stage, tests (a digest of the tests),
        reason, seconds.
    """
    with tempfile.TemporaryDirectory(prefix="random-mutants-") as folder:
        run = _Run(Path(folder), root, draw(root, n, seed), path, made, seed)
        run.stage(TESTS, run.in_pure_python)
        if deep:
            run.stage(COMPILED, run.compiled)
            run.stage(VECTORS, run.by_vectors)
        json_rows.save(path, made, run.rows())
        return run.rows()


class Copy(Bench):
    """A copy of the repository in which one file is changed at a time."""

    def __init__(self, folder: Path, root: Path) -> None:
        """Take a snapshot, and a copy whose modules are compiled by their content."""
        folder.mkdir(parents=True)
        super().__init__(folder, root)
        self.restore()
        command = [sys.executable, "-m", "compileall", "-q", "--invalidation-mode", "checked-hash"]
        subprocess.run(
            [*command, "izo_ref", "tests", "validation"], cwd=self.tree, check=True, timeout=600
        )
        self.cache = folder / "cache"
        self._changed: str = ""

    def put(self, fault: Drawn) -> None:
        """Put a fault into the copy; the one before is taken out."""
        self.take_out()
        (self.tree / fault.file).write_text(fault.text)
        self._changed = fault.file

    def take_out(self) -> None:
        """Take the fault out of the copy, and what was compiled with it."""
        if self._changed:
            shutil.copy2(self.snapshot / self._changed, self.tree / self._changed)
        shutil.rmtree(self.cache, ignore_errors=True)

    def run(self, tests: Sequence[Test], limit_s: float, pure: bool) -> tuple[bool, str]:
        """Run tests in their order until one fails.

        Returns:
            Whether a test failed, or the run did not end; and which test, or how it ended.
        """
        names = [test.name for test in tests]
        chosen = self.tree.with_name("chosen.json")
        chosen.write_text(json.dumps(names))
        files = list(dict.fromkeys(name.partition("::")[0] for name in names))
        changes = {CHOSEN: str(chosen)} | (PURE if pure else {})
        arguments = ["-p", "validation.mutants.chosen", *(["-W", "ignore"] if pure else []), *files]
        code, by, output = self.test(arguments, limit_s, changes)
        if code is not None and code > INTERRUPTED and code != NO_TESTS:
            # an error inside pytest, such as one that an import of the package raises in a hook
            by = by or f"exit code {code}: {output[-200:]}"
        return code not in (PASSED, NO_TESTS), by


class _Run:
    """One run: the drawn faults, their rows, and a copy for each worker."""

    def __init__(
        self, folder: Path, root: Path, drawn: list[Drawn], path: Path, made: Made, seed: int
    ) -> None:
        self.drawn, self._path, self._made, self._seed = drawn, path, made, seed
        self._copies = [Copy(folder / str(i), root) for i in range(WORKERS)]
        self._lock = threading.Lock()
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        self._tests = watch_tests(self._copies[0].snapshot, cache / "izo_ref-mutants")
        self._digest = _digest_of_tests(root)
        self._root = root
        self._check_without_fault()
        loaded = json_rows.load(path)
        known = [] if loaded is None else loaded.rows
        self._row_of: dict[tuple[str, ...], Row] = {_key(row): row for row in known}

    def _check_without_fault(self) -> None:
        """Run quick tests of each folder without any fault, since a failure would mean nothing.

        Raises:
            RuntimeError: One fails.
        """
        quick = sorted((test for test in self._tests if test.passed), key=lambda test: test.seconds)
        caught, by = self._copies[0].run(quick[: len(quick) // 2], COMPILED_LIMIT_S, True)
        if caught:
            raise RuntimeError(f"mutants: without any fault: {by}")

    def rows(self) -> list[Row]:
        """Return the rows so far, in the order of the draw."""
        return [
            self._row_of[fault.key] | {"number": i, "seed": self._seed, "line": fault.line}
            for i, fault in enumerate(self.drawn, 1)
            if fault.key in self._row_of
        ]

    def stage(self, name: str, try_: Callable[[Copy, Drawn], tuple[bool, str]]) -> None:
        """Send all faults through a stage that they have not gone through."""
        free = list(self._copies)
        with ThreadPoolExecutor(WORKERS) as pool:

            def work(fault: Drawn) -> None:
                copy = free.pop()
                try:
                    self._try(copy, fault, name, try_)
                finally:
                    free.append(copy)

            todo = [fault for fault in self.drawn if self._wants(fault, name)]
            for done in [pool.submit(work, fault) for fault in todo]:
                done.result()

    def _wants(self, fault: Drawn, name: str) -> bool:
        """Return whether a fault has to go through a stage.

        It goes through the first one if it has no row, or if it survived other tests than those
        of today; and through a slower one if it survived the one before, and nobody knows why.
        """
        row = self._row_of.get(fault.key)
        if row is None:
            return name == TESTS
        if row["caught"] or reason_of(fault.key):
            return False
        if row["tests"] != self._digest:
            return name == TESTS
        return STAGES.index(row["stage"]) < STAGES.index(name)

    def _try(
        self,
        copy: Copy,
        fault: Drawn,
        name: str,
        try_: Callable[[Copy, Drawn], tuple[bool, str]],
    ) -> None:
        """Run one stage for one fault, and write its row."""
        begin = time.perf_counter()
        copy.put(fault)
        caught, by = try_(copy, fault)
        copy.take_out()
        with self._lock:
            before = self._row_of.get(fault.key, {}) if name != TESTS else {}
            seconds = before.get("seconds", 0.0) + time.perf_counter() - begin
            own = ("group", "file", "where", "operator", "old", "new")
            self._row_of[fault.key] = {
                **{field: getattr(fault, field) for field in own},
                "caught": caught,
                "by": by,
                "stage": name,
                "tests": self._digest,
                "reason": "" if caught else reason_of(fault.key),
                "seconds": round(seconds, 1),
            }
            json_rows.save(self._path, self._made, self.rows())
        verdict = f"caught by {by}" if caught else f"survived the {name}"
        print(f"{fault.file}:{fault.line} {fault.operator}: {verdict}", flush=True)

    def in_pure_python(self, copy: Copy, fault: Drawn) -> tuple[bool, str]:
        """Run the tests that enter the function of a fault in pure Python."""
        quick, _ = self._choose(fault)
        limit_s = PURE_S + 5.0 * sum(test.seconds for test in quick)
        return copy.run(quick, limit_s, True) if quick else (False, "")

    def compiled(self, copy: Copy, fault: Drawn) -> tuple[bool, str]:
        """Run the other tests that enter the function, compiled."""
        _, others = self._choose(fault)
        return copy.run(others, COMPILED_LIMIT_S, False) if others else (False, "")

    def by_vectors(self, copy: Copy, fault: Drawn) -> tuple[bool, str]:
        """Run the vectors on our own port."""
        found = vectors_find(copy, LIMIT_S, str(copy.cache))
        by = ", ".join(found.cases[:3]) or "; ".join(found.notes[:1])
        return bool(found.cases or found.notes), by and f"vectors: {by}"

    def _choose(self, fault: Drawn) -> tuple[list[Test], list[Test]]:
        """Return the tests of a fault in pure Python, and those that have to run compiled.

        Where no test is known to enter the function, all tests of the mirrored folder run compiled.
        """
        users = users_of(self._root, fault.names) if fault.names else set[str]()
        tests = tests_of(fault, self._tests, users)
        quick: list[Test] = []
        total = 0.0
        for test in tests:
            if test.passed and total + test.seconds <= PURE_S:
                quick.append(test)
                total += test.seconds
        if not tests:
            folder = f"tests/{fault.file.split('/')[1]}/"
            tests = [test for test in self._tests if test.name.startswith(folder)]
        return quick, [test for test in tests if test not in quick]


def _digest_of_tests(root: Path) -> str:
    """Return a digest of the tests of the stages."""
    digest = hashlib.sha256()
    for name in FOLDERS:
        for path in sorted((root / "tests" / name).glob("test_*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _key(row: Row) -> tuple[str, str, str, str]:
    """Return what identifies the fault of a row."""
    return row["file"], row["where"], row["old"], row["new"]
