"""The only place with compile options.

`compiled` and `inlined` are for `formulas/` and `serial/`: one thread, callable from every target.
`cpu_kernel` and `light_kernel` are for `cpu/`.

* `fastmath` is off. It would drop the checks for NaN and re-order sums, and the rounding bounds of
  `formulas/` are proved for the written order.
* `error_model="numpy"`: x / 0.0 is inf or NaN on every target, instead of an exception.
* Compiled code is kept on disk. numba's cache does not see edits in imported files, so the name of
  the folder is a digest of all sources of the package and of the versions.
"""

from __future__ import annotations

import functools
import hashlib
import os
import platform
import threading
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol, TypeVar, cast

import llvmlite
import numba
import numpy as np
from numba import njit
from numba.core import config

Function = TypeVar("Function", bound=Callable[..., Any])

# numba's `workqueue` threading layer must not be entered by two threads at once, and the layer
# that is used depends on the machine. A kernel uses every core anyway, so launching one at a time
# loses nothing.
_LAUNCH = threading.RLock()

# It is in the names of the files with compiled code that this process writes.
_PROCESS = uuid.uuid4().hex[:12]


class CpuKernel(Protocol):
    """A kernel of the CPU.

    Attributes:
        alone: The same loop on one thread.
    """

    alone: Callable[..., None]

    def __call__(self, *arguments: Any) -> None:
        """Run the kernel on all threads."""
        ...


def _cache_folder() -> Path:
    digest = hashlib.sha256()
    versions = (platform.python_version(), numba.__version__, llvmlite.__version__, np.__version__)
    digest.update(repr(versions).encode())
    package = Path(__file__).parents[1]
    for source in sorted(package.rglob("*.py")):
        digest.update(str(source.relative_to(package)).encode() + b"\0" + source.read_bytes())
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "izo_ref" / digest.hexdigest()[:16]


@contextmanager
def setting(config: Any, name: str, value: Any) -> Iterator[None]:
    """Change a setting of numba while a block runs.

    Args:
        config: `numba.core.config`, or that of numba-cuda.
        name: The setting.
        value: Its value in the block.
    """
    before = getattr(config, name)
    setattr(config, name, value)
    try:
        yield
    finally:
        setattr(config, name, before)


CACHE_FOLDER = _cache_folder()


def anything_compiled() -> bool:
    """Return whether the cache has compiled code of these sources."""
    # numba makes the folder before it compiles, so the folder alone says nothing
    return next(CACHE_FOLDER.rglob("*.nbi"), None) is not None


def _njit(function: Function, folder: Path = CACHE_FOLDER, **options: Any) -> Function:
    # numba reads the folder when a function is decorated
    with setting(config, "CACHE_DIR", str(folder)):
        dispatcher = njit(
            cache=True,
            error_model="numpy",
            fastmath=False,
            nogil=True,
            no_cfunc_wrapper=True,  # saves a tenth of the compile time; no C code calls these
            **options,
        )(function)
    if not config.DISABLE_JIT:
        name_files_by_process(dispatcher)
    return dispatcher


def name_files_by_process(dispatcher: Any) -> None:
    """Give the files with compiled code names that no other process uses.

    numba numbers these files by the index of the function. Two processes that save two signatures
    of one function at the same moment would write the same file, and its code would later be loaded
    for the wrong signature. With names of their own, at most one entry of the index is lost, and
    that signature is compiled again. numba-cuda numbers its files in the same way.

    Args:
        dispatcher: The compiled function, of numba or of numba-cuda.
    """
    files = dispatcher._cache._cache_file
    files._data_name_pattern = files._data_name_pattern.replace("{number", _PROCESS + "-{number")


def compiled(function: Function) -> Function:
    """Compile a function of `formulas/` or `serial/` for one thread."""
    return _njit(function)


def inlined(function: Function) -> Function:
    """Compile a function that takes less time than a call, and put it where it is called."""
    return _njit(function, forceinline=True)


def _kernel(function: Callable[..., None], **options: Any) -> Callable[..., None]:
    kernel = _njit(function, **options)

    @functools.wraps(function)
    def launch(*arguments: Any) -> None:
        with _LAUNCH:
            return kernel(*arguments)

    return launch


def cpu_kernel(function: Callable[..., None]) -> CpuKernel:
    """Compile a kernel over `prange`; one launch runs at a time.

    Its `.alone` is the same loop on one thread, compiled separately. Waking the other threads takes
    microseconds, and milliseconds on a busy machine. A scene with little work needs only `.alone`,
    which compiles several times as fast.
    """
    launch = cast(CpuKernel, _kernel(function, parallel=True))
    # numba's cache tells functions apart by name and signature, and not by options
    launch.alone = _kernel(function, folder=CACHE_FOLDER / "alone")
    return launch


def light_kernel(function: Callable[..., None]) -> Callable[..., None]:
    """Compile a kernel whose `prange` is a plain loop.

    It does so little work that threads would gain less than their compile time costs, which is
    twice as long.
    """
    return _kernel(function)
