"""Seconds that the stages of a step take."""

import time


class Stopwatch:
    """Seconds that each stage takes."""

    def __init__(self) -> None:
        """Start now."""
        self._start = self._last = time.perf_counter()
        self._laps: dict[str, float] = {}

    def lap(self, stage: str) -> None:
        """End a stage; the next one begins now."""
        now = time.perf_counter()
        self._laps[stage] = now - self._last
        self._last = now

    def timings(self) -> dict[str, float]:
        """Return the seconds of each stage, and of all as `total`."""
        return {**self._laps, "total": self._last - self._start}
