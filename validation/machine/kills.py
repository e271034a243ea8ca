"""Kill commands at random moments, and judge what they leave.

Half of the moments are by the clock, anywhere in the run; the others are at a call that changes
files, because a write is too short to be hit by the clock. After each, no output may be half
written: it is as it was before, or as a run that was not killed leaves it, or not there if it was
not there before. The step is not changed, nothing but unfinished files is left, and the next write
deletes these. A study goes on to the same rows.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import signal
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np

from izo_ref.base.whole_files import UNFINISHED, delete_leftovers
from validation.machine import victim
from validation.machine.small_study import KEYS, PARTS, ZONES
from validation.machine.targets import NOT_WHOLE, Target
from validation.provenance import ROOT
from validation.rows import Row, read

# its trace has 75 files, and that of at-rest 291, each of which goes to the disk by itself
STEP = ROOT / "data" / "scenes" / "pinch-tight.npz"
SIGNALS = (signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
ABSENT, HALF = "absent", "HALF WRITTEN"
LEFT_OUT = shutil.ignore_patterns(
    ".git", ".cache", ".venv", ".pytest_cache", ".ruff_cache", "__pycache__", "_build", "rows"
)


class Undisturbed(NamedTuple):
    """A run that was not killed.

    Attributes:
        seconds: How long it took.
        calls: How many calls of it changed files.
        outputs: What the readers say of each output.
    """

    seconds: float
    calls: int
    outputs: dict[str, object]


class Bench:
    """A folder in which commands are killed.

    Args:
        folder: An empty folder.
        targets: The commands.
    """

    def __init__(self, folder: Path, targets: Sequence[Target]) -> None:
        """Make a copy of the step, and of the checkout for commands that write into it."""
        self._targets = targets
        self._folder, self._copy = folder, folder / "checkout"
        self._step = Path(shutil.copy(STEP, folder / "step.npz"))
        self._before = _digest(self._step)
        shutil.copytree(ROOT, self._copy, ignore=LEFT_OUT)
        shutil.copytree(ROOT / "reports", self._copy / "reports", dirs_exist_ok=True)
        self._usual: dict[str, Undisturbed] = {}

    def prepare(self) -> None:
        """Run each command once in this process, which loads code, and once in a child."""
        numba.set_num_threads(1)  # a fork has no threads of its parent
        for target in self._targets:
            work = self._work(target)
            with open(os.devnull, "w") as null, redirect_stdout(null):
                code = victim.run(target.module, self._words(target, work), self._in_copy(target))
            if code not in target.exits:
                raise RuntimeError(f"{target.name}: ended with {code}")
            work = self._work(target)
            begin = time.perf_counter()
            code, text = victim.ended(*self._start(target, work))
            seconds = time.perf_counter() - begin
            if code not in target.exits:
                raise RuntimeError(f"{target.name}: ended with {code}: {text}")
            outputs = _read(target, work)
            if not target.in_copy:
                shutil.copytree(work, self._kept(target))
            self._usual[target.name] = Undisturbed(seconds, int(text.split()[0]), outputs)

    def kill(self, target: Target, by_clock: bool, rng: np.random.Generator) -> Row:
        """Kill a target at a random moment; return what it left."""
        usual = self._usual[target.name]
        has_old = bool(rng.integers(2)) and target.name != "izo resolve"  # its trace is a new one
        work = self._work(target, has_old)
        old = _read(target, work)
        number = SIGNALS[rng.integers(len(SIGNALS))]
        call = 0 if by_clock else int(rng.integers(1, usual.calls + 1))
        moment = float(rng.uniform(0.0, 1.05 * usual.seconds)) if by_clock else float(call)
        child, reader = self._start(target, work, call, number)
        if by_clock:
            time.sleep(moment)
            os.kill(child, number)  # if it has ended, it still waits to be asked for
        code, _ = victim.ended(child, reader)
        states = _states(target, work, old, usual.outputs)
        left, others = _left(target, work)
        row = {
            "command": target.name,
            "signal": number.name,
            "by": "clock" if by_clock else "call",
            "moment": moment,
            "ended": "killed" if code < 0 else f"exit {code}",
            "had_old": has_old or target.in_copy,
            "outputs": ", ".join(f"{name}: {state}" for name, state in states.items()),
            "half": sum(state.startswith(HALF) for state in states.values()),
            "left": left,
            "others": others,
            "left_after_next": _left_after_next(target, work),
            "step_same": _digest(self._step) == self._before,
            "resumes": self._resumes(target, work),
        }
        right = not (row["half"] or row["others"] or row["left_after_next"])
        return row | {"right": right and row["step_same"] and row["resumes"]}

    def _resumes(self, target: Target, work: Path) -> bool:
        """Return whether the command ends well after it was killed, and a study has all rows."""
        if target.name != "study":
            return True
        code, _ = victim.ended(*self._start(target, work))
        rows = read(work / "study", "small")
        same = _read(target, work) == self._usual[target.name].outputs
        return code == 0 and same and len({_key(row) for row in rows}) == len(rows) == ZONES * PARTS

    def _work(self, target: Target, has_old: bool = False) -> Path:
        """Return the folder of the outputs: the copy of the checkout, or one with old outputs."""
        if target.in_copy:
            for name in target.outputs:  # what the command writes differs from it
                text = (ROOT / name).read_text()
                (self._copy / name).write_text(text.replace(target.stale, f"{target.stale}stale "))
            return self._copy
        shutil.rmtree(self._folder / "work", ignore_errors=True)
        if has_old:
            shutil.copytree(self._kept(target), self._folder / "work")
        else:
            (self._folder / "work").mkdir()
        return self._folder / "work"

    def _kept(self, target: Target) -> Path:
        return self._folder / f"kept-{target.name.replace(' ', '-')}"

    def _words(self, target: Target, work: Path) -> list[str]:
        return [word.format(step=self._step, work=work) for word in target.words]

    def _start(
        self, target: Target, work: Path, call: int = 0, number: int = signal.SIGKILL
    ) -> tuple[int, int]:
        places = self._in_copy(target)
        return victim.start(target.module, self._words(target, work), places, call, number)

    def _in_copy(self, target: Target) -> dict[tuple[str, str], Path]:
        """Return the places of the checkout that a target writes to, in the copy."""
        return {place: self._copy / name for place, name in target.places.items()}


def _key(row: Row) -> tuple[Any, ...]:
    return tuple(row[name] for name in KEYS)


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _read(target: Target, work: Path) -> dict[str, object]:
    """Return what the readers say of each output: its content, that it is absent, or not whole."""
    found: dict[str, object] = {}
    for name, reader in target.outputs.items():
        try:
            found[name] = reader(work / name) if (work / name).exists() else ABSENT
        except NOT_WHOLE as error:
            found[name] = f"{HALF}: {error}"
    return found


def _states(
    target: Target, work: Path, old: dict[str, object], new: dict[str, object]
) -> dict[str, str]:
    """Return whether each output is absent, old, new, or half written."""
    states = {}
    for name, content in _read(target, work).items():
        if isinstance(content, str) and content.startswith(HALF):
            states[name] = content
        elif isinstance(content, str) and content == ABSENT:
            states[name] = ABSENT if old[name] == ABSENT else f"{HALF}: the old one is lost"
        elif content == new[name]:
            states[name] = "new"
        elif content == old[name]:
            states[name] = "old"
        elif name == "t" and content is None:
            states[name] = "without index"
        else:
            states[name] = f"{HALF}: neither old nor new"
    return states


def _places(target: Target, work: Path) -> set[Path]:
    """Return every folder that outputs of a target are in."""
    above = {(work / name).parent for name in target.outputs}
    below = set() if target.in_copy else {work, *work.rglob("*")}
    return {path for path in above | below if path.is_dir() and not path.name.endswith(UNFINISHED)}


def _left(target: Target, work: Path) -> tuple[int, int]:
    """Return the number of unfinished files, and of other files that are no outputs."""
    known = {work / name for name in target.outputs}
    unfinished = others = 0
    for folder in _places(target, work):
        for path in folder.iterdir():
            if path.name.endswith(UNFINISHED):
                unfinished += 1
            elif path.is_file() and not target.in_copy and not known & {path, *path.parents}:
                others += 1
    return unfinished, others


def _left_after_next(target: Target, work: Path) -> int:
    """Return how many unfinished files are left by the next write of each output."""
    for name in target.outputs:
        delete_leftovers(work / name)
    # the files of a trace are outputs too; a new trace needs a new folder
    return sum(
        path.name.endswith(UNFINISHED) and path.parent.name != "t" and "/t/" not in str(path)
        for folder in _places(target, work)
        for path in folder.iterdir()
    )


def killed(
    folder: Path, targets: Sequence[Target], numbers: Iterable[int], seed: int
) -> Iterator[tuple[int, Row]]:
    """Kill commands at random moments, one after the other.

    This process runs each of the commands once, and is of no other use afterwards: they write
    into a copy of the checkout because variables of their modules are changed.

    Args:
        folder: An empty folder for the commands.
        targets: The commands, which take turns.
        numbers: Numbers of the moments.
        seed: Seed of the moments.

    Yields:
        The number of a moment, and the row of what the command left.
    """
    bench = Bench(folder, targets)
    bench.prepare()
    for number in numbers:
        target = targets[number % len(targets)]
        by_clock = number // len(targets) % 2 == 0
        yield number, bench.kill(target, by_clock, np.random.default_rng([seed, number]))


def summary(rows: Sequence[Row]) -> str:
    """Return the counts of some rows in words."""
    killed = sum(row["ended"] == "killed" for row in rows)
    return (
        f"{len(rows)} moments, {killed} runs killed: {sum(row['half'] for row in rows)} outputs "
        f"half written, {sum(row['left'] for row in rows)} unfinished files left, "
        f"{sum(row['left_after_next'] for row in rows)} after the next write, "
        f"{sum(not row['step_same'] for row in rows)} inputs changed, "
        f"{sum(not row['right'] for row in rows)} wrong"
    )


def line(number: int, row: Row) -> str:
    """Return a row in words."""
    verdict = "right" if row["right"] else "WRONG"
    return (
        f"{number} {row['command']}: {row['signal']} by {row['by']} at {row['moment']:.3g}, "
        f"{row['ended']}; {row['outputs']}; {row['left']} left: {verdict}"
    )
