"""Time one step in a process of its own, with a time limit, and say where the time goes."""

from __future__ import annotations

import time

import numpy as np

import izo_ref
from izo_ref import Options
from izo_ref.base.errors import IzoError
from validation.limits import Limits, NotDecidedError, limited
from validation.rows import Row
from validation.study.stability_time.recipe import Recipe
from validation.study.stability_time.shapes import step_of, thickness_of

SEED = 21
# Memory of a process [bytes]; its time is three times the limit of the step, and these seconds.
MEMORY, MARGIN_S = 4 << 30, 20.0
STAGES = ("main", "relinearize", "scale_back", "certify", "judge")


def measured(recipe: Recipe, n_triangles: int, max_seconds: float) -> Row:
    """Resolve a step of a recipe once, and return what it took.

    Args:
        recipe: How the step is made.
        n_triangles: Its triangles, about.
        max_seconds: Time limit of `resolve` [s].

    Returns:
        `outcome`: `converged`, `not converged` (a fallback, blocked or cut) or `failed`; and if it
        did not fail, the CPU seconds of `resolve`, the same over n log2 n [us], the seconds of each
        stage, and counts.
    """
    limits = Limits(3.0 * max_seconds + MARGIN_S, MEMORY)
    try:
        return limited(limits, _measured, recipe, n_triangles, max_seconds)
    except (NotDecidedError, IzoError, MemoryError) as error:
        return {"outcome": "failed", "message": f"{type(error).__name__}: {error}"}


def _measured(recipe: Recipe, n_triangles: int, max_seconds: float) -> Row:
    scene = step_of(recipe, n_triangles, SEED)
    options = Options(max_seconds=max_seconds)
    thickness = thickness_of(recipe, scene)
    begin_cpu, begin = time.process_time(), time.perf_counter()
    result = izo_ref.resolve(scene, thickness, options=options)
    cpu_s, wall_s = time.process_time() - begin_cpu, time.perf_counter() - begin
    n, history = len(scene.faces), result.history
    return {
        "outcome": "converged" if result.converged else "not converged",
        "message": "",
        "triangles": n,
        "cpu_s": cpu_s,
        "wall_s": wall_s,
        "us_per_nlogn": score(cpu_s, n),
        "cut": bool(result.reason),
        "reason": result.reason,
        "status": result.status.name,
        "free": result.certificate.free,
        **{f"{name}_s": result.timings[name] for name in STAGES},
        "detect_s": sum(line.detect_s for line in history),
        "solve_s": sum(line.solve_s for line in history),
        "iterations": len(history),
        "candidates": sum(line.candidates for line in history),
        "found": sum(line.found for line in history),
        "impacts": len(result.impacts.toi),
        "largest_zone": int(np.diff(result.zones.impact_offsets).max(initial=0)),
    }


def score(cpu_s: float, n_triangles: int) -> float:
    """Return CPU microseconds over n log2 n."""
    n = max(n_triangles, 2)
    return 1e6 * cpu_s / (n * float(np.log2(n)))


def warm_up() -> None:
    """Compile what resolving needs, so that no measured process compiles."""
    from validation.scenes.balls import pressed_balls

    izo_ref.resolve(pressed_balls(np.random.default_rng(SEED), 3), 1e-5)
    for kind in ("sheets", "soup", "weave"):
        scene = step_of(Recipe(kind), 400, SEED)
        izo_ref.resolve(scene, thickness_of(Recipe(kind), scene), options=Options(max_seconds=20.0))
