"""Compiled code on the disk: show it, clear it, fill it by several processes."""

import os
import shutil
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from izo_ref.base.compile import CACHE_FOLDER, anything_compiled
from izo_ref.base.errors import OptionError
from izo_ref.loop.resolve import resolve
from izo_ref.scene import Scene
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.problem import ZoneProblem

LARGE_IMPACTS = 300  # impacts: more than a small zone has
PARALLEL_IMPACTS = 150  # impacts: work for all threads, in a small zone


class CacheFolder(NamedTuple):
    """Compiled code of one version of the sources."""

    path: Path
    current: bool  # of the sources that run now
    files: int
    bytes: int


def folders() -> list[CacheFolder]:
    """Those there are, the current one first."""
    found = [CACHE_FOLDER] if CACHE_FOLDER.is_dir() else []
    if CACHE_FOLDER.parent.is_dir():
        found += sorted(p for p in CACHE_FOLDER.parent.iterdir() if p.is_dir() and p not in found)
    return [_folder(path) for path in found]


def _folder(path):
    sizes = [file.stat().st_size for file in path.rglob("*") if file.is_file()]
    return CacheFolder(path, path == CACHE_FOLDER, len(sizes), sum(sizes))


def clear(only_old: bool = False) -> list[CacheFolder]:
    """Delete compiled code, or only that of other versions; returns what was deleted."""
    found = [folder for folder in folders() if not (only_old and folder.current)]
    for folder in found:
        shutil.rmtree(folder.path)
    return found


def _detection():
    _tetrahedra_scene()


def _small_zones():
    solve_zone(_chain(3))


def _large_zones():
    solve_zone(_chain(LARGE_IMPACTS))
    solve_zone(_chain(LARGE_IMPACTS), "interior-point")


def _rest():
    solve_zone(_chain(PARALLEL_IMPACTS))
    resolve(_tetrahedra_scene(), 1e-3)


# What is compiled for together, each by a process of its own; `rest` takes what the others
# made and adds the little that is left.
TASKS = {
    "detection": _detection,
    "small-zones": _small_zones,
    "large-zones": _large_zones,
    "rest": _rest,
}


def fill(names, say):
    """Compile for these tasks, as many at a time as there are processors, `rest` last.

    Args:
        names: of `TASKS`.
        say: called with a line as each ends.

    Raises:
        OptionError: an unknown name. RuntimeError: a process failed.
    """
    unknown = [name for name in names if name not in TASKS]
    if unknown:
        raise OptionError(f"cache: expected names of {tuple(TASKS)}, got {unknown[0]!r}")
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
                    raise RuntimeError(f"cache: compiling for {name} ended with an error")
                say(f"{name}: {time.perf_counter() - begin:.1f} s")
        time.sleep(0.05)


def run_task(name):
    """Compile for one task, in this process."""
    TASKS[name]()


@contextmanager
def compiling_beside():
    """While the block runs, solvers of few small zones are compiled by another process, if
    there is no compiled code yet: detection takes as long. The block is followed by waiting for it.
    """
    if anything_compiled() or (os.cpu_count() or 1) < 2:
        yield
        return
    process = _start("small-zones")
    try:
        yield
        process.wait()
    finally:
        if process.poll() is None:
            process.kill()


def _start(name):
    code = f"from izo_ref.app.cache import run_task; run_task({name!r})"
    return subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.DEVNULL)


def _tetrahedra_scene():
    """Two of them, one driven into the other; a corner of the lower one is pinned."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    start = np.vstack((corners, corners * (1, 1, -1) + (0.1, 0.1, 2.5)))
    end = start.copy()
    end[4:, 2] -= 1.5
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    pinned = np.arange(8) == 1
    return Scene(start, end, np.vstack((faces, faces + 4)), None, pinned)


def _chain(n) -> ZoneProblem:
    """n impacts, each sharing two vertices with the next."""
    nodes = np.arange(n)[:, None] * 2 + np.arange(4)
    weights = np.tile([0.5, 0.5, -0.5, -0.5], (n, 1))
    normals = np.tile([0.0, 0.0, 1.0], (n, 1))
    proposed = np.zeros((2 * n + 2, 3))
    proposed[:, 2] = np.sin(np.arange(2 * n + 2))
    return ZoneProblem(
        nodes.astype(np.int32), weights, normals, proposed, np.ones(len(proposed)), 1e-3
    )
