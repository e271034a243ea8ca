"""Several animations on one command line: each is resolved in a process of its own.

One that is refused, is blocked or crashes does not stop the others, and the memory of each is given
back when it ends.
"""

from __future__ import annotations

import argparse
import multiprocessing
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from copy import copy
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, NamedTuple, cast

import numba

from izo_ref.app.files import check_outputs, make_folder, save_json
from izo_ref.app.flags import with_flags
from izo_ref.app.frame_progress import Display, Progress
from izo_ref.app.process import failure
from izo_ref.app.sequence_command import ending, resolve_file
from izo_ref.base.errors import FileFormatError, IzoError

BAD_INPUT = 2
# Exit codes from the best to the worst: free, free except for pairs that are left out, not free,
# bad input.
ORDER = (0, 3, 1, BAD_INPUT)
PATIENCE_S = 5.0  # for a process that was asked to end


class Ended(NamedTuple):
    """How the sequence of one animation ended.

    Attributes:
        code: Its exit code.
        lines: What is said of it.
        error: Why it was refused; None if it was not.
        frames: The report of each frame, as JSON.
    """

    code: int
    lines: list[str]
    error: str | None
    frames: list[dict[str, Any]]


def sequences(args: argparse.Namespace) -> int:
    """Resolve several animations, at most `jobs` at a time, and write them into a folder.

    Args:
        args: What the parser found; `animation` has at least two paths.

    Returns:
        The worst exit code of all.

    Raises:
        FileFormatError: Two animations have the same name, or the folder or the report cannot be
            written.
    """
    tasks = _tasks(args)
    check_outputs({f"the animation {path}": path for path in tasks}, {"--json": args.json})
    make_folder(args.output)
    ended: dict[str, Ended] = {}
    with Display(args.progress, named=True) as display:
        for name, how in _run(tasks, min(args.jobs, len(tasks)), display):
            ended[name] = how
            display.end(name)
            for line in how.lines:
                display.say(f"{name}: {line}", sys.stdout)
            if how.error is not None:
                display.say(f"izo: {name}: {how.error}", sys.stderr)
    if args.json:
        reports = [
            {
                "input": name,
                "output": str(task.output),
                "exit_code": ended[name].code,
                "error": ended[name].error,
                "frames": ended[name].frames,
            }
            for name, task in tasks.items()
        ]
        save_json(args.json, {"sequences": reports})
    return max((how.code for how in ended.values()), key=ORDER.index)


def _tasks(args: argparse.Namespace) -> dict[str, argparse.Namespace]:
    """Return what the parser would have found for each animation alone, by its path."""
    tasks: dict[str, argparse.Namespace] = {}
    outputs: dict[str, str] = {}
    for path in args.animation:
        name = Path(path).resolve().name
        other = outputs.setdefault(name.casefold(), path)
        if other != path or path in tasks:
            raise FileFormatError(
                f"{path}: would be written to the same name as {other}; resolve it alone, or "
                "rename it"
            )
        task = copy(args)
        task.animation, task.output, task.json = path, Path(args.output) / name, None
        tasks[path] = task
    return tasks


def _run(
    tasks: dict[str, argparse.Namespace], jobs: int, display: Display
) -> Iterator[tuple[str, Ended]]:
    """Yield how each sequence ended, as they end."""
    context = multiprocessing.get_context("spawn")
    n_threads = max(1, numba.get_num_threads() // jobs)
    waiting = list(tasks.items())
    running: dict[Connection, tuple[str, BaseProcess]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                name, task = waiting.pop(0)
                receiver, sender = cast(tuple[Connection, Connection], context.Pipe(duplex=False))
                process = context.Process(target=_work, args=(task, sender, n_threads))
                with _without_interrupt():
                    process.start()
                sender.close()
                running[receiver] = name, process
            for receiver in cast(list[Connection], wait(list(running))):
                name, process = running[receiver]
                found = _received(receiver, process)
                if isinstance(found, Progress):
                    display.tell(name, found)
                else:
                    del running[receiver]
                    process.join()
                    yield name, found
    finally:
        _end([process for _, process in running.values()])


@contextmanager
def _without_interrupt() -> Iterator[None]:
    """Let a process that is started here ignore the keys Ctrl and C, which this process obeys."""
    try:
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    except ValueError:  # not the main thread, where no signal arrives
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _received(receiver: Connection, process: BaseProcess) -> Progress | Ended:
    """Return what a process says; if it ended without a word, how it ended."""
    try:
        return receiver.recv()
    except (EOFError, OSError):
        process.join()
    code = process.exitcode or 0
    how = f"the exit code {code}"
    if code < 0:
        with suppress(ValueError):
            how = f"the signal {signal.Signals(-code).name}"
    return Ended(BAD_INPUT, [], f"its process ended with {how}; the others go on", [])


def _end(processes: list[BaseProcess]) -> None:
    """End processes that are not needed any more; what they have kept stays whole."""
    for process in processes:
        process.terminate()
    for process in processes:
        process.join(PATIENCE_S)
        if process.is_alive():
            process.kill()
            process.join()


def _work(task: argparse.Namespace, sender: Connection, n_threads: int) -> None:
    """Resolve one animation, in a process of its own, and send how far it is and how it ended."""
    numba.set_num_threads(n_threads)
    with suppress(BrokenPipeError):  # the command was killed, so nobody listens any more
        sender.send(_resolved(task, sender))


def _resolved(task: argparse.Namespace, sender: Connection) -> Ended:
    try:
        reports = resolve_file(task, sender.send)
    except IzoError as error:
        said = f"{type(error).__name__}: {with_flags(str(error))}"
    except BrokenPipeError:
        raise
    except (MemoryError, OSError) as error:
        said = failure(error)
    else:
        return Ended(*ending(reports), None, reports)
    return Ended(BAD_INPUT, [], said, [])
