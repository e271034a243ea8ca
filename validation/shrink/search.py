"""The search for a smaller input: the best one so far, and delta debugging."""

import time
from collections.abc import Callable, Iterable, Sequence
from typing import Generic, TypeVar

Input = TypeVar("Input")
Item = TypeVar("Item")


class OutOfTimeError(Exception):
    """The time of the search is used up; the best input so far is the answer."""


class Search(Generic[Input]):
    """The best input so far, and the test that a better one has to pass.

    Args:
        first: The input that fails.
        fails: Returns whether an input fails in the same way as the first one.
        key: Returns bytes that are equal for equal inputs; none is tried twice.
        seconds: Time after which the search ends [s].
        say: Is called with a line of text as the search goes on.

    Attributes:
        best: The smallest input that fails, so far.
        tried: Number of inputs that were tried.
    """

    def __init__(
        self,
        first: Input,
        fails: Callable[[Input], bool],
        key: Callable[[Input], bytes],
        seconds: float,
        say: Callable[[str], object],
    ) -> None:
        """Keep the first input; nothing is tried yet."""
        self.best = first
        self.tried = 0
        self._fails, self._key, self._say = fails, key, say
        self._end = time.monotonic() + seconds
        self._seen = {key(first)}

    def take(self, candidate: Input | None) -> bool:
        """Take a candidate if it fails in the same way; it is then the best one.

        Args:
            candidate: A smaller or simpler input; None is none.

        Returns:
            Whether it was taken.

        Raises:
            OutOfTimeError: The time is used up.
        """
        if candidate is None:
            return False
        key = self._key(candidate)
        if key in self._seen:
            return False
        if time.monotonic() > self._end:
            raise OutOfTimeError
        self._seen.add(key)
        self.tried += 1
        if not self._fails(candidate):
            return False
        self.best = candidate
        return True

    def take_first(self, candidates: Iterable[Input]) -> bool:
        """Take the first of some candidates that fails in the same way."""
        return any(self.take(candidate) for candidate in candidates)

    def say(self, line: str) -> None:
        """Say how far the search is."""
        self._say(f"{line}; {self.tried} tried")

    def keep_few(
        self, items: Sequence[Item], keep: Callable[[Input, list[Item]], Input | None]
    ) -> list[Item]:
        """Keep as few of some items as the failure needs, by delta debugging (`ddmin`).

        Afterwards no single item can be left out. Which items are kept depends on their order.

        Args:
            items: The items that the best input has.
            keep: Returns an input with some of the items only, made from the input before; None if
                there is none.

        Returns:
            The items that are left.

        Source: A. Zeller, R. Hildebrandt, Simplifying and isolating failure-inducing input (2002).
        """
        kept, parts, origin = list(items), 2, self.best
        if kept and self.take(keep(origin, [])):
            return []
        while len(kept) >= 2:
            size = -(-len(kept) // parts)
            chunks = [kept[k : k + size] for k in range(0, len(kept), size)]
            rests = [[i for i in kept if i not in chunk] for chunk in chunks]
            smaller = next((c for c in chunks if self.take(keep(origin, c))), None)
            if smaller is not None:
                kept, parts = smaller, 2
                continue
            smaller = next(
                (r for r in rests if len(chunks) > 2 and self.take(keep(origin, r))), None
            )
            if smaller is not None:
                kept, parts = smaller, max(parts - 1, 2)
                continue
            if parts >= len(kept):
                break
            parts = min(2 * parts, len(kept))
        return kept
