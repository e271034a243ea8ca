"""The exchange by a folder: requests in one file, replies in another, for ports elsewhere."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import read_bytes
from izo_ref.porting.cases import Case
from izo_ref.porting.conform.incidents import FLOOD, MISSING, SEVERAL, Incident
from izo_ref.porting.conform.program import LONGEST_LINE
from izo_ref.porting.conform.protocol import (
    GREETING,
    Request,
    hello_of,
    line_of,
    object_of,
    request_line,
    require_id,
)
from izo_ref.porting.conform.run import Choice, Row, Run, failed, is_supported, judged
from izo_ref.porting.conform.text import clean
from izo_ref.porting.judge.outcome import NOT_SUPPORTED, Outcome
from izo_ref.porting.judge.verdict import UNSUPPORTED

REQUESTS, REPLIES = "requests.jsonl", "replies.jsonl"


def write_requests(file: BinaryIO, requests: Sequence[Request]) -> None:
    """Write the greeting and the requests, one a line."""
    file.write(line_of(GREETING))
    for request in requests:
        file.write(request_line(request))


def judge_folder(folder: Path, cases: Sequence[Case], choice: Choice) -> Run:
    """Judge the replies in a folder.

    Args:
        folder: Has the requests that were written, and the replies to them.
        cases: All cases of the vectors.
        choice: Which of the requests are judged.

    Raises:
        FileFormatError: A file cannot be read, or the requests are of other vectors.
    """
    requests = _read_requests(folder / REQUESTS, cases)
    lines = _lines(folder / REPLIES)
    try:
        if not lines:
            raise Incident(MISSING, "there is no line")
        hello = hello_of(lines[0])
    except Incident as incident:
        return Run(None, (), (f"{folder / REPLIES}, {incident.kind}: {incident.sentence}",))
    replies = _Replies(lines[1:], requests)
    rows = []
    for i, request in enumerate(requests):
        row = replies.row(i, is_supported(request, hello))
        if _is_chosen(request, choice):
            rows.append(row)
    notes = ()
    if replies.at < len(replies.lines):
        extra = len(replies.lines) - replies.at
        notes = (f"{SEVERAL}: {folder / REPLIES} has {extra} lines more than requests",)
    return Run(hello, tuple(rows), notes)


def _is_chosen(request: Request, choice: Choice) -> bool:
    return (
        (not choice.stages or request.case.stage in choice.stages)
        and (not choice.dtypes or request.dtype in choice.dtypes)
        and (not choice.cases or request.case.id in choice.cases)
    )


def _read_requests(path: Path, cases: Sequence[Case]) -> list[Request]:
    """Return the requests of a file."""
    known = {case.id: case for case in cases}
    requests = []
    for line in _lines(path)[1:]:
        try:
            record = object_of(line)
            request = Request(known[record["id"]], record["dtype"])
        except (Incident, KeyError, TypeError):
            raise FileFormatError(f"{path}: has a request that is not of these vectors") from None
        if request_line(request).rstrip(b"\n") != line:
            raise FileFormatError(f"{path}: {request.case.id} has another input in these vectors")
        requests.append(request)
    return requests


def _lines(path: Path) -> list[bytes]:
    """Return the lines of a file, without their ends; a last empty one does not count."""
    lines = read_bytes(path).split(b"\n")
    return [line.rstrip(b"\r") for line in (lines if lines[-1] else lines[:-1])]


class _Line(NamedTuple):
    """A line of the replies: the object that it is, or what is wrong with it."""

    reply: dict[str, Any]
    incident: Incident | None


def _parsed(line: bytes) -> _Line:
    try:
        if len(line) > LONGEST_LINE:
            raise Incident(FLOOD, f"the line has {len(line)} bytes")
        return _Line(object_of(line), None)
    except Incident as incident:
        return _Line({}, incident)


class _Replies:
    """The lines of the replies, and which of them belongs to which request.

    A port answers in order. It may leave out what its first line does not name, or answer that
    with `unsupported`.
    """

    def __init__(self, lines: Sequence[bytes], requests: Sequence[Request]) -> None:
        self.lines = [_parsed(line) for line in lines]
        self.at = 0
        self._requests = requests
        self._ids = {request.case.id for request in requests}

    def row(self, i: int, supported: bool) -> Row:
        """Judge the reply to request i."""
        request = self._requests[i]
        line = self.lines[self.at] if self.at < len(self.lines) else None
        if not supported:
            if line and line.reply.get("id") == request.case.id:
                self.at += line.reply.get("status") == UNSUPPORTED
            return Row(request, Outcome(NOT_SUPPORTED))
        if line is None:
            return Row(request, failed(Incident(MISSING, "the replies end before this request")))
        got = line.reply.get("id")
        if line.incident is None and got != request.case.id and got in self._later(i):
            text = f"there is no reply here; the next line answers {clean(got, 80)}"
            return Row(request, failed(Incident(MISSING, text)))
        self.at += 1
        try:
            if line.incident is not None:
                raise line.incident
            require_id(line.reply, request, self._ids)
        except Incident as incident:
            return Row(request, failed(incident))
        return judged(request, line.reply)

    def _later(self, i: int) -> Collection[Any]:
        return [request.case.id for request in self._requests[i + 1 :]]
