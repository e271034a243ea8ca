"""Study of speed: how fast izo_ref is, and how much time each rule of the plan saves.

It times detection beside ipctk, whole steps by stage beside recorded times of ARCSim, the loop with
each rule switched off, new processes, and sheets of up to a million triangles. Both sides of a
ratio are measured in the same run, in turn. `python -m validation study speed` starts it.
"""

import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Hashable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from izo_ref import Options, find_impacts, resolve
from izo_ref.base.options import RULES
from izo_ref.base.records import Impacts
from izo_ref.loop.resolve import Result
from izo_ref.scene import Scene
from validation.rows import Rows
from validation.study import scaling, steps
from validation.study.parts import Part, Say
from validation.study.timing import thread_counts, threads

THICKNESS_M = 1e-4
REPEATS = 5  # the median of these is taken, after a first run that does not count
ENOUGH_S = 120.0  # after this a cell is not repeated; its row has the number of repeats
# The calls that are timed for a detection.
OWN, LBVH, BOTH = (
    "izo_ref: find_impacts",
    "ipctk: LBVH",
    "ipctk: LBVH and Tight Inclusion",
)
DETECTION_STEPS = ("armadillo-rollers", "cloth-ball-clean", "sheets-50k")
SMALL_STEP = "ipctd-thick-cloth"
SIZES = (10_000, 30_000, 100_000, 300_000, 1_000_000)
STAGES = ("main", "relinearize", "scale_back", "certify", "judge")

Key = TypeVar("Key", bound=Hashable)


def _detection(folder: Path, say: Say) -> None:
    """Time the detection of all impacts of a step, and ipctk's candidates and its step size."""
    rows = Rows(folder, "detection", ("step", "what", "threads"))
    for step in DETECTION_STEPS:
        if rows.has(step=step, what=OWN, threads=1):
            continue
        scene = steps.load_step(step)
        calls = _detection_calls(scene)
        numbers: dict[tuple[str, int], int | None] = {}
        for key, (call, found) in calls.items():
            call()
            numbers[key] = found()
        seconds = _in_turn({key: call for key, (call, _) in calls.items()}, REPEATS)
        for (what, count), own in seconds.items():
            number = numbers[what, count]
            rows.add(step=step, what=what, threads=count, **_spread(own), found=number)
            say(f"detection: {step}, {what}, {count} threads: {np.median(own):.3f} s")


def _detection_calls(
    scene: Scene,
) -> dict[tuple[str, int], tuple[Callable[[], object], Callable[[], int | None]]]:
    """Return `{(what, threads): (call, found)}`; `found()` counts what the call found."""
    import ipctk

    start, end = scene.positions_t0, scene.positions_t1
    mesh = ipctk.CollisionMesh(start, scene.edges, scene.faces)
    candidates = ipctk.Candidates()
    most = max(thread_counts())

    def impacts(count: int) -> tuple[Callable[[], Impacts], Callable[[], int]]:
        def call() -> Impacts:
            with threads(count):
                return find_impacts(scene)

        return call, lambda: len(call().toi)

    def build() -> None:
        ipctk.set_num_threads(most)
        candidates.build(mesh, start, end, broad_phase=ipctk.LBVH())

    def step_size() -> None:
        build()
        ccd = ipctk.TightInclusionCCD()
        candidates.compute_collision_free_stepsize(mesh, start, end, narrow_phase_ccd=ccd)

    calls: dict[tuple[str, int], tuple[Callable[[], object], Callable[[], int | None]]] = {
        (LBVH, most): (build, lambda: len(candidates)),
        (BOTH, most): (step_size, lambda: None),
    }
    for count in reversed(thread_counts()):
        calls[OWN, count] = impacts(count)
    return calls


def _steps_of_arcsim() -> dict[str, dict[str, Any]]:
    """Return `{step: its record of ARCSim 0.2.1}`, the step that took ARCSim least first."""
    points = {name: peer["arcsim_0_2_1"] for name, peer in steps.peers().items()}
    return dict(sorted(points.items(), key=lambda item: item[1]["cpu_seconds"]))


