"""Why no input can show a fault that survived `python -m validation mutants --random`.

A reason holds for one change of one line, and a test checks that the line is still there.
"""

from typing import NamedTuple


class Survivor(NamedTuple):
    """A fault that no test notices, and why."""

    file: str  # path from the root of the repository
    where: str  # the function or constant
    old: str  # the lines that are changed, with single blanks
    new: str  # what they are then
    reason: str  # a sentence that says why no input can show it


SURVIVORS: list[Survivor] = []


def reason_of(key: tuple[str, str, str, str]) -> str:
    """Return why no input can show a fault; an empty text if no reason is known.

    Args:
        key: Its file, its function, and the lines before and after.
    """
    return {tuple(one[:4]): one.reason for one in SURVIVORS}.get(key, "")
