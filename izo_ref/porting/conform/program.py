"""A program that is started once, and exchanges one line for one line.

Pipes are read and written without waiting on any one of them, so that a program that neither reads
nor writes, or writes without end, cannot stop the harness. What is kept of its output is bounded.
"""

from __future__ import annotations

import contextlib
import os
import re
import selectors
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from typing import IO, cast

from izo_ref.base.errors import OptionError
from izo_ref.porting.conform.incidents import CLOSED, CRASH, FLOOD, HANG, MEMORY, Incident
from izo_ref.porting.conform.text import clean_bytes, last_lines

LONGEST_LINE = 16 << 20  # bytes; the longest reply of the vectors is far below 1 MB
TAIL = 8192  # bytes of the error output that are kept
SLICE_S = 0.25  # how often it is checked whether a silent program has ended
GRACE_S = 1.0  # for a program that closed its output to end
BLOCK = 1 << 16
READS = 64  # of what a program wrote before it ended; a flood has no end

# How programs say that memory is short: C++, Rust, Python, C and numpy.
NO_MEMORY = re.compile(
    rb"bad_alloc|memory allocation of \d+ bytes failed|MemoryError|Cannot allocate memory|"
    rb"[Oo]ut of memory|cannot allocate memory",
)
LIMIT = (
    "import os, resource, sys\n"
    "kind, size = resource.RLIMIT_AS, int(sys.argv[1])\n"
    "hard = resource.getrlimit(kind)[1]\n"
    "size = size if hard == resource.RLIM_INFINITY else min(size, hard)\n"
    "resource.setrlimit(kind, (size, size))\n"
    "os.execvp(sys.argv[2], sys.argv[2:])\n"
)


