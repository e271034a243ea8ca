"""The record of a drawn fault that no test notices, and the usual reasons."""

from typing import NamedTuple


class Survivor(NamedTuple):
    """A fault that no test notices, and why."""

    file: str  # path from the root of the repository
    where: str  # the function or constant
    old: str  # the lines that are changed, with single blanks
    new: str  # what they are then
    reason: str  # a sentence that says why no input can show it


# Reasons that several faults share.
SMALLER_MARGIN = "A smaller margin holds as well; a pair is only proved apart again sooner."
TINY_ROOM = (
    "TINY is 1e-300, and the products of a pair near 1 that underflow are off by less than 1e-321 "
    "in all: even a much smaller number covers them."
)
EXACT_DECIDES = (
    "Floats are then less often certain, and exact arithmetic decides the pair: that costs time."
)
ANY_DIRECTION = (
    "Both directions prove the pair apart until the same time, and every proof is sound for any "
    "direction."
)
