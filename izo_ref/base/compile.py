"""The only place with compile options.

Two decorators: `compiled` for `scalar/` and `serial/` (one thread, callable from
every target) and `cpu_kernel` for `cpu/` (parallel over `prange`).

* `fastmath` is off: it drops NaN checks and re-orders sums, and the rounding bounds of
  `scalar/` are proved for the order that is written.
* `error_model="numpy"`: x / 0.0 is inf or NaN, on every target, instead of an exception.
* Compiled code is kept on disk. numba's cache does not see edits in imported files, so
  the folder is named by a digest of all sources of the package and of the versions.
"""

import functools
import hashlib
import os
import platform
import threading
from contextlib import contextmanager
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba import njit
from numba.core import config

# numba's `workqueue` threading layer must not be entered by two threads at once, and
# which layer is found depends on the machine. Kernels use every core anyway, so one at a
# time loses nothing.
_LAUNCH = threading.RLock()


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
def setting(config, name, value):
    """A setting of numba for as long as the block runs."""
    before = getattr(config, name)
    setattr(config, name, value)
    try:
        yield
    finally:
        setattr(config, name, before)


CACHE_FOLDER = _cache_folder()


def anything_compiled() -> bool:
    """Whether there is compiled code of these sources; numba makes the folder beforehand."""
    return next(CACHE_FOLDER.rglob("*.nbi"), None) is not None


def _njit(function, folder=CACHE_FOLDER, **options):
    # numba reads the folder when a function is decorated
    with setting(config, "CACHE_DIR", str(folder)):
        return njit(
            cache=True,
            error_model="numpy",
            fastmath=False,
            nogil=True,
            no_cfunc_wrapper=True,  # a tenth of the compile time, and nobody calls from C
            **options,
        )(function)


def compiled(function):
    """Compile for one thread; `scalar/` and `serial/` use nothing else."""
    return _njit(function)


def inlined(function):
    """The same, put where it is called: for what takes less time than a call."""
    return _njit(function, forceinline=True)


def _kernel(function, **options):
    kernel = _njit(function, **options)

    @functools.wraps(function)
    def launch(*arrays):
        with _LAUNCH:
            return kernel(*arrays)

    return launch


def cpu_kernel(function):
    """Compile a kernel over `prange`; launches are serialised over Python threads.

    Its `.alone` is the same loop on one thread, compiled for itself: waking the others takes
    microseconds, and on a busy machine milliseconds. A scene with little to do needs no other,
    and a loop over threads takes several times as long to compile.
    """
    launch = _kernel(function, parallel=True)
    # numba's cache tells functions apart by name and signature, not by options
    launch.alone = _kernel(function, folder=CACHE_FOLDER / "alone")
    return launch


def light_kernel(function):
    """A kernel whose `prange` is a plain loop: it has so little to do that threads gain
    less than they take to compile, which is twice as long."""
    return _kernel(function)
