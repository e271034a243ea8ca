"""Study of CUDA: what kernels need, whether a GPU finds the same as the CPU, and how long it takes.

Without a GPU it compiles every kernel by ptxas, counts what each iteration asks of a GPU, and
computes lower bounds of times. With a GPU it first compiles, by several processes. Then it checks
small cases, and ends at the first difference. At last it compares detection, whole steps and zones
with the CPU. It needs numba, numba-cuda, numpy and scipy. `python -m validation study cuda` starts
it.

Each part that needs a GPU has a budget of time, and runs in a process of its own, which is stopped
if it takes much longer. So all of them together take at most 9 minutes.
"""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from izo_ref import find_impacts, resolve
from izo_ref.base.devices import has_gpu
from izo_ref.base.errors import InitialIntersectionError
from izo_ref.base.records import PairCounts
from izo_ref.scene import Scene
from validation import ptx
from validation.rows import Row, Rows
from validation.study import gpu_bounds, gpu_check, gpu_launches, gpu_zones
from validation.study.gpu_filter import study_filter
from validation.study.gpu_parts import (
    CPU_BUDGET_S,
    GPU_BUDGET_S,
    REPEATS,
    Clock,
    GpuPart,
    all_steps,
    gpu_name,
    name_of,
)
from validation.study.gpu_timing import copied_bytes_per_ms, event_ms
from validation.study.parts import Say
from validation.study.timing import measure

COPIED = 1 << 28  # bytes that are copied to measure the bandwidth
LIMIT_S = 540.0  # of all parts that need a GPU together
GRACE_S = 8.0  # that a part may take beyond its budget, to end its last case


# runs a part in a process of its own: (name, folder, seconds, say) -> exit code
Start: TypeAlias = Callable[[str, Path, float, Say], int]


class Part(NamedTuple):
    """A part of the study."""

    run: GpuPart
    budget_s: float | None  # None for a part that needs no GPU


def kernels(folder: Path, say: Say, _clock: Clock) -> None:
    """Compile every kernel by ptxas, and record what it needs."""
    rows = Rows(folder, "kernels", ("kernel", "types", "capability"))
    if ptx.ptxas() is None:
        say("kernels: ptxas is not installed (package nvidia-cuda-nvcc)")
        return
    for name, kernel in ptx.kernels():
        for types, signature in ptx.signatures(kernel).items():
            for major, minor in ptx.CAPABILITIES:
                key = {"kernel": name, "types": types, "capability": f"{major}.{minor}"}
                if not rows.has(**key):
                    rows.add(**key, **ptx.build(kernel, signature, (major, minor))._asdict())
        say(f"kernels: {name}")


def detection(folder: Path, say: Say, clock: Clock) -> None:
    """Detect all impacts of a step on a GPU and on the CPU: differences, and times of both."""
    rows, gpu = Rows(folder, "detection", ("step",)), gpu_name("detection", say)
    if gpu is None:
        return
    per_ms = copied_bytes_per_ms(COPIED, REPEATS)
    for name, load in clock.cases(all_steps(), name_of, say):
        if rows.has(step=name):
            continue
        row = detected(load(), per_ms)
        rows.add(step=name, gpu=gpu, copied_per_s=1e3 * per_ms, **row)
        say(f"detection: {name}: {row['gpu_ms']:.2f} ms")


def detected(scene: Scene, per_ms: float) -> Row:
    """Detect the impacts of a step on both, and return its row.

    Args:
        scene: The step.
        per_ms: Bytes that a copy inside the GPU moves in a millisecond.
    """
    from izo_ref.base.gpu_arrays import to_cpu, to_gpu
    from izo_ref.detection.gpu_detector import Detector

    detector, end = Detector(scene), to_gpu(scene.positions_t1)
    found = [to_cpu(column) for column in detector.find(end)]
    expected = find_impacts(scene)
    cpu = measure(lambda: find_impacts(scene), REPEATS, CPU_BUDGET_S)
    return {
        "triangles": len(scene.faces),
        "impacts": len(expected.toi),
        **gpu_check.impact_differences(found, expected),
        "gpu_ms": event_ms(lambda: detector.find(end), REPEATS),
        "floor_ms": least_bytes(scene, detector.counts) / per_ms,
        "cpu_ms": 1e3 * cpu.seconds,
    }


def least_bytes(scene: Scene, counts: PairCounts) -> float:
    """Return the bytes that a detection has to move at least; `gpu_bounds.py` says which."""
    sizes = gpu_bounds.Sizes(
        triangles=len(scene.faces),
        vertices=len(scene.pinned),
        edges=len(scene.edges),
        pairs=sum(counts.pairs.values()),
        found=0,
        impacts=0,
        zones=0,
        rows_cubed=0,
        iterations=1,
    )
    return sum(stage.n_bytes for stage in gpu_bounds.stages_of(sizes, 0.0)[:3])


