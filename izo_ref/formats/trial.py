"""Read a file in a process of its own first, where a library may crash or want all memory.

The libraries of USD and Alembic are written in C++. On damaged files they may end the process,
print what they like, or ask for as much memory as a damaged number says. So a file is opened, and
all its frames are read, in a second process with limited memory; only what this process read is
opened here. It is started once, in about half a second, and serves all files.
"""

from __future__ import annotations

import atexit
import json
import os
import select
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from izo_ref.base.errors import FileFormatError

resource: ModuleType | None
try:
    import resource
except ImportError:  # Windows, where processes have no such limits
    resource = None

OWN_MEMORY = 2 << 30  # bytes; Python and the library take 0.5 GiB of addresses
PER_BYTE = 64  # bytes of memory for each byte of the file; faces are compressed in USD
SECONDS = 60  # for a small file on a busy machine
MAX_PRINTED = 300  # bytes of what a library prints
BYTES_PER_SECOND = 4 << 20  # a tenth of what the slowest format reads

_worker: subprocess.Popen[str] | None = None
_owner = os.getpid()
_is_child = False  # whether this is the second process
_one_at_a_time = threading.Lock()


def try_in_child(module: str, name: str, path: Path) -> None:
    """Check that an animation can be opened and its frames be read, in a second process.

    A frame that is refused with `FileFormatError` is no failure here; it is refused again when it
    is read.

    Args:
        module: Full name of a module.
        name: Its class, whose argument is the path.
        path: The file.

    Raises:
        FileFormatError: It cannot be opened; or the process died, or took too long or too much
            memory.
    """
    if _is_child:
        return
    seconds = SECONDS + os.path.getsize(path) / BYTES_PER_SECOND
    with _one_at_a_time:
        answer = _ask([module, name, os.fspath(path)], seconds)
        if answer is None or not answer:
            _stop()
    if answer is None:
        raise FileFormatError(f"{path}: is not read within {seconds:.0f} s; it is damaged")
    if not answer:
        raise FileFormatError(f"{path}: the library that reads it crashes on it; it is damaged")
    message = json.loads(answer)
    if message is not None:
        raise FileFormatError(message)


def raise_limit() -> None:
    """Allow all memory, for a file that names other files, whose sizes are not known yet."""
    if _is_child:
        _limit(None)


def _ask(question: list[str], seconds: float) -> str | None:
    """Return the answer of the second process; None if it takes too long, empty if it died."""
    worker = _running()
    assert worker.stdin is not None
    assert worker.stdout is not None
    try:
        worker.stdin.write(json.dumps(question) + "\n")
        worker.stdin.flush()
    except OSError:  # a broken pipe
        return ""
    ready, _, _ = select.select([worker.stdout], [], [], seconds)
    return worker.stdout.readline() if ready else None


def _running() -> subprocess.Popen[str]:
    global _worker, _owner
    if _owner != os.getpid():  # a fork has the pipes of its parent
        _worker, _owner = None, os.getpid()
    if _worker is None or _worker.poll() is not None:
        _stop()
        _worker = subprocess.Popen(
            [sys.executable, "-P", "-W", "ignore", "-m", "izo_ref.formats.trial"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
        )
    return _worker


@atexit.register
def _stop() -> None:
    global _worker
    if _worker is None or _owner != os.getpid():
        return
    with suppress(OSError):
        _worker.kill()
    _worker.wait()
    for pipe in (_worker.stdin, _worker.stdout):
        with suppress(OSError):
            if pipe is not None:
                pipe.close()
    _worker = None


def serve() -> None:
    """Answer what `try_in_child` asks, as the second process."""
    global _is_child
    _is_child = True
    answers = os.fdopen(os.dup(1), "w")
    with tempfile.TemporaryFile() as printed:  # what a library prints says that it is at a loss
        os.dup2(printed.fileno(), 1)
        os.dup2(printed.fileno(), 2)
        for line in sys.stdin:
            module, name, path = json.loads(line)
            reason = _try(module, name, path)
            if printed.seek(0, os.SEEK_END):
                printed.seek(0)
                text = printed.read(MAX_PRINTED).decode("utf-8", "replace").split("\n")[0]
                reason = reason or f"{path}: cannot be read; its library prints {text!r}"
                printed.seek(0)
                printed.truncate()
            answers.write(json.dumps(reason) + "\n")
            answers.flush()


def _try(module: str, name: str, path: str) -> str | None:
    """Return why a file cannot be opened, or None."""
    try:
        _limit(OWN_MEMORY + PER_BYTE * os.path.getsize(path))
        animation: Any = getattr(import_module(module), name)(path)
        for number in range(animation.n_frames):
            with suppress(FileFormatError):
                animation.frame(number)
    except FileFormatError as error:
        return str(error)
    except MemoryError:
        return f"{path}: reading it takes more memory than its size allows; it is damaged"
    except Exception as error:  # whatever a library raises on damaged bytes
        return f"{path}: cannot be read: {type(error).__name__}"
    finally:
        _limit(None)
    return None


def _limit(n_bytes: int | None) -> None:
    if resource is not None:
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        soft = hard if n_bytes is None else n_bytes
        if hard != resource.RLIM_INFINITY:
            soft = min(soft, hard)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


if __name__ == "__main__":  # the module that the formats import is another copy of this one
    import_module("izo_ref.formats.trial").serve()
