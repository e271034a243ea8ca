"""The time limit of a run: when each of its stages has to end.

The host asks between iterations, rounds and slices of work (`check`, `slices`, `checked`). Compiled
loops that may run for long read a flag instead, which a timer sets while they run (`stop`). Code
that has no limit gets `UNLIMITED`, which never asks the clock.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

import numpy as np

from izo_ref.base.arrays import Flags

Item = TypeVar("Item")

# Items of the first slice of a kernel's work, and how long a slice should take: its size is doubled
# until it takes more than half of this, and halved if it takes more. A detection of stack-6k is
# 0.3 s of work in some 20 slices; each costs two readings of the clock and a launch, 30 us.
FIRST_SLICE, SLICE_S = 64, 0.02


class OutOfTimeError(Exception):
    """A stage has used up its time. `resolve` catches it; callers of the package never see it."""


class Deadline:
    """When the present stage of a run ends.

    Args:
        limit_s: Time that the run may take [s]; None if there is no limit.
        clock: Returns seconds since any fixed moment. Tests pass one of their own, and no timer
            runs beside it.

    Attributes:
        limit_s: As passed; infinite if there is no limit.
        stop: (1,) b1, becomes True when the present stage has to end.
    """

    def __init__(
        self, limit_s: float | None = None, clock: Callable[[], float] = time.perf_counter
    ) -> None:
        """Begin now, outside of any stage."""
        self.limit_s = math.inf if limit_s is None else limit_s
        self.stop: Flags = np.zeros(1, np.bool_)
        self._clock = clock
        self._begin = 0.0 if limit_s is None else clock()
        self._end_s = math.inf
        self._timer: threading.Timer | None = None

    @property
    def is_limited(self) -> bool:
        """Whether there is a limit at all."""
        return self.limit_s < math.inf

    def elapsed_s(self) -> float:
        """Return the time since the run began [s]; 0 if there is no limit."""
        return self._clock() - self._begin if self.is_limited else 0.0

    def begin_stage(self, end_s: float) -> None:
        """Begin the next stage.

        Args:
            end_s: When it has to end, since the begin of the run [s]; infinite if it may take as
                long as it needs.
        """
        if self._timer is not None:
            self._timer.cancel()
        # a timer that fires late sets the flag of its own stage, which nobody reads any more
        self.stop, self._end_s, self._timer = np.zeros(1, np.bool_), end_s, None
        if self.is_limited and self._clock is time.perf_counter and end_s < threading.TIMEOUT_MAX:
            wait_s = max(end_s - self.elapsed_s(), 0.0)
            self._timer = threading.Timer(wait_s, _set, (self.stop,))
            self._timer.daemon = True
            self._timer.start()

    def check(self) -> None:
        """Raise an error if the present stage has used up its time.

        Raises:
            OutOfTimeError: It has.
        """
        if self._end_s == math.inf:
            return
        if self.stop[0] or self.elapsed_s() >= self._end_s:
            raise OutOfTimeError

    def checked(self, items: Iterable[Item]) -> Iterator[Item]:
        """Return the items one by one, with a check before each of them.

        Args:
            items: Items that take a millisecond or more each.
        """
        for item in items:
            self.check()
            yield item

    def slices(self, items: range) -> Iterator[range]:
        """Return the items in slices that take SLICE_S each, with a check after each of them.

        Without a limit there is one slice. A kernel writes the outputs of each item on its own, so
        slices change no bit.

        Args:
            items: The items of a kernel.
        """
        if self._end_s == math.inf:
            yield items
            return
        size = FIRST_SLICE
        while True:
            begin = self.elapsed_s()
            yield items[:size]
            self.check()
            items = items[size:]
            if not items:
                return
            spent = self.elapsed_s() - begin
            if spent > SLICE_S:
                size = max(size // 2, 1)
            elif spent < 0.5 * SLICE_S:
                size = 2 * size


def _set(flag: Flags) -> None:
    flag[0] = True


UNLIMITED = Deadline()
