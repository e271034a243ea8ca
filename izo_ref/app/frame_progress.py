"""Progress of sequences on the standard error: bars on a terminal, lines elsewhere if asked for."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple, TextIO, TypeAlias

from izo_ref.base.compile import anything_compiled

COMPILING = "compiling, only the first time"


class Progress(NamedTuple):
    """How far a sequence is.

    Attributes:
        frame: Number of the frame that is done; None before the first one is.
        last: Number of the last frame.
        done: Number of frames that are done, with those that an earlier run kept.
        total: Number of all frames.
        impacts: Number of impacts in all frames that are done.
    """

    frame: int | None
    last: int
    done: int
    total: int
    impacts: int


Tell: TypeAlias = Callable[[Progress], None]


class Display:
    """What is shown of one or several sequences while they are resolved.

    Nothing is shown where the standard error is no terminal, unless lines are asked for.

    Args:
        lines: Write a line for each frame.
        named: Show the name of the sequence, because there are several.
    """

    def __init__(self, lines: bool, named: bool) -> None:
        """Show nothing yet."""
        self._lines, self._named = lines, named
        self._has_bars = not lines and sys.stderr.isatty()
        self._bars: dict[str, Any] = {}
        self._begun: dict[str, tuple[float, int]] = {}  # when, and how many frames were done then

    def tell(self, name: str, progress: Progress) -> None:
        """Show how far a sequence is.

        Args:
            name: Name of the sequence.
            progress: How far it is.
        """
        if self._has_bars:
            self._move_bar(name, progress)
        elif self._lines:
            self._write_line(name, progress)

    def end(self, name: str) -> None:
        """Take the bar of a sequence away, if it has one.

        Args:
            name: Name of the sequence.
        """
        if name in self._bars:
            self._bars.pop(name).close()

    def say(self, line: str, file: TextIO) -> None:
        """Print a line, above the bars if there are some.

        Args:
            line: The line.
            file: The standard output or error.
        """
        if self._has_bars:
            from tqdm import tqdm

            tqdm.write(line, file=file)
        else:
            print(line, file=file, flush=True)

    def __enter__(self) -> Display:
        """Begin; the bars are taken away when the block ends."""
        return self

    def __exit__(self, *error: object) -> None:
        """Take all bars away."""
        for name in list(self._bars):
            self.end(name)

    def _move_bar(self, name: str, progress: Progress) -> None:
        if name not in self._bars:
            from tqdm import tqdm

            used = {bar.pos for bar in self._bars.values()}
            self._bars[name] = tqdm(
                total=progress.total,
                initial=progress.done,
                desc=name if self._named else None,
                unit=" frames",
                leave=False,
                position=next(row for row in range(len(used) + 1) if -row not in used),
                dynamic_ncols=True,
                mininterval=0.0,
            )
        bar = self._bars[name]
        if progress.frame is None:
            bar.set_postfix_str("" if anything_compiled() else COMPILING)
            return
        bar.set_postfix_str(f"{progress.impacts:,} impacts", refresh=False)
        bar.update(progress.done - bar.n)

    def _write_line(self, name: str, progress: Progress) -> None:
        now = time.perf_counter()
        begin, done = self._begun.setdefault(name, (now, progress.done))
        if progress.frame is None:
            return
        line = f"frame {progress.frame} of {progress.last}, {progress.impacts:,} impacts"
        own = progress.done - done
        left = progress.total - progress.done
        if own and left:
            line += f", {duration((now - begin) / own * left)} left"
        print(f"{name}: {line}" if self._named else line, file=sys.stderr, flush=True)


def duration(seconds: float) -> str:
    """Return a time in the two largest units that it has.

    Args:
        seconds: The time [s].
    """
    whole = round(seconds)
    hours, minutes = whole // 3600, whole // 60 % 60
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {whole % 60} s" if minutes else f"{whole} s"
