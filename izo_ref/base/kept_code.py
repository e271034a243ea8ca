"""Compiled code on disk, in place of numba's files, which trust whatever is in them.

numba loads pickles with machine code. It does not look at who wrote them or whether they are whole.
With one wrong bit in each file, 9 of 25 runs ended by a signal and 16 by a traceback. If the folder
cannot be written, numba takes other folders, whose code may be that of earlier sources. Here

* files are loaded only from a folder that belongs to the user (`own_folder.py`);
* each file begins with the SHA-256 of its name and its content; a file that is damaged counts as
  missing, and its code is compiled again;
* a file that cannot be written is a line on the standard error, once, and no error.

The digest takes 0.03 ms a file, of 40 kB on average. It says that a file is whole, not who wrote
it: that is what the folder is for.
"""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import stat
import sys
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from izo_ref.base.own_folder import ROOT, make_own, others_can_write, why_unsafe
from izo_ref.base.whole_files import BINARY, replace_whole

DIGEST = hashlib.sha256().digest_size
# It is in the names of the files with compiled code that this process writes.
_PROCESS = uuid.uuid4().hex[:12]
_said: set[str] = set()


def say_once(text: str) -> None:
    """Write a line to the standard error, unless this process did so before."""
    if text not in _said:
        _said.add(text)
        with suppress(OSError, ValueError, AttributeError):  # it may be closed
            sys.stderr.write(f"izo_ref: {text}\n")


class Place:
    """Says to numba where the code of a function is kept, without the folders that numba tries.

    Args:
        folder: Folder of all compiled code.
        file: File of the function's source; None before it is known.
        line: Line of the function in it.
    """

    def __init__(self, folder: Path, file: str | None = None, line: int = 0) -> None:
        """Keep the arguments."""
        self._folder, self._file, self._line = folder, file, line

    def from_function(self, function: Any, file: str) -> Place:
        """Return the place of a function; numba calls it."""
        return Place(self._folder, file, function.__code__.co_firstlineno)

    def get_cache_path(self) -> str:
        """Return the folder: functions of one folder of sources are together."""
        above = Path(os.path.abspath(str(self._file))).parent
        digest = hashlib.sha256(str(above).encode()).hexdigest()[:40]
        return str(self._folder / f"{above.name}_{digest}")

    def get_source_stamp(self) -> bytes:
        """Return a digest of the file; code of another digest is not loaded."""
        return _digest_of_file(str(self._file))

    def get_disambiguator(self) -> str:
        """Return what tells functions of the same name apart."""
        return str(self._line)

    def ensure_cache_path(self) -> None:
        """Do nothing: `CodeFiles` creates the folder."""


@functools.cache
def _digest_of_file(file: str) -> bytes:
    return hashlib.sha256(Path(file).read_bytes()).digest()


class CodeFiles:
    """The files of one function: an index of its signatures, and the code of each of them.

    The interface is that of numba's `IndexDataCacheFile`.

    Two processes may save two signatures of one function at the same moment. Names of files are
    those of the process, so that neither writes into the file of the other. At most one entry of
    the index is lost, and that signature is compiled again.

    Args:
        folder: The folder of the files.
        name: How their names begin.
        stamp: Digest of the source; code with another one is not loaded.
        dumps: Function that makes bytes of an object.
    """

    def __init__(self, folder: str, name: str, stamp: bytes, dumps: Callable[[Any], bytes]) -> None:
        """Keep the arguments; nothing is read or written yet."""
        self._folder, self._stamp, self._dumps = Path(folder), stamp, dumps
        self._index = f"{name}.nbi"
        self._data = f"{name}.{_PROCESS}-{{number}}.nbc"

    def flush(self) -> None:
        """Forget all code of the function."""
        self._save(self._index, (self._stamp, {}))

    def load(self, key: Any) -> Any:
        """Return the code of a signature; None if there is none that is whole and the user's."""
        reason = why_unsafe(self._folder)
        if reason is not None:
            say_not_kept(reason)
            return None
        name = self._names().get(key)
        return None if name is None else self._load(name)

    def save(self, key: Any, code: Any) -> None:
        """Keep the code of a signature; a line on the standard error says it if that fails."""
        try:
            make_own(self._folder)
            names = self._names()
            known = set(names.values())
            free = (n for n in map(self._numbered, range(1, len(known) + 2)) if n not in known)
            name = names.setdefault(key, next(free))
            self._save(name, code)
            self._save(self._index, (self._stamp, names))
        except OSError as error:
            say_not_kept(str(error))

    def _numbered(self, number: int) -> str:
        return self._data.format(number=number)

    def _names(self) -> dict[Any, str]:
        """Return the names of the files of all signatures."""
        content = self._load(self._index)
        if not isinstance(content, tuple) or content[0] != self._stamp:
            return {}
        return content[1]

    def _load(self, name: str) -> Any:
        content = read_whole(self._folder / name)
        if content is None:
            return None
        try:
            return pickle.loads(content)
        except MemoryError:
            raise
        except Exception:  # whole, but of a class that is no longer there
            return None

    def _save(self, name: str, content: Any) -> None:
        data = self._dumps(content)
        replace_whole(self._folder / name, _digest(name, data) + data, mode=0o600)


def say_not_kept(reason: str) -> None:
    """Say once that compiled code is not kept on disk, and why."""
    say_once(
        f"compiled code is not kept, so it is compiled again at each start: {reason}; "
        "XDG_CACHE_HOME can name another folder, which has to be yours alone"
    )


def read_whole(path: Path) -> bytes | None:
    """Read a file of compiled code.

    Returns:
        Its content without the digest; None if there is no such file, if it is damaged, or if
        another user could have written it.
    """
    flags = os.O_RDONLY | BINARY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    try:
        with os.fdopen(os.open(path, flags), "rb") as file:
            if not _is_own(os.fstat(file.fileno()), path):
                return None
            content = file.read()
    except OSError:
        return None
    digest, content = content[:DIGEST], content[DIGEST:]
    return content if digest == _digest(path.name, content) else None


def _is_own(found: os.stat_result, path: Path) -> bool:
    """Return whether a file is one of the user or of root, which nobody else can write to."""
    if not stat.S_ISREG(found.st_mode):
        return False
    if not hasattr(os, "geteuid"):
        return True
    return found.st_uid in (ROOT, os.geteuid()) and not others_can_write(found, path)


def _digest(name: str, content: bytes) -> bytes:
    """Return the digest of a file; with its name, so that no file stands for another one."""
    digest = hashlib.sha256(name.encode() + b"\0")
    digest.update(content)
    return digest.digest()
