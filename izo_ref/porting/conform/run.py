"""Run a port over all cases: restart it after an incident, and judge every reply."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from typing import Any, NamedTuple

from izo_ref.porting.cases import DTYPES, Case
from izo_ref.porting.conform.incidents import MISSING, Incident
from izo_ref.porting.conform.protocol import Hello, Request
from izo_ref.porting.conform.session import Session
from izo_ref.porting.judge.outcome import (
    FAILED,
    INCIDENT,
    NOT_RUN,
    NOT_SUPPORTED,
    PASSED,
    Difference,
    Outcome,
)
from izo_ref.porting.judge.verdict import judge
from izo_ref.porting.stages import STAGE

RESTARTS = 20
ALIKE = 3  # incidents of one kind in a row, after which the rest is not asked
BEGINNING = 40  # characters of a sentence by which incidents are of one kind


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
        reply: The reply, if it is wrong.
    """

    request: Request
    outcome: Outcome
    seconds: float = 0.0
    reply: Mapping[str, Any] | None = None


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
    difference = Difference(incident.kind, incident.sentence, cause=INCIDENT)
    return Outcome(FAILED, (difference._replace(error_output=incident.error_output),))


def judged(request: Request, reply: Mapping[str, Any], seconds: float = 0.0) -> Row:
    """Judge a reply, and return the row of its request."""
    outcome = judge(request.case, reply, request.dtype)
    return Row(request, outcome, seconds, reply if outcome.result == FAILED else None)


def note_of(incident: Incident, where: str = "") -> str:
    """Return the note about an incident that belongs to no case, with the error output below it."""
    lines = [f"{where}{incident.kind}: {incident.sentence}"]
    if incident.error_output:
        lines.append("the last lines of its error output:")
    return "\n  ".join([*lines, *incident.error_output.splitlines()])


def run_program(
    words: Sequence[str],
    requests: Sequence[Request],
    seconds: float = 10.0,
    gib: float | None = None,
    restarts: int = RESTARTS,
    show_errors: bool = False,
) -> Run:
    """Run a port over requests.

    Args:
        words: The program and its arguments.
        requests: What to ask, in order.
        seconds: How long one answer may take.
        gib: Largest address space of the program [GiB], or None.
        restarts: How often the program may be started again after an incident.
        show_errors: Whether what it writes to its error output is written to ours.

    Returns:
        The run, which has a row for each request.

    Raises:
        OptionError: The program cannot be started.
    """
    runner = _Runner(requests, words, seconds, gib, show_errors)
    for attempt in range(restarts + 1):
        runner.go_on()
        if runner.is_done:
            return runner.result(attempt)
    runner.give_up(f"the port was started again {restarts} times before; this is the limit")
    return runner.result(restarts)


class _Runner:
    """A run that goes on after incidents; what it has so far."""

    def __init__(self, requests: Sequence[Request], *start: Any) -> None:
        self._start = start
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
                self._notes.append(note_of(incident))
            else:
                self._notes.append(note_of(incident, "the first exchange, "))
                self.is_done = self._port is None  # nothing is known about this program
                if len(self._notes) >= ALIKE and len({*self._notes[-ALIKE:]}) == 1:
                    self._notes[-ALIKE + 1 :] = []
                    self.give_up(f"the first exchange failed {ALIKE} times in a row")
        kind = self._repeated()
        if kind and len(self._outcomes) < len(self._requests):
            self.give_up(f"stopped after {ALIKE} incidents of the same kind in a row: {kind}")
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
            self._outcomes.append(judged(request, reply, time.perf_counter() - begin))
            session.look_for_surplus()
        session.finish()

    def _blame(self, i: int, incident: Incident) -> None:
        """Let an incident count for a case that was answered before."""
        row = self._outcomes[i]
        differences = failed(incident).differences
        if row.outcome.result == FAILED:
            differences += row.outcome.differences
        self._outcomes[i] = row._replace(outcome=Outcome(FAILED, differences))
        self._last_asked = None

    def _repeated(self) -> str:
        """Return the kind of incident of the last cases that were asked, if it is one."""
        asked = [row for row in self._outcomes if row.outcome.result in (PASSED, FAILED)]
        kinds = {_incident_of(row) for row in asked[-ALIKE:]}
        (kind,) = kinds if len(asked) >= ALIKE and len(kinds) == 1 else [("", "")]
        return kind[0]

    def give_up(self, reason: str) -> None:
        """Mark the requests that are left as not run."""
        self._notes.append(reason)
        for request in self._requests[len(self._outcomes) :]:
            difference = Difference(MISSING, f"not asked: {reason}", cause=INCIDENT)
            outcome = Outcome(NOT_RUN, (difference,))
            if self._port is not None and not is_supported(request, self._port):
                outcome = Outcome(NOT_SUPPORTED)
            self._outcomes.append(Row(request, outcome))

    def result(self, restarts: int) -> Run:
        """Return the run."""
        rows = self._outcomes if self._port is not None else ()
        return Run(self._port, tuple(rows), tuple(self._notes), restarts)


def _incident_of(row: Row) -> tuple[str, str]:
    """Return the kind of the last incident of a row, and how its sentence begins."""
    for difference in reversed(row.outcome.differences):
        if difference.cause == INCIDENT:
            sentence = difference.sentence.replace(row.request.case.id, "")
            return difference.output, sentence[:BEGINNING]
    return "", ""
