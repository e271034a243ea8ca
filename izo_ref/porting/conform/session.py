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

SURPLUS_S = 0.002  # how long to look for output behind a reply
FIRST_SURPLUS_S = 0.02  # and behind the first lines of a program
SURPLUS_WAITS = 3  # how many lines are the first ones
AFTER_GARBAGE_S = 0.25  # for the reply behind a line that is none


class Session:
    """A port that runs. Use it as a context, which ends the program.

    Args:
        words: The program and its arguments.
        seconds: How long one exchange may take.
        gib: Largest address space of the program [GiB], or None.
        show_errors: Whether what it writes to its error output is written to ours.

    Attributes:
        hello: How the port introduced itself.

    Raises:
        OptionError: The program cannot be started.
        Incident: The port does not introduce itself.
    """

    def __init__(
        self,
        words: Sequence[str],
        seconds: float,
        gib: float | None = None,
        show_errors: bool = False,
    ) -> None:
        """Start the program and let it introduce itself."""
        self._seconds = seconds
        self._last: str | None = None  # the case that was answered last
        self._surplus_waits = SURPLUS_WAITS
        self._program = Program(words, gib, show_errors)
        try:
            self.hello: Hello = hello_of(self._program.exchange(line_of(GREETING), seconds))
            self._refuse_surplus("its introduction", about_last=False)
        except Incident as incident:
            incident.error_output = self._program.error_output()
            self._program.kill()
            raise
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
        try:
            extra = self._program.unasked()
            if extra:
                raise late_line(extra)
            line = self._program.exchange(request_line(request), self._seconds)
            return self._reply(line, request, cases)
        except Incident as incident:
            incident.error_output = self._program.error_output()
            raise

    def look_for_surplus(self) -> None:
        """Check that the port wrote one line alone for the request before.

        Raises:
            Incident: It wrote more.
        """
        self._refuse_surplus("its reply", about_last=True)

    def _reply(self, line: bytes, request: Request, cases: Collection[str]) -> dict[str, Any]:
        """Return the reply that a line is, if it belongs to the request."""
        try:
            reply = object_of(line)
        except Incident as incident:
            if self._answers_now(request):
                text = f"{incident.sentence}; the next line is the reply"
                raise Incident(incident.kind, text) from None
            raise
        try:
            require_id(reply, request, cases)
        except Incident as incident:
            if incident.kind in (ORDER, WRONG_ID) and self._last == reply.get("id") is not None:
                raise late_line(line) from None
            raise
        self._last = request.case.id
        return reply

    def _answers_now(self, request: Request) -> bool:
        """Return whether the line behind a line that is no reply is the reply to a request."""
        line = self._program.next_line(AFTER_GARBAGE_S)
        try:
            return line is not None and object_of(line).get("id") == request.case.id
        except Incident:
            return False

    def _refuse_surplus(self, what: str, about_last: bool) -> None:
        """Raise an incident if the port writes more than one line.

        The first lines of a program get more time, so that a port that prints behind every reply is
        always reported in the same way.
        """
        wait = FIRST_SURPLUS_S if self._surplus_waits > 0 else SURPLUS_S
        self._surplus_waits -= 1
        extra = self._program.unasked(wait)
        if extra:
            incident = late_line(extra, what, about_last)
            incident.error_output = self._program.error_output()
            raise incident

    def finish(self) -> None:
        """Let the program end.

        Raises:
            Incident: It does not end, or not well, or it writes more lines.
        """
        try:
            extra = self._program.finish(self._seconds)
            if extra:
                raise late_line(extra)
        except Incident as incident:
            incident.error_output = self._program.error_output()
            raise
