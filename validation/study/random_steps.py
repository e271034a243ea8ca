"""Study of small random steps full of trouble: no claim of a result may be wrong.

Each row is about a batch of steps of one family and one kind (`stability_steps/`). A batch runs in
a process of its own, within limits of time and memory. A step that ends this process, or that takes
too long, is a row and not the end of the run.
"""

import math
import signal
import time
from collections import Counter
from pathlib import Path

import numpy as np

from validation.limits import CAN_LIMIT, Limits, NotDecidedError, limited
from validation.rows import Rows, begin_run
from validation.stability_steps.draw import draw
from validation.stability_steps.families import FAMILIES
from validation.stability_steps.kinds import KINDS
from validation.stability_steps.run import Outcome, run_case
from validation.study.parts import Part, Say

SEED = 20261129
# Cases of a batch, and batches of each family and kind, whose seeds follow one another. With 18
# families and 14 kinds, these are 22,680 cases.
BATCH, ROUNDS = 10, 9
KEYS = ("family", "kind", "seed")
STEP_S = 20.0  # a case that computes for longer than this, with its judges, is counted as slow
BATCH_S = 60.0
GIB = 4 << 30
WAITING = 20.0  # a process may wait for others this many times as long as it may compute


def random_steps(folder: Path, say: Say, rounds: int = ROUNDS, seed: int = SEED) -> None:
    """Resolve and judge batches of all families and kinds.

    Args:
        folder: Folder of the rows.
        say: Is called with a line of text for each batch.
        rounds: Batches of each family and kind; each round has all of them.
        seed: Seed of the first round.
    """
    rows = Rows(folder, "random-steps", KEYS)
    missing = [
        (family, kind, own)
        for own in range(seed, seed + rounds)
        for kind in KINDS
        for family in FAMILIES
        if not rows.has(family=family, kind=kind, seed=own)
    ]
    if missing:
        _load_compiled_code()
    for family, kind, own in missing:
        row = batch_row(family, kind, own, range(BATCH))
        rows.add(family=family, kind=kind, seed=own, **row)
        counts = ", ".join(f"{name} {row[name]}" for name in (*STATUSES, "refused") if row[name])
        say(f"random-steps: {family}, {kind}, {own}: {counts}; {row['violations']} violations")
        if row["violations"]:
            say(f"    {row['first_violations']}")


def batch_row(family: str, kind: str, seed: int, numbers: range) -> dict[str, int | float | str]:
    """Resolve and judge a batch, within limits.

    Args:
        family: One of `FAMILIES`.
        kind: One of `KINDS`.
        seed: Seed of the batch.
        numbers: Numbers of its cases.

    Returns:
        The counts, and the first violations in words.
    """
    begin = time.perf_counter()
    try:
        limits = Limits(WAITING * BATCH_S, GIB)
        outcomes = limited(limits, _outcomes, BATCH_S, family, kind, seed, numbers)
    except NotDecidedError:
        outcomes = [_alone(family, kind, seed, number) for number in numbers]
    statuses = Counter(status for outcome in outcomes for status in outcome.statuses)
    violations = [
        f"{number}: {line}"
        for number, outcome in zip(numbers, outcomes, strict=True)
        for line in outcome.violations
    ]
    return {
        "cases": len(outcomes),
        "steps": sum(len(outcome.statuses) for outcome in outcomes),
        **{name: statuses.pop(name, 0) for name in STATUSES},
        "refused": sum(statuses.values()),
        "refusals": ", ".join(f"{name} {n}" for name, n in sorted(statuses.items())),
        **{name: sum(getattr(outcome, name) for outcome in outcomes) for name in COUNTS},
        "violations": len(violations),
        "first_violations": "; ".join(violations[:3]),
        "seconds": time.perf_counter() - begin,
    }


STATUSES = ("FREE", "FREE_BY_FALLBACK", "FREE_EXCEPT_EXCLUDED", "BLOCKED", "slow", "crashed")
COUNTS = ("by_oracle", "by_fcl", "exact_zones", "again")


def _outcomes(seconds: float, family: str, kind: str, seed: int, numbers: range) -> list[Outcome]:
    """Run cases in this process, which ends when it has computed for this long [s]."""
    if CAN_LIMIT:
        import resource

        used, hard = math.ceil(time.process_time() + seconds), resource.RLIM_INFINITY
        resource.setrlimit(resource.RLIMIT_CPU, (used, hard))
    outcomes = []
    for number in numbers:
        case = draw(family, kind, seed, number)
        outcomes.append(run_case(case, np.random.default_rng([seed, number])))
    return outcomes


def _alone(family: str, kind: str, seed: int, number: int) -> Outcome:
    """Run a case of a batch that did not end, in a process of its own."""
    numbers = range(number, number + 1)
    limits = Limits(WAITING * STEP_S, GIB)
    try:
        return limited(limits, _outcomes, STEP_S, family, kind, seed, numbers)[0]
    except NotDecidedError as error:
        if "more than" in str(error) or f"with -{signal.SIGXCPU:d}" in str(error):
            return Outcome(statuses=["slow"])
        return Outcome(statuses=["crashed"], violations=[f"crash: {error}"])


def _load_compiled_code() -> None:
    """Run a few cases here, so that the processes of the batches have the compiled code."""
    for kind in KINDS:
        for number in range(4):
            run_case(draw("layers", kind, 0, number))


PARTS: dict[str, Part] = {"random-steps": random_steps}


if __name__ == "__main__":
    ROWS = Path("reports") / "random-steps" / "rows"
    begin_run(ROWS, "python -m validation.study.random_steps", False)
    random_steps(ROWS, lambda line: print(line, flush=True))
