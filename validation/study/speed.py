"""Study of speed: how fast izo_ref is, and how much time each rule of the plan saves.

It times detection beside ipctk, whole steps by stage beside recorded times of ARCSim, deep contact,
the next step of a simulation, the loop with each rule switched off, new processes, and sheets of up
to a million triangles. Both sides of a ratio are measured in the same run, in turn; only the times
of ARCSim were recorded on another machine, and LBVH says how fast that was. `python -m validation
study speed` starts it.
"""

import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref import Options, resolve
from izo_ref.base.options import RULES
from validation.rows import Rows
from validation.study import scaling, steps
from validation.study.parts import Part, Say
from validation.study.speed_detection import detection
from validation.study.speed_steps import (
    ENOUGH_S,
    THICKNESS_M,
    deep,
    following,
    steps_of_arcsim,
    whole,
)
from validation.study.timing import REPEATS, in_turn, spread, thread_counts

SMALL_STEP = "ipctd-thick-cloth"
SIZES = (10_000, 30_000, 100_000, 300_000, 1_000_000)


def _ablation(folder: Path, say: Say) -> None:
    """Time whole steps with each rule of the plan switched off alone, in turn with all rules on."""
    rows = Rows(folder, "ablation", ("step", "left_out"))
    for step in steps_of_arcsim():
        if rows.has(step=step, left_out="closed-form"):
            continue
        scene = steps.load_step(step)
        plans: dict[str, Any] = {"": "needed", "everything": "everything"}
        plans |= {rule: tuple(r for r in RULES if r != rule) for rule in RULES}
        begin = time.perf_counter()
        resolve(scene, THICKNESS_M)
        once = time.perf_counter() - begin
        repeats = max(1, min(REPEATS, int(ENOUGH_S / (len(plans) * max(once, 1e-3)))))
        calls = {
            name: partial(resolve, scene, THICKNESS_M, options=Options(plan=plan))
            for name, plan in plans.items()
        }
        peaks, pairs = {}, {}
        for name, call in calls.items():
            tracemalloc.start()
            pairs[name] = sum(line.candidates for line in call().history)
            peaks[name] = tracemalloc.get_traced_memory()[1] / 2**20
            tracemalloc.stop()
        seconds = in_turn(calls, repeats)
        with_all = np.median(seconds[""])
        for name in calls:
            rows.add(
                step=step,
                left_out=name or "nothing",
                **spread(seconds[name]),
                ratio=float(np.median(seconds[name]) / with_all),
                arrays_mib=peaks[name],
                pairs=pairs[name],
            )
        say(f"ablation: {step}, {repeats} runs each")


def _cold(folder: Path, say: Say) -> None:
    """Time new processes: with nothing compiled, and with the compiled code on the disk."""
    rows = Rows(folder, "cold", ("what",))
    step = steps.FOLDER / f"{SMALL_STEP}.npz"
    run = [sys.executable, "-m", "izo_ref.app.cli", "resolve", str(step), "-o"]
    with tempfile.TemporaryDirectory() as cache:
        # an installed package has its bytecode on the disk, so the new processes may write theirs
        env = os.environ | {"XDG_CACHE_HOME": cache, "PYTHONDONTWRITEBYTECODE": ""}
        out = os.path.join(cache, "out.npz")
        calls = {
            "python": ([sys.executable, "-c", "pass"], REPEATS),
            "import izo_ref": ([sys.executable, "-c", "import izo_ref"], REPEATS),
            f"first izo resolve, {SMALL_STEP}": ([*run, out], 1),
            f"izo resolve in a new process, {SMALL_STEP}": ([*run, out], REPEATS),
        }
        if all(rows.has(what=what) for what in calls):
            return
        for what, (command, repeats) in calls.items():
            seconds = []
            for k in range(repeats + (repeats > 1)):
                begin = time.perf_counter()
                subprocess.run(command, env=env, check=True, capture_output=True)
                if k or repeats == 1:
                    seconds.append(time.perf_counter() - begin)
            rows.add(what=what, **spread(seconds))
            say(f"cold: {what}: {np.median(seconds):.2f} s")


def _scale(folder: Path, say: Say) -> None:
    """Time sheets of up to a million triangles, on one thread and on two."""
    rows = Rows(folder, "scale", ("size", "threads"))
    for count in thread_counts():
        missing = [size for size in SIZES if not rows.has(size=size, threads=count)]
        for row in scaling.measured("sheets", missing, scaling.FULL_LIMIT_S, count):
            rows.add(threads=count, **row)
            say(f"scale: {row['size']}, {count} threads: {row.get('total_s')} s")


PARTS: dict[str, Part] = {
    "detection": detection,
    "resolve": whole,
    "deep": deep,
    "next": following,
    "ablation": _ablation,
    "cold": _cold,
    "scale": _scale,
}
