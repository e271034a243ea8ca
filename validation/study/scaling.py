"""Study of scaling: time and memory against the triangles of a step, or the impacts of a zone.

Each family is measured by `growth.py` in a process of its own, so that a process that dies or takes
too long leaves a row that says so. It is one of the studies of `python -m validation report`.
"""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from validation.rows import Rows
from validation.study import steps
from validation.study.parts import Say

KEYS = ("family", "size")
ROOT = Path(__file__).parent.parent.parent
THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
FULL = {
    "sheets": (1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000),
    "chain": (1, 4, 16, 64, 256, 1024, 4096, 20_000),
    "pinch": (2, 4, 16, 64, 256, 1024, 4096, 20_000),
    # its graph is dense, so the time grows with n^3: 20,000 impacts would take hours
    "random": (1, 4, 16, 64, 256, 1024, 4096),
}
QUICK = {
    "sheets": (1_000, 3_000, 10_000, 30_000),
    "chain": (1, 16, 256, 4096),
    "random": (1, 16, 256),
}
RECORDED = {"zone-armadillo-first": 23_958, "zone-armadillo-last": 43_036}
FULL_LIMIT_S, QUICK_LIMIT_S = 900.0, 60.0
COMPILE_LIMIT_S = 900.0


def run(rows_folder: Path, quick: bool, say: Say) -> None:
    """Add the rows that are missing.

    Args:
        rows_folder: Folder of `scaling.csv`.
        quick: Measure up to 30,000 triangles, and small zones.
        say: Is called with a line of text as the work goes on.
    """
    rows = Rows(rows_folder, "scaling", KEYS)
    limit = QUICK_LIMIT_S if quick else FULL_LIMIT_S
    for family, sizes in plan(quick).items():
        missing = [size for size in sizes if not rows.has(family=family, size=size)]
        if missing:
            for row in measured(family, missing, limit):
                rows.add(family=family, threads=1, **row)
                say(f"scaling: {family} {row['size']}: {row['outcome']}, {row.get('total_s')} s")


def plan(quick: bool) -> Mapping[str, tuple[int, ...]]:
    """Return `{family: sizes}`, with rising sizes."""
    if quick:
        return QUICK
    recorded = {name: (size,) for name, size in RECORDED.items()}
    return FULL | (recorded if steps.available() else {})


def measured(
    family: str, sizes: Sequence[int], limit_s: float, threads: int = 1
) -> Iterator[dict[str, Any]]:
    """Measure the cases of a family in another process.

    By default the process has one thread, also for BLAS. With two, the times would depend on what
    else the machine does.

    Args:
        family: Name of the family.
        sizes: Sizes in rising order.
        limit_s: Seconds for each case, after which the process is stopped.
        threads: Number of threads of the process.

    Yields:
        A row for each size. If the process dies or is stopped, the remaining rows are failures.
    """
    command = [sys.executable, "-m", "validation.study.growth", family, *map(str, sizes)]
    process = subprocess.Popen(
        command,
        cwd=ROOT,
        env=os.environ | dict.fromkeys(THREADS, str(threads)),
        stdout=subprocess.PIPE,
        text=True,
    )
    late: list[float] = []  # the limit that was exceeded, if one was
    left = list(sizes)
    with process:
        limits = [COMPILE_LIMIT_S] + [limit_s] * len(sizes)
        for limit in limits:
            line = _next_line(process, limit, late)
            if not line:
                break
            row = json.loads(line)
            if "size" in row:
                left.remove(row["size"])
                yield row
    for size in left:
        message = f"stopped at {left[0]} after {late[0]:g} s" if late else "the process died"
        yield {"size": size, "outcome": "failed", "message": message}


def _next_line(process: subprocess.Popen[str], limit_s: float, late: list[float]) -> str:
    """Return the next line that the process prints; stop it if that takes longer than the limit."""
    assert process.stdout is not None

    def stop() -> None:
        late.append(limit_s)
        process.kill()

    timer = threading.Timer(limit_s, stop)
    timer.start()
    try:
        return process.stdout.readline()
    finally:
        timer.cancel()
