"""Our own port: answers the protocol of `izo conform` with izo_ref's compiled functions.

    izo conform --exec "python -m tests.ports.own"

Each stage is a module `sNN.py` beside this file, with a function `answer`.
"""

import json
import sys
from collections.abc import Iterable, Iterator
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from izo_ref import IzoError, __version__
from izo_ref.porting.cases import DTYPES, decode, encode
from izo_ref.porting.stages import STAGE


def module_of(stage: str) -> str:
    """Return the name of the module of a stage."""
    return f"tests.ports.own.s{int(stage[1:]):02d}"


def hello() -> dict[str, Any]:
    """Return how the port introduces itself."""
    stages = [stage for stage in STAGE if find_spec(module_of(stage))]
    return {"name": "izo_ref", "version": __version__, "stages": stages, "dtypes": list(DTYPES)}


def plain(value: Any) -> Any:
    """Return a value of numpy or Python as JSON holds it."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.ravel().tolist() if np.ndim(value) else value.item()
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return encode(int(value) if isinstance(value, bool) else value)


def reply(request: dict[str, Any]) -> dict[str, Any]:
    """Return the reply to a request."""
    answer = import_module(module_of(request["stage"])).answer
    try:
        output = answer(decode(request["input"]), request["dtype"])
    except NotImplementedError as error:
        return {"status": "unsupported", "message": str(error)}
    except IzoError as error:
        found: dict[str, Any] = {"status": "refused", "message": str(error)}
        offender = getattr(error, "offender", None)
        return found if offender is None else found | {"output": {"offender": plain(offender)}}
    return {"status": "ok", "output": {name: plain(value) for name, value in output.items()}}


def replies(lines: Iterable[str]) -> Iterator[dict[str, Any]]:
    """Yield one reply for each line."""
    for line in lines:
        request = json.loads(line)
        yield hello() if "hello" in request else {"id": request["id"], **reply(request)}


if __name__ == "__main__":
    for record in replies(sys.stdin):
        print(json.dumps(record, separators=(",", ":")), flush=True)
