"""Study of whole steps: objective against CPU time, by selection, thickness, tolerance and rounds.

It resolves each step with each setting on one thread, and takes the quickest of up to three runs.
It is one of the studies of `python -m validation report`.
"""

import time
from collections.abc import Callable, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from izo_ref import Options, resolve, solve_zone
from izo_ref.base.errors import IzoError
from izo_ref.base.options import CHOICES
from izo_ref.loop.resolve import Result
from izo_ref.scene import Scene
from validation.rows import Rows
from validation.study import steps
from validation.study.parts import Say
from validation.study.timing import threads

SEED = 20240607
SELECTIONS = CHOICES["selection"]
THICKNESS_M = 1e-4
THICKNESSES_M = (3e-5, 1e-4, 3e-4)
TOLERANCES = (1e-9, 1e-6)
MOST_ROUNDS = Options().relinearize
ROUNDS = (0, 1, 2, 3, MOST_ROUNDS)
PEER = "ARCSim 0.2.1"
# If a step takes longer than this with the default [CPU s], only its selections are compared.
LONG_S = 10.0
FULL_LIMIT_S, QUICK_LIMIT_S = 300.0, 10.0  # of one run; checked after each iteration
FULL_ENOUGH_S, QUICK_ENOUGH_S, MOST_REPEATS = 1.0, 0.3, 3  # after this a row is not repeated
DEMO = "generated: demo"  # takes half a minute for all settings
QUICK_STEPS = (
    "cloth-funnel-clean",
    "crumple-10k",
    "ipctd-thick-cloth",
    "ipctd-two-cubes-far-intersecting",
    "pinch-blocked-10k",
    "pinch-free-20k",
    "sphere-10k",
)


class Setting(NamedTuple):
    """The key columns of a row beside the step."""

    selection: str  # a selection of ours, or the name of the other system
    thickness: float  # [m]
    tolerance: float | None  # of gap and violation; None for the other system
    relinearize: int | None  # rounds at most; None for the other system


DEFAULT = Setting("independent", THICKNESS_M, 1e-9, MOST_ROUNDS)
KEYS = ("step", *Setting._fields)


class _TooLong(Exception):
    """A run took longer than its limit."""


def run(rows_folder: Path, quick: bool, say: Say) -> None:
    """Add the rows that are missing.

    Args:
        rows_folder: Folder of `outer.csv`.
        quick: Measure only steps of a second or less, with fewer settings.
        say: Is called with a line of text as the work goes on.
    """
    rows = Rows(rows_folder, "outer", KEYS)
    peers = steps.peers()
    warm = False
    for name in step_names(quick):
        if not rows.has(**_peer_key(name)) and name in peers:
            rows.add(**_peer_key(name), **_peer_row(peers[name]))
        missing = [s for s in settings(quick) if not rows.has(step=name, **s._asdict())]
        if not missing:
            continue
        if not warm:
            _warm_up()
            warm = True
        begin = time.perf_counter()
        added = _add_step(rows, name, missing, quick)
        say(f"outer: {name}, {added} rows, {time.perf_counter() - begin:.1f} s")


def step_names(quick: bool) -> list[str]:
    """Name the steps of a run; generated ones where there are no step files."""
    if not steps.available():
        return [name for name in GENERATED if not (quick and name == DEMO)]
    names = sorted(steps.step_names(), key=_file_size)  # small files first
    return [name for name in QUICK_STEPS if name in names] if quick else names


def _file_size(name: str) -> int:
    return (steps.FOLDER / f"{name}.npz").stat().st_size


def settings(quick: bool) -> list[Setting]:
    """Return the default; then selections with rounds, with tolerances, and with thicknesses."""
    rounds = (0, MOST_ROUNDS) if quick else ROUNDS
    others = SELECTIONS[:1] if quick else SELECTIONS
    found = [DEFAULT]
    found += [DEFAULT._replace(selection=s, relinearize=r) for s, r in product(SELECTIONS, rounds)]
    found += [DEFAULT._replace(selection=s, tolerance=t) for s, t in product(others, TOLERANCES)]
    found += [DEFAULT._replace(selection=s, thickness=d) for s, d in product(others, THICKNESSES_M)]
    return list(dict.fromkeys(found))


def _add_step(rows: Rows, name: str, missing: Sequence[Setting], quick: bool) -> int:
    """Add the missing rows of one step, only the selections if the step takes long.

    Returns:
        The number of rows that were added.
    """
    try:
        scene = _scene(name)
    except IzoError as error:  # the step is rejected as input, which is the right answer
        rows.add(step=name, **DEFAULT._asdict(), **_failure(error))
        return 1
    limit_s = QUICK_LIMIT_S if quick else FULL_LIMIT_S
    enough_s = QUICK_ENOUGH_S if quick else FULL_ENOUGH_S
    added = 0
    for setting in missing:
        few = setting == DEFAULT._replace(selection=setting.selection)
        if not few and _is_long(rows, name):
            continue
        row = _measured(scene, setting, limit_s, enough_s)
        rows.add(step=name, **setting._asdict(), triangles=len(scene.faces), **row)
        added += 1
    return added


