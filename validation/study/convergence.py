"""Study of convergence: how the error falls with each step of a solver, and in the outer loop.

It solves zones with a trace of objective and violation, and resolves whole steps with the history
of the outer loop. It is one of the studies of `python -m validation report`.
"""

import time
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.app.demo import demo_scene
from izo_ref.loop.resolve import resolve
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.problem import ZoneProblem
from validation.rows import Rows
from validation.study import steps
from validation.study.families import STEP_THICKNESS_M, synthetic
from validation.study.own import DIRECTIONS, FIRST_ORDER, LINE_SEARCHES
from validation.study.parts import Say
from validation.study.truth import Truth

KEYS = ("part", "name", "method", "line_search", "update", "step")
ZONES, QUICK_ZONES = ("random-64", "pinch-64", "stack-500"), ("random-64",)
STEPS = ("sheets-10k", "sphere-10k", "stack-6k")
POINTS = 200  # points of a curve that are kept
VISITS, QUICK_VISITS = 1e7, 6.4e5  # steps times impacts of one curve, at most
TOLERANCE = 1e-12


def run(rows_folder: Path, quick: bool, say: Say) -> None:
    """Add the rows that are missing.

    Args:
        rows_folder: Folder of `convergence.csv`.
        quick: Measure one zone, and our own scene.
        say: Is called with a line of text as the work goes on.
    """
    rows = Rows(rows_folder, "convergence", KEYS)
    for name in QUICK_ZONES if quick else ZONES:
        zone_curves(rows, name, QUICK_VISITS if quick else VISITS, say)
    for name in step_names(quick):
        step_history(rows, name, say)


def curves() -> list[tuple[str, str, str]]:
    """Return (method, line search, update) of each curve of a zone."""
    chosen = [(d, s, "every-step") for d in DIRECTIONS for s in LINE_SEARCHES]
    chosen += [(direction, "exact", "inner-solve") for direction in DIRECTIONS]
    return chosen + [(method, "-", "-") for method in FIRST_ORDER]


def step_names(quick: bool) -> list[str]:
    """Name the steps whose outer iterations are shown; our own scene if there are no files."""
    found = [name for name in STEPS if (steps.FOLDER / f"{name}.npz").is_file()]
    return ["demo"] if quick or not found else found


def zone_curves(rows: Rows, name: str, visits: float, say: Say) -> None:
    """Add the missing curves of the first problem of a family.

    Args:
        rows: Rows of the study.
        name: Name of the family.
        visits: Steps times impacts of one curve, at most.
        say: Is called with a line of text at the end.
    """
    key = {"part": "zone", "name": name}
    missing = [
        curve
        for curve in curves()
        # a curve is written backwards, so its first point exists only if all others do
        if not rows.has(**key, **dict(zip(KEYS[2:5], curve, strict=True)), step=0)
    ]
    if not missing:
        return
    begin = time.perf_counter()
    family = next(family for family in synthetic() if family.name == name)
    problem = family.problems()[0]
    truth = Truth(problem)
    for curve in missing:
        names: dict[str, str] = dict(zip(KEYS[2:5], curve, strict=True))
        for point in reversed(_points(problem, truth, names, int(visits / family.size))):
            rows.add(**key, **names, **point)
    say(f"convergence: {name}, {len(missing)} curves, {time.perf_counter() - begin:.1f} s")


def _points(
    problem: ZoneProblem, truth: Truth, names: dict[str, str], max_steps: int
) -> list[dict[str, Any]]:
    """Return the rows of a curve, step 0 first; one row with the reason if the solver fails."""
    keywords: dict[str, Any] = {"method": names["method"]}
    if names["line_search"] != "-":
        keywords["line_search"] = names["line_search"]
        keywords["multiplier_update"] = names["update"]
    try:
        begin = time.perf_counter()
        solution = solve_zone(
            problem, tolerance=TOLERANCE, max_steps=max_steps, trace=True, **keywords
        )
        seconds = time.perf_counter() - begin
        trace = solution.trace
        if trace is None:
            raise TypeError("no trace")
    except Exception as error:  # an exception of a solver is recorded in its row
        return [{"step": 0, "outcome": "failed", "message": f"{type(error).__name__}: {error}"}]
    start = (0.0, max(0.0, -float(problem.gaps(problem.proposed).min())))
    trace = np.vstack((start, trace))
    last = len(trace) - 1
    kept = np.unique(np.geomspace(1, last + 1, POINTS).astype(int) - 1)
    solved = solution.residuals.solved(TOLERANCE, TOLERANCE)
    return [
        {
            "step": int(step),
            "outcome": "converged" if solved else "not converged",
            "message": None,
            "excess": float(trace[step, 0] / truth.objective - 1.0),
            "violation": float(trace[step, 1] / problem.thickness),
            "steps": last,
            "seconds": seconds,
            "error": truth.error(solution.displacements),
            "gap": solution.residuals.gap,
        }
        for step in kept
    ]


def step_history(rows: Rows, name: str, say: Say) -> None:
    """Add one row for each outer iteration of a whole step, resolved with default options.

    Args:
        rows: Rows of the study.
        name: Name of the step, or "demo".
        say: Is called with a line of text at the end.
    """
    key = {"part": "step", "name": name, "method": "auto", "line_search": "-", "update": "-"}
    if rows.has(**key, step=0):
        return
    scene = demo_scene()[0] if name == "demo" else steps.load_step(name)
    begin = time.perf_counter()
    result = resolve(scene, None if name == "demo" else STEP_THICKNESS_M)
    seconds = time.perf_counter() - begin
    for step, iteration in reversed(list(enumerate(result.history))):
        rows.add(
            **key,
            step=step,
            outcome="converged" if result.converged else "not converged",
            message=result.status.name,
            round=iteration.round,
            objective=iteration.objective,
            found=iteration.found,
            added=iteration.added,
            impacts=iteration.impacts,
            zones=iteration.zones,
            seconds=seconds,
        )
    say(f"convergence: {name}, {len(result.history)} iterations, {seconds:.1f} s")
