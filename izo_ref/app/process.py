"""End the process of a command with its exit code; say why if it has to end early."""

import errno
import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn, TextIO

BROKEN_PIPE = 141  # the exit code of a program that the signal SIGPIPE ends
CANNOT_RUN = 2  # what the machine cannot do ends a command like bad input
WRITING = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)
NO_ROOM = "failed to map segment"  # what the loader of libraries says without memory
STANDARD_FILES = 3  # input, output and error have the first numbers
_closed: set[str] = set()  # which of the outputs were closed when the command started


def run_and_exit(main: Callable[[], int], program: str = "izo") -> NoReturn:
    """Run a command, and end the process with its exit code.

    * If the program that reads the output ends first, as `head` does, nothing is left to say.
    * If the disk is full, the memory is used up, or a file cannot be read or written, a sentence
      says so, and the exit code is that of bad input.
    * The keys Ctrl and C end the process by the signal, as they end other programs.

    Args:
        main: Runs the command and returns its exit code.
        program: Name of the program, for the sentence.
    """
    open_standard_files()
    sys.exit(_code_of(main, program))


def _code_of(main: Callable[[], int], program: str) -> int | str | None:
    """Run a command; return its exit code, also if it has to end early."""
    try:
        try:
            code = main()
        except SystemExit as end:  # the parser of the command line
            code = end.code
        sys.stdout.flush()
    except BrokenPipeError:
        _discard(sys.stdout)
        return BROKEN_PIPE
    except MemoryError as error:
        return _fail(program, failure(error))
    except ImportError as error:
        if NO_ROOM not in str(error):
            raise
        return _fail(program, f"not enough memory: {error}")
    except OSError as error:
        return _fail(program, failure(error))
    except KeyboardInterrupt:
        _end_by_interrupt(program)
    return code


def open_standard_files() -> None:
    """Connect a standard input, output or error that is closed to the null device.

    Otherwise the next file that is opened would take its number, and what is printed would go into
    that file.
    """
    for number in range(STANDARD_FILES):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the smallest number that is free
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            _closed.add(name)
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 (until the process ends)


def output_is_closed() -> bool:
    """Return whether the command was started without a standard output."""
    return "stdout" in _closed


def _fail(program: str, sentence: str) -> int:
    """Say why a command ends; return its exit code."""
    try:
        sys.stdout.flush()  # what was said before
    except OSError as error:
        sentence = f"the standard output cannot be written: {error.strerror or error}"
        _discard(sys.stdout)
    try:
        print(f"{program}: {sentence}", file=sys.stderr, flush=True)
    except OSError:
        _discard(sys.stderr)
    return CANNOT_RUN


def failure(error: MemoryError | OSError) -> str:
    """Return what the machine could not do, in words."""
    if isinstance(error, MemoryError):
        return f"not enough memory{f': {error}' if str(error) else ''}"
    what = error.strerror or str(error)
    if error.filename is not None:
        return f"{error.filename}: {what}"
    if error.errno in WRITING:  # files that are written are named
        return f"the standard output cannot be written: {what}"
    return what


def _discard(stream: TextIO) -> None:
    """Let an output go nowhere: Python flushes it once more when it ends."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _end_by_interrupt(program: str) -> NoReturn:
    """End the process by the signal, so that a shell or a script knows of it."""
    with suppress(OSError):
        print(f"{program}: interrupted", file=sys.stderr, flush=True)
    _discard(sys.stdout)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGINT)
    sys.exit(128 + signal.SIGINT)  # where a process cannot end itself by a signal
