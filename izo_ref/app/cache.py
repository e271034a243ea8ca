"""Compiled code on the disk: show it, clear it, and fill it with several processes."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from izo_ref.base.compile import CACHE_FOLDER, anything_compiled, why_not_kept
from izo_ref.base.errors import CacheFolderError, OptionError
from izo_ref.loop.resolve import resolve
from izo_ref.scene import Scene
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.problem import ZoneProblem

LARGE_IMPACTS = 300  # impacts of a zone: more than a small zone has


class CacheFolder(NamedTuple):
    """Compiled code of one version of the sources.

    Attributes:
        path: The folder.
        current: Whether it belongs to the sources and versions that run now.
        files: Number of files.
        bytes: Size of all files [bytes].
    """

    path: Path
    current: bool
    files: int
    bytes: int


def folders() -> list[CacheFolder]:
    """Return all folders of compiled code, the current one first."""
    found = [CACHE_FOLDER] if CACHE_FOLDER.is_dir() else []
    if CACHE_FOLDER.parent.is_dir():
        found += sorted(p for p in CACHE_FOLDER.parent.iterdir() if p.is_dir() and p not in found)
    return [_folder(path) for path in found]


def _folder(path: Path) -> CacheFolder:
    sizes = []
    for file in path.rglob("*"):
        with suppress(FileNotFoundError):  # another process deletes or replaces it
            if file.is_file():
                sizes.append(file.stat().st_size)
    return CacheFolder(path, path == CACHE_FOLDER, len(sizes), sum(sizes))


def clear(only_old: bool = False) -> list[CacheFolder]:
    """Delete compiled code, and return the folders that were deleted.

    Args:
        only_old: Whether to keep the code of the sources and versions that run now.
    """
    found = [folder for folder in folders() if not (only_old and folder.current)]
    for folder in found:
        shutil.rmtree(folder.path)
    return found


def _detection() -> None:
    _tetrahedra_scene()


def _small_zones() -> None:
    solve_zone(_chain(3))


def _large_zones() -> None:
    solve_zone(_chain(LARGE_IMPACTS))
    solve_zone(_chain(LARGE_IMPACTS), "interior-point")


def _rest() -> None:
    resolve(_tetrahedra_scene(), 1e-3)


# Functions that are compiled together, each group by its own process, the largest group first.
# `rest` is all that a step with small zones calls: it uses what the other groups compiled, and adds
# the little that is left.
TASKS = {
    "large-zones": _large_zones,
    "small-zones": _small_zones,
    "detection": _detection,
    "rest": _rest,
}


def fill(names: Iterable[str], say: Callable[[str], object]) -> None:
    """Compile for some tasks, as many at a time as there are CPU cores, `rest` last.

    Args:
        names: Names of `TASKS`.
        say: Function that is called with a line as each task ends.

    Raises:
        OptionError: A name is unknown.
        CacheFolderError: What is compiled would not be kept, or a process failed.
    """
    reason = why_not_kept()
    if reason is not None:
        raise CacheFolderError(f"{CACHE_FOLDER}: what is compiled would not be kept: {reason}")
    names = list(names)
    unknown = [name for name in names if name not in TASKS]
    if unknown:
        raise OptionError(f"cache: expected tasks of {tuple(TASKS)}, got {unknown[0]!r}")
    waiting = [name for name in TASKS if name in names]
    running = {}
    while waiting or running:
        while waiting and len(running) < (os.cpu_count() or 1):
            if waiting[0] == "rest" and running:
                break
            name = waiting.pop(0)
            running[name] = _start(name), time.perf_counter()
        for name, (process, begin) in list(running.items()):
            if process.poll() is not None:
                del running[name]
                if process.returncode != 0:
                    _end(other for other, _ in running.values())
                    raise CacheFolderError(
                        f"cache: compiling for {name} ended with exit code {process.returncode}"
                    )
                say(f"{name}: {time.perf_counter() - begin:.1f} s")
        time.sleep(0.05)


def run_task(name: str) -> None:
    """Compile for one task of `TASKS` in this process."""
    TASKS[name]()


def compile_everything() -> None:
    """Compile what any step calls in two processes, if there is no compiled code yet."""
    if not anything_compiled():
        with compiling_beside("large-zones"):
            run_task("rest")


@contextmanager
def compiling_beside(name: str) -> Iterator[None]:
    """Let another process compile for a task while a block runs.

    This happens only if there is no compiled code yet. The block is meant to compile something
    else, which takes as long. When the block ends, the other process is waited for.

    Args:
        name: One of `TASKS`.
    """
    if anything_compiled() or why_not_kept() is not None or (os.cpu_count() or 1) < 2:
        yield
        return
    process = None
    with suppress(OSError):  # too little memory for another process: this one compiles it later
        process = _start(name)
    if process is None:
        yield
        return
    try:
        yield
        process.wait()
    finally:
        _end([process])


def _end(processes: Iterable[subprocess.Popen[bytes]]) -> None:
    """End processes that still run."""
    for process in processes:
        if process.poll() is None:
            process.kill()
            process.wait()


def _start(name: str) -> subprocess.Popen[bytes]:
    code = f"from izo_ref.app.cache import run_task; run_task({name!r})"
    return subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.DEVNULL)


def _tetrahedra_scene() -> Scene:
    """Return two tetrahedra, one driven into the other; a corner of the lower one is pinned."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    start = np.vstack((corners, corners * (1, 1, -1) + (0.1, 0.1, 2.5)))
    end = start.copy()
    end[4:, 2] -= 1.5
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    pinned = np.arange(8) == 1
    return Scene(start, end, np.vstack((faces, faces + 4)), None, pinned)


def _chain(n: int) -> ZoneProblem:
    """Return a zone of n impacts, each of which shares two vertices with the next."""
    nodes = np.arange(n)[:, None] * 2 + np.arange(4)
    weights = np.tile([0.5, 0.5, -0.5, -0.5], (n, 1))
    normals = np.tile([0.0, 0.0, 1.0], (n, 1))
    proposed = np.zeros((2 * n + 2, 3))
    proposed[:, 2] = np.sin(np.arange(2 * n + 2))
    return ZoneProblem(
        nodes.astype(np.int32), weights, normals, proposed, np.ones(len(proposed)), 1e-3
    )
