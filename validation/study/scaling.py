"""Time and memory against triangles, and against impacts of one zone."""

import json
import os
import subprocess
import sys
import threading
from pathlib import Path

from validation.rows import Rows
from validation.study import steps

KEYS = ("family", "size")
ROOT = Path(__file__).parent.parent.parent
THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
FULL = {
    "sheets": (1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000),
    "chain": (1, 4, 16, 64, 256, 1024, 4096, 20_000),
    "pinch": (2, 4, 16, 64, 256, 1024, 4096, 20_000),
    # a dense graph, and so the third power of the impacts: 20,000 would take hours
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


def run(rows_folder, quick, say):
    """Add the rows that are missing.

    Args:
        rows_folder: of `scaling.csv`.
        quick: up to 30,000 triangles, and small zones.
        say: called with a line of progress.
    """
    rows = Rows(rows_folder, "scaling", KEYS)
    limit = QUICK_LIMIT_S if quick else FULL_LIMIT_S
    for family, sizes in plan(quick).items():
        missing = [size for size in sizes if not rows.has(family=family, size=size)]
        if missing:
            for row in measured(family, missing, limit):
                rows.add(family=family, threads=1, **row)
                say(f"scaling: {family} {row['size']}: {row['outcome']}, {row.get('total_s')} s")


def plan(quick) -> dict:
    """{family: sizes}, rising."""
    if quick:
        return QUICK
    recorded = {name: (size,) for name, size in RECORDED.items()}
    return FULL | (recorded if steps.available() else {})


def measured(family, sizes, limit_s, threads=1):
    """A row for each size, whatever the process does: one that dies leaves failures.

    One thread, of BLAS too, unless more are asked for: a second one changes times by what else
    the machine does.
    """
    command = [sys.executable, "-m", "validation.study.growth", family, *map(str, sizes)]
    process = subprocess.Popen(
        command,
        cwd=ROOT,
        env=os.environ | dict.fromkeys(THREADS, str(threads)),
        stdout=subprocess.PIPE,
        text=True,
    )
    late, left = [], list(sizes)
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


def _next_line(process, limit_s, late):
    """What the process prints next; it is stopped if that takes longer."""

    def stop():
        late.append(limit_s)
        process.kill()

    timer = threading.Timer(limit_s, stop)
    timer.start()
    try:
        return process.stdout.readline()
    finally:
        timer.cancel()
