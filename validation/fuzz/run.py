"""Run the families of inputs in batches, each in a process with limits, and count the answers.

An input is made from the seed, the name of its family and its number alone, so that each can be
made again: `trial_of(family, seed, number)`.
"""

import contextlib
import mmap
import tempfile
import time
import traceback
import zlib
from collections import Counter
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from validation.fuzz.arrays import Rng
from validation.fuzz.trial import (
    ACCEPTED,
    CRASH,
    HANG,
    LONGEST_S,
    PROBLEMS,
    REFUSED,
    Outcome,
    Trial,
    run_trial,
)
from validation.limits import Limits, NotDecidedError, limited
from validation.rows import Row

BATCH = 250  # inputs a process
WARM = 8  # inputs that load compiled code into the first process; those of batches inherit it
# Time after which a batch is taken to hang in code that no signal interrupts: for each input some
# 0.2 s on a busy machine, and an input that is interrupted twice.
BATCH_S = 50.0 + 2 * LONGEST_S

MakeTrial = Callable[[Rng, Path], Trial]


class Family(NamedTuple):
    """A kind of inputs.

    Attributes:
        make: Makes an input; it may write files into a folder of its own.
        share: Number of inputs of this kind in 1000.
        bytes: Memory that a batch may take.
        alone: Whether its inputs start processes of their own, which a limited process may not.
        batch: Inputs a process; few where an input takes long, so that a batch ends in BATCH_S.
    """

    make: MakeTrial
    share: int
    bytes: int = 1 << 30
    alone: bool = False
    batch: int = BATCH


class Tally(NamedTuple):
    """The answers to some inputs."""

    kinds: Counter[str]
    errors: Counter[str]
    problems: list[tuple[int, str, str]]  # number of the input, kind, detail
    slowest_s: float

    def add(self, number: int, outcome: Outcome) -> "Tally":
        """Return the tally with one answer more."""
        self.kinds[outcome.kind] += 1
        if outcome.kind == REFUSED:
            self.errors[outcome.error] += 1
        if outcome.kind in PROBLEMS:
            self.problems.append((number, outcome.kind, outcome.detail))
        return self._replace(slowest_s=max(self.slowest_s, outcome.seconds))

    def join(self, other: "Tally") -> "Tally":
        """Return both together."""
        return Tally(
            self.kinds + other.kinds,
            self.errors + other.errors,
            self.problems + other.problems,
            max(self.slowest_s, other.slowest_s),
        )


def no_answers() -> Tally:
    """Return the tally of no inputs."""
    return Tally(Counter(), Counter(), [], 0.0)


def trial_of(name: str, family: Family, seed: int, number: int, folder: Path) -> Trial:
    """Return one input.

    Args:
        name: Name of its family.
        family: The family.
        seed: The seed.
        number: Number of the input.
        folder: An empty folder for its files.
    """
    rng = np.random.default_rng([seed, zlib.crc32(name.encode()), number])
    return family.make(rng, folder)


def run_batch(
    name: str, family: Family, seed: int, numbers: Iterable[int], at: mmap.mmap | None = None
) -> Tally:
    """Run some inputs of a family in this process.

    Args:
        name: Name of the family.
        family: The family.
        seed: The seed.
        numbers: Numbers of the inputs.
        at: Memory that is shared with the process that waits; is told which input is under way.
    """
    tally = no_answers()
    with tempfile.TemporaryDirectory() as folder:
        for number in numbers:
            if at is not None:
                at[:8] = number.to_bytes(8, "little")
            place = Path(folder) / str(number)
            place.mkdir()
            try:
                trial = trial_of(name, family, seed, number, place)
            except Exception as error:  # a fault of the fuzzer itself
                text = traceback.format_exc(limit=-4)
                raise RuntimeError(f"{name} {number}, seed {seed}: {text}") from error
            tally = tally.add(number, run_trial(trial))
    return tally


def run_family(
    name: str,
    family: Family,
    seed: int,
    count: int,
    say: Callable[[str], object],
    warm: int = WARM,
) -> Row:
    """Run inputs of a family, and return the row about them.

    Args:
        name: Name of the family.
        family: The family.
        seed: The seed.
        count: Number of inputs.
        say: Is called with a line for each problem.
        warm: Number of inputs that are tried before, in this process.
    """
    begin, tally, first = time.perf_counter(), no_answers(), 0
    with contextlib.suppress(Exception):
        run_batch(name, family, seed + 1, range(warm))
    while first < count:
        numbers = range(first, min(first + family.batch, count))
        part, first = _limited_batch(name, family, seed, numbers)
        tally = tally.join(part)
    for number, kind, detail in tally.problems:
        say(f"{name} {number}: {kind}: {detail}")
    return _row(name, seed, count, tally, time.perf_counter() - begin)


def _limited_batch(name: str, family: Family, seed: int, numbers: range) -> tuple[Tally, int]:
    """Run a batch in a process of its own, and return where to go on."""
    if family.alone:
        return run_batch(name, family, seed, numbers), numbers.stop
    at = mmap.mmap(-1, 8)
    batch = partial(run_batch, name, family, seed)
    limits = Limits(BATCH_S, family.bytes)
    try:
        return limited(limits, batch, numbers, at), numbers.stop
    except NotDecidedError as error:
        number = int.from_bytes(at[:8], "little")
        kind = HANG if " s" in str(error) else CRASH
        done = limited(limits, batch, range(numbers.start, number), None)
        return done.add(number, Outcome(kind, "", str(error), BATCH_S)), number + 1


def _row(name: str, seed: int, count: int, tally: Tally, seconds: float) -> Row:
    errors = ", ".join(f"{error} {n}" for error, n in tally.errors.most_common())
    problems: dict[str, Any] = {kind: tally.kinds[kind] for kind in PROBLEMS}
    first = tally.problems[0] if tally.problems else None
    return {
        "family": name,
        "inputs": count,
        "seed": seed,
        "accepted": tally.kinds[ACCEPTED],
        "refused": tally.kinds[REFUSED],
        **{kind.replace(" ", "_"): number for kind, number in problems.items()},
        "refused_as": errors or None,
        "first_problem": None if first is None else f"{first[0]}: {first[1]}: {first[2]}"[:500],
        "slowest_s": tally.slowest_s,
        "seconds": seconds,
    }
