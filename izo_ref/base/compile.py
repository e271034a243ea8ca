"""The only place with compile options.

`compiled` and `inlined` are for `formulas/` and `serial/`: one thread, callable from every target.
`cpu_kernel` and `light_kernel` are for `cpu/`.

* `fastmath` is off. It would drop the checks for NaN and re-order sums, and the rounding bounds of
  `formulas/` are proved for the written order.
* `error_model="numpy"`: x / 0.0 is inf or NaN on every target, instead of an exception.
* Compiled code is kept on disk, if the folder belongs to the user (`kept_code.py`). A file knows
  nothing of edits in files that its source imports. So the name of the folder is a digest of the
  versions and of all sources of the package, except of folders that compiled code never calls.
"""

from __future__ import annotations

import functools
import hashlib
import os
import platform
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import llvmlite
import numba
import numpy as np
from numba.core import config

from izo_ref.base import callees
from izo_ref.base.kept_code import say_not_kept
from izo_ref.base.own_folder import why_unsafe
from izo_ref.base.threads import share

Function = TypeVar("Function", bound=Callable[..., Any])

OPTIONS = {
    "nopython": True,
    "boundscheck": None,
    "error_model": "numpy",
    "fastmath": False,
    "nogil": True,
    "no_cfunc_wrapper": True,  # no C code calls these functions
}

# Nothing that is compiled imports these folders, so their edits leave compiled code as it is.
NEVER_COMPILED = ("app", "porting")


def _cache_folder() -> Path:
    digest = hashlib.sha256()
    versions = (platform.python_version(), numba.__version__, llvmlite.__version__, np.__version__)
    digest.update(repr(versions).encode())
    package = Path(__file__).parents[1]
    for source in sorted(package.rglob("*.py")):
        if source.relative_to(package).parts[0] in NEVER_COMPILED:
            continue
        digest.update(str(source.relative_to(package)).encode() + b"\0" + source.read_bytes())
    return _base() / "izo_ref" / digest.hexdigest()[:16]


def _base() -> Path:
    """Return the folder of all programs' caches."""
    named = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if named.is_absolute():  # other names are to be ignored, the standard of this variable says
        return named
    try:
        return Path.home() / ".cache"
    except RuntimeError:  # a user without a name and a home, in a container
        return Path("/.cache")


CACHE_FOLDER = _cache_folder()


@functools.cache
def why_not_kept() -> str | None:
    """Say why compiled code is neither loaded nor kept; None if it is.

    The folder has to belong to the user, because who writes to it can run code in the name of who
    loads it. `own_folder.py` has the rule.
    """
    return why_unsafe(CACHE_FOLDER)


def anything_compiled() -> bool:
    """Return whether the cache has compiled code of these sources."""
    # numba makes the folder before it compiles, so the folder alone says nothing
    return next(CACHE_FOLDER.rglob("*.nbi"), None) is not None


def _compile(function: Function, **options: Any) -> Function:
    if config.DISABLE_JIT:
        return function
    dispatcher = callees.Function(function, {}, OPTIONS | options)
    dispatcher.prepare = _keep_on_disk  # later, because most functions are never called by Python
    return cast(Function, dispatcher)


def _keep_on_disk(dispatcher: Any) -> None:
    reason = why_not_kept()
    if reason is None:
        dispatcher.keep_in(CACHE_FOLDER)
    else:
        say_not_kept(reason)


def compiled(function: Function) -> Function:
    """Compile a function of `formulas/` or `serial/` for one thread."""
    return _compile(function)


def inlined(function: Function) -> Function:
    """Compile a function that takes less time than a call, and put it where it is called."""
    return _compile(function, forceinline=True)


class Kernel:
    """A kernel of the CPU, whose loop runs from item `begin` to item `end`, its first parameters.

    `kernel(items, ...)` runs it over a range of items on all threads, `kernel.alone(items, ...)` on
    the calling thread. The bits are the same.
    """

    def __init__(self, function: Callable[..., None]) -> None:
        """Prepare a function; it is compiled when it is first launched."""
        self._kernel = _compile(function)
        functools.update_wrapper(self, function)

    def __call__(self, items: range, *arguments: Any) -> None:
        """Run the kernel over some items, shared among all threads."""
        share(self._kernel, items, arguments)

    def where_it_pays(self, least: int, items: range, *arguments: Any) -> None:
        """Run the kernel on all threads if there are `least` items, else on the calling one."""
        (self if len(items) >= least else self.alone)(items, *arguments)

    def alone(self, items: range, *arguments: Any) -> None:
        """Run the kernel over some items on the calling thread."""
        self._kernel(items.start, items.stop, *arguments)


def cpu_kernel(function: Callable[..., None]) -> Kernel:
    """Compile a kernel that threads share; each writes the outputs of its own items."""
    return Kernel(function)


def light_kernel(function: Callable[..., None]) -> Callable[..., None]:
    """Compile a kernel that does so little work that threads would gain nothing."""
    return _compile(function)
