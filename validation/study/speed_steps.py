"""Parts of the study of speed that time whole steps: real ones, deep contact, the next step."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref import Options, resolve
from izo_ref.loop.resolve import Result
from izo_ref.scene import Scene
from validation.rows import Row, Rows
from validation.scenes.balls import BALL_FACES, pressed_balls
from validation.scenes.garments import garment
from validation.study import steps
from validation.study.parts import Say
from validation.study.speed_detection import lbvh_ratios
from validation.study.timing import REPEATS, in_turn, spread, thread_counts, threads

THICKNESS_M = 1e-4
ENOUGH_S = 120.0  # after this a cell is not repeated; its row has the number of repeats
STAGES = ("main", "relinearize", "scale_back", "certify", "judge")
SEED = 18  # of the scenes of deep contact
DEEP_FAMILIES: dict[str, Callable[[int], Scene]] = {
    "balls": lambda size: pressed_balls(
        np.random.default_rng(SEED), max(2, round(size / BALL_FACES))
    ),
    "garment": lambda size: garment(np.random.default_rng(SEED), size),
}
DEEP_SIZES = (5_000, 20_000, 50_000, 150_000)
WARM_UP_SIZE = 1_000  # triangles of a scene that is resolved first, to compile
NEXT_STEP = "sphere-10k"
NEXT_MOTIONS = (1.0, 0.1)  # of the next step, over that of the step before; the second is light
# The calls that are timed for the next step of a simulation.
NEW, NEW_RESOLVED = "Scene", "Scene and resolve"
AFTER, AFTER_RESOLVED = "scene.after", "scene.after and resolve"


def steps_of_arcsim() -> dict[str, dict[str, Any]]:
    """Return `{step: its record of ARCSim 0.2.1}`, the step that took ARCSim least first."""
    points = {name: peer["arcsim_0_2_1"] for name, peer in steps.peers().items()}
    return dict(sorted(points.items(), key=lambda item: item[1]["cpu_seconds"]))


def whole(folder: Path, say: Say) -> None:
    """Time whole steps by stage, beside the recorded CPU time of ARCSim.

    A row has what LBVH takes now over what it took on the machine of the records. The geometric
    mean of these ratios is `arcsim_scale`, by which the recorded CPU time is to be multiplied.
    """
    rows = Rows(folder, "resolve", ("step", "threads"))
    cells = [(step, count) for step in steps_of_arcsim() for count in thread_counts()]
    cells = [(step, count) for step, count in cells if not rows.has(step=step, threads=count)]
    if not cells:
        return
    ratios, cores = lbvh_ratios() or ({}, None)
    scale = float(np.exp(np.mean(np.log(list(ratios.values()))))) if ratios else None
    say(f"resolve: LBVH takes {scale} of its time where ARCSim was timed, with {cores} cores")
    for step, count in cells:
        point = steps_of_arcsim()[step]
        scene = steps.load_step(step)
        with threads(count):
            runs = resolves(scene, Options())
        rows.add(
            step=step,
            threads=count,
            **measured_row(scene, runs),
            arcsim_cpu_s=point["cpu_seconds"],
            arcsim_scale=scale,
            lbvh_cores=cores,
            **{f"lbvh_{name}": ratio for name, ratio in ratios.items()},
            arcsim_objective=point["objective_g"],
            obstacle_moved=bool(point.get("obstacle_moved_m", 0.0)),
        )
        cpu = np.median([run[0] for run in runs])
        say(f"resolve: {step}, {count} threads: {cpu:.2f} CPU s, {len(runs)} runs")


def deep(folder: Path, say: Say) -> None:
    """Time steps of deep contact: balls that are pressed together, and a garment of layers."""
    rows = Rows(folder, "deep", ("family", "size", "threads"))
    for family, make in DEEP_FAMILIES.items():
        for size in DEEP_SIZES:
            for count in thread_counts():
                if rows.has(family=family, size=size, threads=count):
                    continue
                with threads(count):
                    resolve(make(WARM_UP_SIZE), THICKNESS_M)
                    scene = make(size)
                    runs = resolves(scene, Options(), first=0)
                rows.add(family=family, size=size, threads=count, **measured_row(scene, runs))
                wall = np.median([run[1] for run in runs])
                say(f"deep: {family} {size}, {count} threads: {wall:.2f} s, {len(runs)} runs")


def following(folder: Path, say: Say) -> None:
    """Time the next step of a simulation, with and without checking its start again."""
    rows = Rows(folder, "next", ("step", "motion", "what", "threads"))
    for motion in NEXT_MOTIONS:
        for count in thread_counts():
            key = {"step": NEXT_STEP, "motion": motion, "threads": count}
            if rows.has(**key, what=AFTER_RESOLVED):
                continue
            calls = next_step_calls(steps.load_step(NEXT_STEP), motion)
            with threads(count):
                for call in calls.values():
                    call()
                seconds = in_turn(calls, REPEATS)
            for what, own in seconds.items():
                rows.add(**key, what=what, **spread(own))
                say(f"next: {motion} of the motion, {what}, {count}: {np.median(own):.4f} s")


def next_step_calls(scene: Scene, motion: float) -> dict[str, Callable[[], Any]]:
    """Return `{what: call}` for the step after one.

    Args:
        scene: The step before.
        motion: How far the vertices are to move on, over how far they moved in the step before.
    """
    result = resolve(scene, THICKNESS_M)
    start = result.positions
    proposed = start + motion * (start - scene.positions_t0)

    def new() -> Scene:
        return Scene(start, proposed, scene.faces, scene.masses, scene.pinned)

    def after() -> Scene:
        return scene.after(result, proposed)

    return {
        NEW: new,
        NEW_RESOLVED: lambda: resolve(new(), THICKNESS_M),
        AFTER: after,
        AFTER_RESOLVED: lambda: resolve(after(), THICKNESS_M),
    }


def resolves(scene: Scene, options: Options, first: int = 1) -> list[tuple[float, float, Result]]:
    """Resolve a step several times, but not again after ENOUGH_S.

    Args:
        scene: The step.
        options: How it is resolved.
        first: Number of runs that do not count, because they compile: 1, or 0 if all is compiled.

    Returns:
        CPU seconds, seconds of the clock, and the result of each run that counts.
    """
    runs, spent = [], 0.0
    while len(runs) < REPEATS + first and (len(runs) <= first or spent < ENOUGH_S):
        begin_cpu, begin = time.process_time(), time.perf_counter()
        result = resolve(scene, THICKNESS_M, options=options)
        cpu, wall = time.process_time() - begin_cpu, time.perf_counter() - begin
        runs.append((cpu, wall, result))
        spent += wall
    return runs[first:]


def measured_row(scene: Scene, runs: list[tuple[float, float, Result]]) -> Row:
    """Return the columns of some runs of a step; stages and answer are those of the last run."""
    result = runs[-1][2]
    return {
        "triangles": len(scene.faces),
        "status": result.status.name,
        **spread([run[1] for run in runs]),
        "cpu_s": float(np.median([run[0] for run in runs])),
        **{f"{name}_s": result.timings[name] for name in STAGES},
        "detect_s": sum(line.detect_s for line in result.history),
        "solve_s": sum(line.solve_s for line in result.history),
        "iterations": len(result.history),
        "objective": result.objective,
        **rounds(result),
    }


def rounds(result: Result) -> Row:
    """Return the objective after each number of rounds with new normals, and what it cost.

    Returns:
        `objective_k` [m^2] after k rounds, and `rounds_k_s`, the time of all iterations up to
        there; None for rounds that were not run, also where a step is blocked before its first
        iteration ends. The last round may have been taken back; its objective is that of the
        result.
    """
    columns: Row = {}
    last = max((line.round for line in result.history), default=-1)
    for number in range(result.options.relinearize + 1):
        lines = [line for line in result.history if 0 <= line.round <= number]
        value = spent = None
        if number <= last:
            value = result.objective if number == last else lines[-1].objective
            spent = sum(line.detect_s + line.solve_s for line in lines)
        columns[f"objective_{number}"] = value
        columns[f"rounds_{number}_s"] = spent
    return columns
