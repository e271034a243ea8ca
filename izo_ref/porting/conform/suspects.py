"""Name the mistake that most likely makes a stage fail, from the flags of its cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

from izo_ref.porting.conform.run import Row
from izo_ref.porting.judge.outcome import FAILED, PASSED, WRONG

SHOWN = 3  # mistakes at most
FAR_BEHIND = 0.5  # of the first score; a mistake below that is unlikely


class Suspect(NamedTuple):
    """A mistake, and how many of the cases that catch it fail.

    Attributes:
        flag: Name of the mistake.
        failed: Cases with this flag that fail, counted once for each type of floats.
        judged: All cases with this flag that were judged.
        score: From 0 to 1; 1 if exactly the cases with this flag fail.
    """

    flag: str
    failed: int
    judged: int
    score: float


def is_wrong(row: Row) -> bool:
    """Return whether a number or a decision of a reply is wrong, and not its form alone."""
    return row.outcome.result == FAILED and any(
        difference.cause == WRONG for difference in row.outcome.differences
    )


def suspects(rows: Iterable[Row], stage: str) -> list[Suspect]:
    """Return the flags of the failing cases of a stage, the most likely mistake first.

    A gross mistake also breaks cases that are about something else, so the first case that fails
    need not name it. But the mistake fails most of the cases that were made for it, and most of the
    cases that fail were made for it. The order is by the harmonic mean of these two shares, which
    is 2 failed / (judged + all that fail). Crashes and replies of the wrong form say nothing about
    the method; such rows do not count.

    Args:
        rows: The rows of a run.
        stage: Name of the stage.
    """
    judged: Counter[str] = Counter()
    failed: Counter[str] = Counter()
    all_that_fail = 0
    for row in rows:
        if row.request.case.stage != stage:
            continue
        if is_wrong(row):
            failed.update(row.request.case.flags)
            all_that_fail += 1
        elif row.outcome.result != PASSED:
            continue
        judged.update(row.request.case.flags)
    found = [
        Suspect(flag, count, judged[flag], 2 * count / (judged[flag] + all_that_fail))
        for flag, count in failed.items()
    ]
    return sorted(found, key=lambda suspect: -suspect.score)


def shown_suspects(rows: Iterable[Row], stage: str) -> list[Suspect]:
    """Return the mistakes that are named: the first one, and others that are not far behind it.

    Args:
        rows: The rows of a run.
        stage: Name of the stage.
    """
    found = suspects(rows, stage)
    return [item for item in found if item.score >= FAR_BEHIND * found[0].score][:SHOWN]
