"""Run a port over all cases: restart it after an incident, and judge every reply."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from typing import NamedTuple

from izo_ref.porting.cases import DTYPES, Case
from izo_ref.porting.conform.incidents import Incident
from izo_ref.porting.conform.protocol import Hello, Request
from izo_ref.porting.conform.session import Session
from izo_ref.porting.judge.outcome import (
    FAILED,
    NOT_RUN,
    NOT_SUPPORTED,
    Difference,
    Outcome,
)
from izo_ref.porting.judge.verdict import judge
from izo_ref.porting.stages import STAGE

RESTARTS = 20


class Choice(NamedTuple):
    """Which cases a run takes; everything if a field is empty.

    Attributes:
        stages: Names of stages.
        dtypes: Types of floats.
        cases: Identifiers of cases.
    """

    stages: Collection[str] = ()
    dtypes: Collection[str] = ()
    cases: Collection[str] = ()


class Row(NamedTuple):
    """One case with one type of floats, and what came of it.

    Attributes:
        request: The case and the type of floats.
        outcome: The outcome.
        seconds: How long the port took.
    """

    request: Request
    outcome: Outcome
    seconds: float = 0.0


class Run(NamedTuple):
    """A whole run.

    Attributes:
        port: How the port introduced itself; None if it did not.
        rows: One row for each case and type of floats, in the order of the vectors.
        notes: What went wrong and belongs to no case.
        restarts: How often the program was started again.
    """

    port: Hello | None
    rows: tuple[Row, ...]
    notes: tuple[str, ...] = ()
    restarts: int = 0


def requests_of(cases: Sequence[Case], choice: Choice) -> list[Request]:
    """Return the cases that are chosen, with the types of floats for which they have a meaning.

    The order is that of the stages, of the cases in their file, and f8 before f4.
    """
    order = list(STAGE)
    return [
        Request(case, dtype)
        for case in sorted(cases, key=lambda case: order.index(case.stage))
        for dtype in DTYPES
        if dtype in case.dtypes
        and (not choice.stages or case.stage in choice.stages)
        and (not choice.dtypes or dtype in choice.dtypes)
        and (not choice.cases or case.id in choice.cases)
    ]


def is_supported(request: Request, hello: Hello) -> bool:
    """Return whether a port says that it has the stage and the type of floats of a request."""
    return request.case.stage in hello.stages and request.dtype in hello.dtypes


def failed(incident: Incident) -> Outcome:
    """Return the outcome of a case that an incident ended."""
    return Outcome(FAILED, (Difference(incident.kind, incident.sentence),))


def run_program(
    words: Sequence[str],
    requests: Sequence[Request],
    seconds: float = 10.0,
    gib: float | None = None,
    restarts: int = RESTARTS,
) -> Run:
    """Run a port over requests.

    Args:
        words: The program and its arguments.
        requests: What to ask, in order.
        seconds: How long one answer may take.
        gib: Largest address space of the program [GiB], or None.
        restarts: How often the program may be started again after an incident.

    Returns:
        The run, which has a row for each request.

    Raises:
        OptionError: The program cannot be started.
    """
    runner = _Runner(words, requests, seconds, gib)
    for attempt in range(restarts + 1):
        runner.go_on()
        if runner.is_done:
            return runner.result(attempt)
    runner.give_up(f"the port was started again {restarts} times before; this is the limit")
    return runner.result(restarts)


class _Runner:
    """A run that goes on after incidents; what it has so far."""

    def __init__(
        self, words: Sequence[str], requests: Sequence[Request], seconds: float, gib: float | None
    ) -> None:
        self._start = words, seconds, gib
        self._requests = requests
        self._ids = {request.case.id for request in requests}
        self._port: Hello | None = None
        self._outcomes: list[Row] = []
        self._last_asked: int | None = None
        self._notes: list[str] = []
        self.is_done = False

    def go_on(self) -> None:
        """Start the program, and ask until everything is answered or an incident ends it."""
        try:
            with Session(*self._start) as session:
                self._port = self._port or session.hello
                self._ask_all(session)
        except Incident as incident:
            if incident.about_last and self._last_asked is not None:
                self._blame(self._last_asked, incident)
            elif len(self._outcomes) == len(self._requests):
                self._notes.append(f"{incident.kind}: {incident.sentence}")
            else:
                self._notes.append(f"the first exchange, {incident.kind}: {incident.sentence}")
                self.is_done = self._port is None  # nothing is known about this program
        if self._port is not None and len(self._outcomes) == len(self._requests):
            self.is_done = True

    def _ask_all(self, session: Session) -> None:
        while len(self._outcomes) < len(self._requests):
            request = self._requests[len(self._outcomes)]
            if not is_supported(request, session.hello):
                self._outcomes.append(Row(request, Outcome(NOT_SUPPORTED)))
                continue
            begin = time.perf_counter()
            try:
                reply = session.ask(request, self._ids)
            except Incident as incident:
                if incident.about_last and self._last_asked is not None:
                    raise
                self._last_asked = None
                outcome = failed(incident)
                self._outcomes.append(Row(request, outcome, time.perf_counter() - begin))
                return
            self._last_asked = len(self._outcomes)
            outcome = judge(request.case, reply, request.dtype)
            self._outcomes.append(Row(request, outcome, time.perf_counter() - begin))
        session.finish()

    def _blame(self, i: int, incident: Incident) -> None:
        """Let an incident count for a case that was answered before."""
        row = self._outcomes[i]
        differences = failed(incident).differences
        if row.outcome.result == FAILED:
            differences = row.outcome.differences + differences
        self._outcomes[i] = row._replace(outcome=Outcome(FAILED, differences))
        self._last_asked = None

    def give_up(self, reason: str) -> None:
        """Mark the requests that are left as not run."""
        for request in self._requests[len(self._outcomes) :]:
            outcome = Outcome(NOT_RUN, (Difference("no-reply", f"not asked: {reason}"),))
            self._outcomes.append(Row(request, outcome))

    def result(self, restarts: int) -> Run:
        """Return the run."""
        rows = self._outcomes if self._port is not None else ()
        return Run(self._port, tuple(rows), tuple(self._notes), restarts)