def _is_long(rows: Rows, name: str) -> bool:
    """Return whether the default took long or failed; False before it is measured."""
    own = [r for r in rows.all() if r["step"] == name and _setting(r) == DEFAULT]
    return any(row["outcome"] == "failed" or row["cpu_s"] > LONG_S for row in own)


def _setting(row: dict[str, Any]) -> Setting:
    return Setting(*(row[name] for name in Setting._fields))


def _measured(scene: Scene, setting: Setting, limit_s: float, enough_s: float) -> dict[str, Any]:
    """Measure the quickest of up to three runs: CPU seconds, seconds of the clock, and result."""
    assert setting.tolerance is not None
    assert setting.relinearize is not None
    options = Options(
        selection=setting.selection,
        relinearize=setting.relinearize,
        gap_tolerance=setting.tolerance,
        violation_tolerance=setting.tolerance,
    )
    runs: list[tuple[float, float, Result]] = []  # CPU seconds, seconds of the clock, result
    spent = 0.0
    with threads(1):
        while len(runs) < MOST_REPEATS and spent < enough_s:
            begin_cpu, begin = time.process_time(), time.perf_counter()
            try:
                result = resolve(
                    scene,
                    setting.thickness,
                    options=options,
                    on_iteration=_stopping(begin_cpu + limit_s),
                )
            except _TooLong:
                return _too_long(time.process_time() - begin_cpu)
            except (IzoError, MemoryError) as error:
                return _failure(error)
            cpu, wall = time.process_time() - begin_cpu, time.perf_counter() - begin
            spent += wall
            runs.append((cpu, wall, result))
    cpu, wall, result = min(runs, key=lambda timed: timed[0])
    return _outcome(result) | {"cpu_s": cpu, "wall_s": wall, "repeats": len(runs)}


def _stopping(until: float) -> Callable[[object], None]:
    """Return an `on_iteration` that stops a run after this time of the process [CPU s]."""

    def on_iteration(_line: object) -> None:
        if time.process_time() > until:
            raise _TooLong

    return on_iteration


def _outcome(result: Result) -> dict[str, Any]:
    """Return the columns of a result.

    A row is converged if the path is certified free and every zone is solved.
    """
    status = result.status.name
    return {
        "outcome": "converged" if status == "FREE" else "not converged",
        "message": status,
        "objective": result.objective,
        "iterations": len(result.history),
        "impacts": len(result.impacts.toi),
        "zones": len(result.zones),
        "largest_zone": int(np.diff(result.zones.impact_offsets).max(initial=0)),
        "candidates": max((line.candidates for line in result.history), default=0),
    }


def _too_long(cpu: float) -> dict[str, Any]:
    return {"outcome": "not converged", "message": f"stopped after {cpu:.0f} s", "cpu_s": cpu}


def _failure(error: Exception) -> dict[str, Any]:
    return {"outcome": "failed", "message": f"{type(error).__name__}: {error}"[:200]}


def _peer_key(name: str) -> dict[str, Any]:
    peer = Setting(PEER, THICKNESS_M, None, None)
    return {"step": name, **peer._asdict()}


def _peer_row(peer: dict[str, Any]) -> dict[str, Any]:
    """Return what was recorded of the other system; moving an obstacle solves another problem."""
    point = peer["arcsim_0_2_1"]
    moved = point.get("obstacle_moved_m", 0.0)
    valid = point["converged"] and point["path_free_at_1e9"] and point["end_free"] and not moved
    return {
        "triangles": peer["triangles"],
        "outcome": "converged" if valid else "not converged",
        "message": f"it moved an obstacle by {moved:.1e} m" if moved else "recorded elsewhere",
        "objective": point["objective_g"],
        "cpu_s": point["cpu_seconds"],
        "iterations": point["outer_iterations"],
    }


def _scene(name: str) -> Scene:
    return GENERATED[name]() if name in GENERATED else steps.load_step(name)


def _demo() -> Scene:
    from izo_ref.app.demo import demo_scene

    return demo_scene()[0]


def _sheets(n_triangles: int) -> Scene:
    from validation.scenes.sheets import meeting_sheets

    return meeting_sheets(np.random.default_rng([SEED, n_triangles]), n_triangles)


def _contact(kind: str) -> Scene:
    from validation.scenes.contacts import contact_scene

    return contact_scene(np.random.default_rng(SEED), kind)


GENERATED = {
    "generated: two tetrahedra": lambda: _contact("tetrahedra"),
    "generated: edge on edge": lambda: _contact("edge on edge"),
    "generated: sheets, 3,000": lambda: _sheets(3_000),
    "generated: sheets, 10,000": lambda: _sheets(10_000),
    DEMO: _demo,
}


def _warm_up() -> None:
    """Compile or load the code whose compile time the first row would otherwise include."""
    from validation.scenes.piles import chain_zone

    with threads(1):
        scene = _sheets(3_000)
        for selection in SELECTIONS:
            resolve(scene, THICKNESS_M, options=Options(selection=selection))
        for size in (1, 8, 2000):
            solve_zone(chain_zone(np.random.default_rng([SEED, size]), size))
