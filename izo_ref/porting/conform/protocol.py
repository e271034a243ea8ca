"""The protocol: lines of JSON that go to a port, and lines that come back."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

from izo_ref.porting.cases import DTYPES, Case, encode
from izo_ref.porting.conform.incidents import GARBAGE, HELLO, ORDER, SEVERAL, WRONG_ID, Incident
from izo_ref.porting.conform.text import clean, clean_bytes
from izo_ref.porting.stages import STAGE

PROTOCOL = 1
GREETING = {"hello": "izo-conform", "protocol": PROTOCOL, "vectors": "v1"}
ALONE = "; standard output is for replies alone: print everything else to standard error"


class Hello(NamedTuple):
    """How a port introduced itself.

    Attributes:
        name: Its name.
        version: Its version.
        stages: Names of the stages that it has.
        dtypes: Types of floats with which it computes.
    """

    name: str
    version: str
    stages: tuple[str, ...]
    dtypes: tuple[str, ...]


class Request(NamedTuple):
    """One case with one type of floats."""

    case: Case
    dtype: str

    @property
    def key(self) -> tuple[str, str]:
        """The identifier of the case and the type of floats."""
        return self.case.id, self.dtype


def line_of(record: Mapping[str, Any]) -> bytes:
    """Return a line of JSON without spaces."""
    return json.dumps(record, allow_nan=False, separators=(",", ":")).encode() + b"\n"


def request_line(request: Request) -> bytes:
    """Return the line that asks a port for a case."""
    case = request.case
    record = {"id": case.id, "stage": case.stage, "dtype": request.dtype}
    return line_of(record | {"input": encode(case.inputs)})


def object_of(line: bytes) -> dict[str, Any]:
    """Return the JSON object that a line is.

    Raises:
        Incident: The line is something else.
    """
    try:
        record = json.loads(line.decode())
    except (ValueError, RecursionError) as error:
        reason = "it is not UTF-8" if isinstance(error, UnicodeDecodeError) else clean(error)
        text = f"expected one line of JSON, got {clean_bytes(line)!r} ({reason})"
        raise Incident(GARBAGE, text + ALONE) from None
    if not isinstance(record, dict):
        raise Incident(GARBAGE, f"expected a JSON object, got {clean_bytes(line)!r}{ALONE}")
    return record


def hello_of(line: bytes) -> Hello:
    """Return how a port introduces itself in its first line.

    Raises:
        Incident: The line does not say it.
    """
    record = object_of(line)
    for name in ("name", "version"):
        if not isinstance(record.get(name), str) or not record[name]:
            raise Incident(HELLO, f"the first line must have a text {name!r}{_found(record)}")
    stages = _words(record, "stages", tuple(STAGE))
    dtypes = _words(record, "dtypes", DTYPES)
    return Hello(clean(record["name"], 80), clean(record["version"], 80), stages, dtypes)


def _words(record: Mapping[str, Any], name: str, known: Collection[str]) -> tuple[str, ...]:
    """Return a list of known words of the first line, in the order in which they are known."""
    words = record.get(name)
    if not isinstance(words, list) or not words or any(word not in known for word in words):
        shown = ", ".join(known)
        text = f"the first line must have a list {name!r} of one or more of {shown}"
        raise Incident(HELLO, text + _found(record))
    return tuple(word for word in known if word in words)


def _found(record: Mapping[str, Any]) -> str:
    return f"; got {clean(json.dumps(record), 200)}"


def require_id(reply: Mapping[str, Any], request: Request, others: Collection[str]) -> None:
    """Check that a reply is about the case that was asked for.

    Args:
        reply: The reply.
        request: What was asked.
        others: Identifiers of all cases of the run.

    Raises:
        Incident: It is about another case.
    """
    got = reply.get("id")
    if got == request.case.id:
        return
    shown = clean(json.dumps(got), 80)
    if isinstance(got, str) and got in others:
        text = f"asked for {request.case.id}, the port answers {shown}; replies must be in order"
        raise Incident(ORDER, text)
    raise Incident(WRONG_ID, f"the reply must have the id {request.case.id!r}, got {shown}")


def late_line(line: bytes, what: str = "its reply", about_last: bool = True) -> Incident:
    """Return the incident of a line that nobody asked for.

    Args:
        line: What the port wrote.
        what: Behind what it wrote this.
        about_last: Whether the case before the one asked now is to blame.
    """
    first = line.partition(b"\n")[0]
    text = f"the port wrote another line after {what}: {clean_bytes(first, 100)!r}{ALONE}"
    return Incident(SEVERAL, text, about_last)