def _whole(folder: Path, say: Say) -> None:
    """Time whole steps by stage, beside the recorded CPU time of ARCSim."""
    rows = Rows(folder, "resolve", ("step", "threads"))
    for step, point in _steps_of_arcsim().items():
        for count in thread_counts():
            if rows.has(step=step, threads=count):
                continue
            scene = steps.load_step(step)
            with threads(count):
                runs = _resolves(scene, Options())
            result = runs[-1][2]
            stages = {f"{name}_s": result.timings[name] for name in STAGES}
            detect = sum(line.detect_s for line in result.history)
            cpu = float(np.median([run[0] for run in runs]))
            rows.add(
                step=step,
                threads=count,
                triangles=len(scene.faces),
                status=result.status.name,
                **_spread([run[1] for run in runs]),
                cpu_s=cpu,
                **stages,
                detect_s=detect,
                solve_s=sum(line.solve_s for line in result.history),
                iterations=len(result.history),
                objective=result.objective,
                arcsim_cpu_s=point["cpu_seconds"],
                arcsim_objective=point["objective_g"],
                obstacle_moved=bool(point.get("obstacle_moved_m", 0.0)),
            )
            say(f"resolve: {step}, {count} threads: {cpu:.2f} CPU s, {len(runs)} runs")


def _resolves(scene: Scene, options: Options) -> list[tuple[float, float, Result]]:
    """Resolve a step several times, first once to compile.

    Returns:
        CPU seconds, seconds of the clock, and the result of each run but the first one.
    """
    runs, spent = [], 0.0
    while len(runs) <= REPEATS and (len(runs) < 2 or spent < ENOUGH_S):
        begin_cpu, begin = time.process_time(), time.perf_counter()
        result = resolve(scene, THICKNESS_M, options=options)
        cpu, wall = time.process_time() - begin_cpu, time.perf_counter() - begin
        runs.append((cpu, wall, result))
        spent += wall
    return runs[1:]


def _ablation(folder: Path, say: Say) -> None:
    """Time whole steps with each rule of the plan switched off alone, in turn with all rules on."""
    rows = Rows(folder, "ablation", ("step", "left_out"))
    for step in _steps_of_arcsim():
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
        seconds = _in_turn(calls, repeats)
        with_all = np.median(seconds[""])
        for name in calls:
            rows.add(
                step=step,
                left_out=name or "nothing",
                **_spread(seconds[name]),
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
            rows.add(what=what, **_spread(seconds))
            say(f"cold: {what}: {np.median(seconds):.2f} s")


def _scale(folder: Path, say: Say) -> None:
    """Time sheets of up to a million triangles, on one thread and on two."""
    rows = Rows(folder, "scale", ("size", "threads"))
    for count in thread_counts():
        missing = [size for size in SIZES if not rows.has(size=size, threads=count)]
        for row in scaling.measured("sheets", missing, scaling.FULL_LIMIT_S, count):
            rows.add(threads=count, **row)
            say(f"scale: {row['size']}, {count} threads: {row.get('total_s')} s")


def _in_turn(calls: Mapping[Key, Callable[[], object]], repeats: int) -> dict[Key, list[float]]:
    """Time all calls one after the other, and do so several times.

    Args:
        calls: `{key: call}`. Each was called before, since a first call compiles.
        repeats: How often each call is timed.

    Returns:
        `{key: seconds of each call}`.
    """
    seconds: dict[Key, list[float]] = {key: [] for key in calls}
    for _ in range(repeats):
        for key, call in calls.items():
            begin = time.perf_counter()
            call()
            seconds[key].append(time.perf_counter() - begin)
    return seconds


def _spread(seconds: Sequence[float]) -> dict[str, float | int]:
    """Return the median, the least, the most and the number of some times."""
    return {
        "median_s": float(np.median(seconds)),
        "least_s": float(min(seconds)),
        "most_s": float(max(seconds)),
        "repeats": len(seconds),
    }


PARTS: dict[str, Part] = {
    "detection": _detection,
    "resolve": _whole,
    "ablation": _ablation,
    "cold": _cold,
    "scale": _scale,
}
