"""Parts of the study of speed that time ipctk: detection, and how fast this machine is."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import numpy as np

from izo_ref import find_impacts
from izo_ref.base.records import Impacts
from izo_ref.scene import Scene
from validation.rows import Rows
from validation.study import steps
from validation.study.parts import Say
from validation.study.timing import REPEATS, in_turn, spread, thread_counts, threads

# The calls that are timed for a detection.
OWN, LBVH, BOTH = (
    "izo_ref: find_impacts",
    "ipctk: LBVH",
    "ipctk: LBVH and Tight Inclusion",
)
DETECTION_STEPS = (
    "armadillo-rollers",
    "cloth-ball-clean",
    "sheets-50k",
    "sheets-10k",
    "stack-6k",
    "cloth-funnel-clean",
)
# Seconds that LBVH took on the machine on which ARCSim was timed, on two threads.
LBVH_THEN_S = {"armadillo-rollers": 0.349, "cloth-ball-clean": 0.292, "sheets-50k": 0.049}
THEN_THREADS = 2

Call: TypeAlias = Callable[[], object]


def detection(folder: Path, say: Say) -> None:
    """Time the detection of all impacts of a step, and ipctk's candidates and its step size."""
    rows = Rows(folder, "detection", ("step", "what", "threads"))
    for step in DETECTION_STEPS:
        if rows.has(step=step, what=OWN, threads=1):
            continue
        calls = detection_calls(steps.load_step(step))
        numbers: dict[tuple[str, int], int | None] = {}
        for key, (call, found) in calls.items():
            call()
            numbers[key] = found()
        seconds = in_turn({key: call for key, (call, _) in calls.items()}, REPEATS)
        for (what, count), own in seconds.items():
            number = numbers[what, count]
            rows.add(step=step, what=what, threads=count, **spread(own), found=number)
            say(f"detection: {step}, {what}, {count} threads: {np.median(own):.3f} s")


def detection_calls(
    scene: Scene,
) -> dict[tuple[str, int], tuple[Call, Callable[[], int | None]]]:
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

    def build(count: int) -> tuple[Callable[[], None], Callable[[], int]]:
        def call() -> None:
            ipctk.set_num_threads(count)
            candidates.build(mesh, start, end, broad_phase=ipctk.LBVH())

        return call, lambda: len(candidates)

    def step_size() -> None:
        build(most)[0]()
        ccd = ipctk.TightInclusionCCD()
        candidates.compute_collision_free_stepsize(mesh, start, end, narrow_phase_ccd=ccd)

    calls: dict[tuple[str, int], tuple[Call, Callable[[], int | None]]] = {}
    calls[BOTH, most] = step_size, lambda: None
    for count in reversed(thread_counts()):
        calls[LBVH, count] = build(count)
        calls[OWN, count] = impacts(count)
    return calls


def lbvh_ratios() -> tuple[dict[str, float], float] | None:
    """Time LBVH as on the machine on which ARCSim was timed.

    Returns:
        `{step: seconds now over those of LBVH_THEN_S}`, and CPU seconds over seconds of the clock
        in all calls: if another process holds a core, it is near 1, and the ratios are too large.
        None if this machine has fewer threads than were used then, because the times are not
        comparable.
    """
    if max(thread_counts()) < THEN_THREADS:
        return None
    ratios, cpu_s, wall_s = {}, 0.0, 0.0
    for step, then_s in LBVH_THEN_S.items():
        call, _ = detection_calls(steps.load_step(step))[LBVH, THEN_THREADS]
        call()
        begin_cpu, begin = time.process_time(), time.perf_counter()
        ratios[step] = float(np.median(in_turn({step: call}, REPEATS)[step])) / then_s
        cpu_s += time.process_time() - begin_cpu
        wall_s += time.perf_counter() - begin
    return ratios, cpu_s / wall_s
