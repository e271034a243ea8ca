"""The protocol of `izo conform` for ports in Python: one line of JSON in, one line out."""

import json
import sys
from collections.abc import Callable, Mapping
from typing import Any

from izo_ref import IzoError, __version__
from izo_ref.porting.cases import decode, encode

Answer = Callable[[dict[str, Any], str], dict[str, Any]]


def reply(request: Mapping[str, Any], answers: Mapping[str, Answer]) -> dict[str, Any]:
    """Return the reply to the request of a case.

    Args:
        request: What one line of the protocol says.
        answers: For each stage of the port, the function that computes its outputs.
    """
    head = {"id": request["id"]}
    if request["stage"] not in answers:
        return {**head, "status": "unsupported"}
    try:
        output = answers[request["stage"]](decode(request["input"]), request["dtype"])
    except NotImplementedError as error:
        return {**head, "status": "unsupported", "message": str(error)}
    except IzoError as error:
        return {**head, "status": "refused", "message": str(error)}
    return {**head, "status": "ok", "output": encode(output)}


def serve(name: str, answers: Mapping[str, Answer]) -> None:
    """Answer the lines of the standard input until it ends; all answers are in float64."""
    hello = {"name": name, "version": __version__, "stages": list(answers), "dtypes": ["f8"]}
    for line in sys.stdin:
        request = json.loads(line)
        answered = hello if "hello" in request else reply(request, answers)
        print(json.dumps(answered), flush=True)
