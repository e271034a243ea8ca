"""A session with a port: the program, its introduction, and one reply for each request."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from types import TracebackType
from typing import Any

from izo_ref.porting.conform.incidents import ORDER, WRONG_ID, Incident
from izo_ref.porting.conform.program import Program
from izo_ref.porting.conform.protocol import (
    GREETING,
    Hello,
    Request,
    hello_of,
    late_line,
    line_of,
    object_of,
    request_line,
    require_id,
)


class Session:
    """A port that runs. Use it as a context, which ends the program.

    Args:
        words: The program and its arguments.
        seconds: How long one exchange may take.
        gib: Largest address space of the program [GiB], or None.

    Attributes:
        hello: How the port introduced itself.

    Raises:
        OptionError: The program cannot be started.
        Incident: The port does not introduce itself.
    """

    def __init__(self, words: Sequence[str], seconds: float, gib: float | None = None) -> None:
        """Start the program and let it introduce itself."""
        self._seconds = seconds
        self._last: str | None = None  # the case that was answered last
        self._program = Program(words, gib)
        try:
            self.hello: Hello = hello_of(self._program.exchange(line_of(GREETING), seconds))
        except BaseException:
            self._program.kill()
            raise

    def __enter__(self) -> Session:
        """Return the session."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """End the program."""
        self._program.kill()

    def ask(self, request: Request, cases: Collection[str]) -> dict[str, Any]:
        """Return the reply to a request.

        Args:
            request: The case and the type of floats.
            cases: Identifiers of all cases of the run.

        Raises:
            Incident: There is no reply, or not the one that was asked for. `about_last` is true if
                the port had written more for the case before than one line.
        """
        extra = self._program.unasked()
        if extra:
            raise late_line(extra)
        line = self._program.exchange(request_line(request), self._seconds)
        reply = object_of(line)
        try:
            require_id(reply, request, cases)
        except Incident as incident:
            if incident.kind in (ORDER, WRONG_ID) and self._last == reply.get("id") is not None:
                raise late_line(line) from None
            raise
        self._last = request.case.id
        return reply

    def finish(self) -> None:
        """Let the program end.

        Raises:
            Incident: It does not end, or not well, or it writes more lines.
        """
        extra = self._program.finish(self._seconds)
        if extra:
            raise late_line(extra)