class Program:
    """A running program. End it with `kill`, whatever happens.

    Args:
        words: The program and its arguments.
        gib: Largest address space [GiB], or None for no limit.
        show_errors: Whether what it writes to its error output is written to ours.

    Raises:
        OptionError: There is no such program, or it cannot be started.
    """

    def __init__(
        self, words: Sequence[str], gib: float | None = None, show_errors: bool = False
    ) -> None:
        """Start the program, in a process group of its own."""
        if shutil.which(words[0]) is None:
            raise OptionError(
                f"--exec: there is no program {words[0]!r} that can be run from {os.getcwd()}"
            )
        if gib is not None:
            words = [sys.executable, "-I", "-S", "-c", LIMIT, str(int(gib * 2**30)), *words]
        self._gib, self._show_errors = gib, show_errors
        try:
            self._process = subprocess.Popen(
                words,
                bufsize=0,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                start_new_session=True,
            )
        except OSError as error:
            raise OptionError(f"--exec: {words[0]} cannot be started: {error.strerror}") from None
        pipes = self._process.stdin, self._process.stdout, self._process.stderr
        self._in, self._out, self._err = cast("tuple[IO[bytes], IO[bytes], IO[bytes]]", pipes)
        self._lines, self._tail = bytearray(), bytearray()
        self._error_bytes, self._is_cut = 0, False
        self._ended = False  # whether the end of its output was read
        self._selector = selectors.DefaultSelector()
        for pipe in (self._in, self._out, self._err):
            os.set_blocking(pipe.fileno(), False)
        for pipe in (self._out, self._err):
            self._selector.register(pipe, selectors.EVENT_READ)

    def exchange(self, request: bytes, seconds: float) -> bytes:
        """Send a line, and return the line that comes back, without its end.

        Args:
            request: The line.
            seconds: How long sending and waiting may take.

        Raises:
            Incident: No line comes back.
        """
        self._error_bytes = 0
        pending = memoryview(request)
        deadline = time.monotonic() + seconds
        self._selector.register(self._in, selectors.EVENT_WRITE)
        try:
            while True:
                end = self._lines.find(b"\n")
                if end >= 0:
                    return self._take(end)
                self._check(deadline, seconds, len(pending))
                for key, _ in self._selector.select(SLICE_S):
                    if key.fileobj is self._in:
                        pending = self._send(pending)
                    else:
                        self._read(key.fileobj)
        finally:
            self._silence(self._in)

    def unasked(self, seconds: float = 0.0) -> bytes:
        """Return what the program wrote without being asked, or nothing.

        Args:
            seconds: How long to wait for it.
        """
        deadline = time.monotonic() + seconds
        while True:
            left = max(deadline - time.monotonic(), 0.0)
            for key, _ in self._selector.select(left):
                self._read(key.fileobj)
            if self._lines or left == 0.0 or self._ended:
                return bytes(self._lines)

    def next_line(self, seconds: float) -> bytes | None:
        """Return the next line that the program writes without being asked; None if there is none.

        Args:
            seconds: How long to wait for it.
        """
        deadline = time.monotonic() + seconds
        while b"\n" not in self._lines and not self._ended and time.monotonic() < deadline:
            for key, _ in self._selector.select(max(deadline - time.monotonic(), 0.0)):
                self._read(key.fileobj)
        end = self._lines.find(b"\n")
        return None if end < 0 else self._take(end)

    def error_output(self) -> str:
        """Return the last lines that the program wrote to its error output."""
        for _ in range(READS):
            if not self._selector.select(0):
                break
            self.unasked()
        return last_lines(bytes(self._tail), self._is_cut)

    def finish(self, seconds: float) -> bytes:
        """Close the program's input and wait until it ends.

        Args:
            seconds: How long to wait.

        Returns:
            What it wrote meanwhile.

        Raises:
            Incident: It does not end, or not well.
        """
        with contextlib.suppress(OSError):
            self._in.close()
        deadline = time.monotonic() + seconds
        while self._process.poll() is None and time.monotonic() < deadline:
            if not self._selector.get_map():
                time.sleep(0.01)
            for key, _ in self._selector.select(0.05):
                self._read(key.fileobj)
            if len(self._lines) > LONGEST_LINE:
                break
        extra = self.unasked()
        if self._process.poll() is None:
            text = f"the program does not end within {seconds:g} s after the end of its input"
            raise Incident(HANG, text)
        if self._process.returncode != 0:
            raise self._end("after the end of its input")
        return extra

    def kill(self) -> None:
        """End the program and what it started, and close the pipes."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self._selector.close()
        for pipe in (self._in, self._out, self._err):
            with contextlib.suppress(OSError):
                pipe.close()

    def _take(self, end: int) -> bytes:
        line = bytes(self._lines[:end]).rstrip(b"\r")
        del self._lines[: end + 1]
        return line

    def _send(self, pending: memoryview) -> memoryview:
        """Write what the pipe takes; return what is left."""
        try:
            pending = pending[os.write(self._in.fileno(), pending[:BLOCK]) :]
        except BlockingIOError:
            return pending
        except BrokenPipeError:
            pending = pending[:0]  # it reads no more; whether it answers is seen by its output
        if not pending:
            self._silence(self._in)
        return pending

    def _read(self, pipe: object) -> None:
        """Read a block of one of the outputs."""
        source = self._out if pipe is self._out else self._err
        try:
            data = os.read(source.fileno(), BLOCK)
        except BlockingIOError:
            return
        if not data:
            self._silence(source)
            self._ended = self._ended or source is self._out
        elif source is self._out:
            self._lines += data
        else:
            self._error_bytes += len(data)
            self._is_cut = self._is_cut or len(self._tail) + len(data) > TAIL
            self._tail = (self._tail + data)[-TAIL:]
            if self._show_errors:
                _pass_on(data)

    def _silence(self, pipe: object) -> None:
        with contextlib.suppress(KeyError, ValueError):
            self._selector.unregister(pipe)  # type: ignore[arg-type]

    def _check(self, deadline: float, seconds: float, pending: int) -> None:
        """Raise an incident if the program cannot answer any more."""
        if len(self._lines) > LONGEST_LINE:
            text = f"the port wrote {len(self._lines)} bytes without the end of a line"
            raise Incident(FLOOD, text)
        if self._error_bytes > LONGEST_LINE:
            text = f"the port wrote more than {LONGEST_LINE} bytes to its error output for one case"
            raise Incident(FLOOD, text)
        if self._ended or self._process.poll() is not None:
            self.unasked()
            if b"\n" not in self._lines:
                raise self._end("before it answered")
        elif time.monotonic() > deadline:
            raise Incident(HANG, self._silent(seconds, pending))

    def _silent(self, seconds: float, pending: int) -> str:
        """Return the sentence about a program that does not answer in time."""
        text = f"no complete line within {seconds:g} s (--seconds)"
        if pending:
            text += f"; the port has not read its input, {pending} bytes are left"
        elif self._lines:
            text += f"; it wrote {clean_bytes(bytes(self._lines), 60)!r} and no end of the line"
        else:
            text += "; if the port writes, it must flush its output after each line"
        return text

    def _end(self, when: str) -> Incident:
        """Return the incident of a program that ended, or that closed its output."""
        try:
            code = self._process.wait(GRACE_S)
        except subprocess.TimeoutExpired:
            return Incident(CLOSED, "the port closed its output and runs on")
        self.unasked()
        rest = f", in the middle of the line {clean_bytes(bytes(self._lines), 60)!r}"
        rest = rest if self._lines else ""
        if code and NO_MEMORY.search(self._tail):
            limit = f" of {self._gib:g} GiB (--gib)" if self._gib else ""
            return Incident(MEMORY, f"the port ran out of memory{limit} {when}{rest}")
        if code == -signal.SIGKILL:
            text = f"the port was killed {when}, as the system does if memory is short{rest}"
            return Incident(MEMORY, text)
        if code < 0:
            return Incident(CRASH, f"the port crashed {when}: {_signal_name(-code)}{rest}")
        return Incident(CRASH, f"the port ended with exit code {code} {when}{rest}")


def _pass_on(data: bytes) -> None:
    """Write what a program wrote to its error output to ours."""
    sys.stderr.write(data.decode("utf-8", "backslashreplace"))
    sys.stderr.flush()


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