def whole_steps(folder: Path, say: Say, clock: Clock) -> None:
    """Resolve whole steps on a GPU and on the CPU: status, objective, distance and times."""
    rows, gpu = Rows(folder, "steps", ("step",)), gpu_name("steps", say)
    if gpu is None:
        return
    per_ms = copied_bytes_per_ms(COPIED, REPEATS)
    for name, load in clock.cases(all_steps(), name_of, say):
        if rows.has(step=name):
            continue
        try:
            row = resolved(load(), per_ms)
        except InitialIntersectionError as error:
            say(f"steps: {name}: {error}")
            continue
        rows.add(step=name, gpu=gpu, **row)
        say(f"steps: {name}: {row['gpu_ms']:.2f} ms")


def resolved(scene: Scene, per_ms: float) -> Row:
    """Resolve a step on both, and return its row; `per_ms` as of `detected`."""
    resolve(scene, device="cuda")  # this may compile, for longer than the budget
    own = measure(lambda: resolve(scene, device="cuda"), REPEATS, GPU_BUDGET_S)
    other = measure(lambda: resolve(scene), REPEATS, CPU_BUDGET_S)
    found, expected = own.result, other.result
    again = resolve(scene, device="cuda")
    stages = gpu_bounds.stages_of(gpu_bounds.sizes_of_result(scene, found), 0.0)
    return {
        "triangles": len(scene.faces),
        "status": found.status.name,
        "cpu_status": expected.status.name,
        "objective": found.objective / expected.objective if expected.objective else 1.0,
        "apart_m": float(np.abs(found.positions - expected.positions).max(initial=0.0)),
        "same_again": bool(np.array_equal(found.positions, again.positions)),
        "left": found.left_to_cpu,
        "solved": sum(line.solved for line in found.history),
        "iterations": len(found.history),
        "cpu_iterations": len(expected.history),
        "floor_ms": sum(s.n_bytes for s in stages) * len(found.history) / per_ms,
        "loop_ms": 1e3 * (again.timings["main"] + again.timings["relinearize"]),
        "certify_ms": 1e3 * again.timings["certify"],
        "gpu_ms": 1e3 * own.seconds,
        "cpu_ms": 1e3 * other.seconds,
    }


PARTS = {
    "kernels": Part(kernels, None),
    "launches": Part(gpu_launches.launches, None),
    "bounds": Part(gpu_bounds.bounds, None),
    "filter": Part(study_filter, None),
    "warm": Part(gpu_check.warm, 75.0),
    "check": Part(gpu_check.check, 85.0),
    "detection": Part(detection, 80.0),
    "steps": Part(whole_steps, 110.0),
    "blocks": Part(gpu_zones.blocks, 50.0),
    "zones": Part(gpu_zones.zones, 45.0),
    "memory": Part(gpu_zones.memory, 36.0),
}


def run_part(name: str, folder: Path, say: Say) -> str | None:
    """Run one part in this process.

    Returns:
        The first difference between a GPU and the CPU, of the part that looks for it; else None.
    """
    part = PARTS[name]
    return part.run(
        folder, say, Clock(folder, name, np.inf if part.budget_s is None else part.budget_s)
    )


def run(folder: Path, only: str | None, say: Say, start: Start) -> str | None:
    """Run one part, or all parts for which this machine has what they need.

    Args:
        folder: Folder of the rows.
        only: Name of the only part to run; None runs those that need a GPU if there is one, and
            else those that need none.
        say: Is called with a line of text as the work goes on.
        start: Runs a part in a process of its own; `started` does.

    Returns:
        What failed, or differs between a GPU and the CPU; None if nothing does.
    """
    if only is not None:
        return run_part(only, folder, say)
    with_gpu, failed = has_gpu(), list[str]()
    for name, part in PARTS.items():
        if (part.budget_s is not None) != with_gpu:
            say(f"{name}: {'needs no GPU: run it by --only' if with_gpu else 'needs a GPU'}")
        elif part.budget_s is None:
            run_part(name, folder, say)
        elif start(name, folder, part.budget_s + GRACE_S, say):
            failed.append(name)
            if name == "check":
                break
    return f"failed: {', '.join(failed)}" if failed else None


def started(name: str, folder: Path, limit_s: float, say: Say) -> int:
    """Run a part in a process of its own, and return its exit code; 0 if it had to be stopped."""
    command = [sys.executable, "-m", "validation", "study", "cuda", "--only", name]
    command += ["-o", str(folder.parent.parent)]
    try:
        return subprocess.run(command, timeout=limit_s).returncode
    except subprocess.TimeoutExpired:
        Clock(folder, name, 0.0).cut("what it was at", limit_s, say)
        return 0
