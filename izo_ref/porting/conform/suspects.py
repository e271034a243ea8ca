"""Name the mistake that most likely makes a stage fail, from the flags of its cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

from izo_ref.porting.conform.run import Row
from izo_ref.porting.judge.outcome import FAILED, PASSED


class Suspect(NamedTuple):
    """A mistake, and how many of the cases that catch it fail.

    Attributes:
        flag: Name of the mistake.
        failed: Cases with this flag that fail, counted once for each type of floats.
        judged: All cases with this flag that were judged.
    """

    flag: str
    failed: int
    judged: int


def suspects(rows: Iterable[Row], stage: str) -> list[Suspect]:
    """Return the flags of the failing cases of a stage, the most likely mistake first.

    A gross mistake also breaks cases that are about something else, so the first case that fails
    need not name it. But the mistake fails most of the cases that were made for it, and most of the
    cases that fail were made for it. The order is by the harmonic mean of these two shares, which
    is 2 failed / (judged + all that fail).

    Args:
        rows: The rows of a run.
        stage: Name of the stage.
    """
    judged: Counter[str] = Counter()
    failed: Counter[str] = Counter()
    all_that_fail = 0
    for row in rows:
        if row.request.case.stage == stage and row.outcome.result in (FAILED, PASSED):
            judged.update(row.request.case.flags)
            if row.outcome.result == FAILED:
                failed.update(row.request.case.flags)
                all_that_fail += 1
    found = [Suspect(flag, count, judged[flag]) for flag, count in failed.items()]
    return sorted(found, key=lambda suspect: -suspect.failed / (suspect.judged + all_that_fail))
