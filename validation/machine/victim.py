"""Run a command in a child process that ends itself by a signal at a call that was chosen before.

The child is a fork of a process that has loaded everything, so that a moment takes a second.
"""

from __future__ import annotations

import io
import os
import runpy
import signal
import sys
import warnings
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from typing import Any, NoReturn

import numba

from validation import rows

COUNTED = ("open", "write", "fchmod", "fsync", "replace", "rename", "mkdir", "unlink", "truncate")
FAILED = 99  # exit code of a command that raised an error


class Victim:
    """Counts calls that change files, and ends the process at one of them.

    Args:
        number: The call; 0 for none.
        signal_number: The signal.
    """

    def __init__(self, number: int, signal_number: int) -> None:
        """Count from 0."""
        self.calls, self._number, self._signal = 0, number, signal_number

    def watch(self) -> None:
        """Count the calls of the system, and the lines of rows, from now on."""
        for name in COUNTED:
            setattr(os, name, self._counted(getattr(os, name)))
        true_append = rows._append

        def append(path: Any, cells: Any) -> None:
            line = rows._line(cells := list(cells)).encode()

            def write_half() -> None:
                with open(path, "ab", buffering=0) as file:
                    file.write(line[: len(line) // 2])

            self._count(write_half)
            true_append(path, cells)

        rows._append = append

    def _counted(self, true_call: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **more: Any) -> Any:
            self._count(lambda: None)
            return true_call(*arguments, **more)

        return call

    def _count(self, before: Callable[[], Any]) -> None:
        self.calls += 1
        if self.calls == self._number:
            before()
            os.kill(os.getpid(), self._signal)


def run(module: str, words: Sequence[str], places: dict[tuple[str, str], Any]) -> Any:
    """Run a command in this process.

    Args:
        module: What `python -m` would run.
        words: Its words.
        places: Values of variables of modules, by module and variable: where the checkout is.

    Returns:
        Its exit code.
    """
    for (holder, name), value in places.items():
        setattr(import_module(holder), name, value)
    sys.argv[:] = [module, *words]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # the module is loaded already
            runpy.run_module(module, run_name="__main__", alter_sys=False)
    except SystemExit as end:
        return end.code or 0
    return 0


def start(
    module: str,
    words: Sequence[str],
    places: dict[tuple[str, str], Any],
    call: int = 0,
    signal_number: int = signal.SIGKILL,
) -> tuple[int, int]:
    """Run a command in a child; see `run`.

    Returns:
        The number of the process, and a handle from which the number of calls can be read, if the
        process ends by itself.
    """
    reader, writer = os.pipe()
    # an interrupt in the child must not run what this process does at its end
    signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
    child = os.fork()
    if child != 0:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT,))
        os.close(writer)
        return child, reader
    try:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT,))
        os.close(reader)
        _live(module, words, places, Victim(call, signal_number), writer)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGINT)
    finally:
        os._exit(FAILED)


def _live(
    module: str, words: Sequence[str], places: dict[tuple[str, str], Any], victim: Victim, out: int
) -> NoReturn:
    code: Any = FAILED
    numba.set_num_threads(1)
    true_write = os.write
    with (
        open(os.devnull, "w") as null,
        redirect_stdout(null),
        redirect_stderr(io.StringIO()) as said,
    ):
        os.dup2(null.fileno(), 1)
        os.dup2(null.fileno(), 2)
        victim.watch()
        try:
            code = run(module, words, places)
        except Exception as error:
            print(repr(error), file=said)
        true_write(out, f"{victim.calls} {said.getvalue()[-500:]}".encode())
    os._exit(code if isinstance(code, int) else FAILED)


def ended(child: int, reader: int) -> tuple[int, str]:
    """Wait for a child.

    Returns:
        Its exit code, or minus the signal that ended it; and what it wrote at its end.
    """
    status = os.waitpid(child, 0)[1]
    with os.fdopen(reader, "rb") as file:
        text = file.read().decode(errors="replace")
    return os.waitstatus_to_exitcode(status), text
