"""Run a whole step of a ladder, and compare what it claims with what is known."""

import time
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import AnyArray, Faces, Positions
from izo_ref.base.errors import IzoError
from izo_ref.base.options import Options
from izo_ref.base.records import Status
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.system import zone_problem
from validation import judge
from validation.ladders.judge_zone import condition_number
from validation.ladders.ladder import NO_ANSWER, OWN, RIGHT, SAYS_SO, WRONG, Outcome
from validation.limits import Limits
from validation.oracles.pairs import meeting_pairs

BRUTE_FACES = 150  # up to here, exact arithmetic decides about every pair of the mesh
CONDITION_IMPACTS = 200  # largest zone whose condition number is computed
REPEAT_BELOW_S = 5.0  # a faster run is timed again: loading compiled code takes up to 3 s
CERTIFIED = ("FREE", "FREE_BY_FALLBACK")


class Case(NamedTuple):
    """A time step, and how it is resolved.

    Attributes:
        start: (n, 3) f8 [m].
        end: (n, 3) f8 [m], proposed.
        faces: (m, 3) integers.
        thickness: [m]; None for the default.
        masses: (n,) f8 [kg], or None.
        pinned: (n,) bool, or None.
        modes: Further arguments of `Scene`.
        options: Arguments of `Options`.
    """

    start: AnyArray
    end: AnyArray
    faces: AnyArray
    thickness: float | None = None
    masses: AnyArray | None = None
    pinned: AnyArray | None = None
    modes: Mapping[str, Any] = MappingProxyType({})
    options: Mapping[str, Any] = MappingProxyType({})

    def scene(self) -> Scene:
        """Return the scene.

        Raises:
            IzoError: The step is not valid.
        """
        return Scene(self.start, self.end, self.faces, self.masses, self.pinned, **self.modes)


class Known(NamedTuple):
    """What is known of a step, without asking our solver.

    Attributes:
        statuses: Statuses, or classes of errors, that are the right answer.
        positions: (n, 3) f8 [m], the right end positions; None if they are not known.
        objective: Objective of the best end positions that are known [m^2]; None if none is.
        tolerance: Largest relative error that is right: of the positions, over the largest move
            from the proposal; or of the objective. Infinity if it is only reported.
        note: A sentence: what is known, and why.
        check: Function of the result that returns what is false of it in a sentence, or an empty
            string; for facts that hold whatever the status is, such as the centre of mass.
    """

    statuses: tuple[str, ...] = ("FREE",)
    positions: Positions | None = None
    objective: float | None = None
    tolerance: float = 1e-9
    note: str = ""
    check: Callable[[Result], str] | None = None


def judge_step(case: Case, known: Known) -> list[Outcome]:
    """Resolve a step and judge it: nothing that it claims may be false.

    A certified path is refuted by exact arithmetic over all pairs, or, for more than BRUTE_FACES
    faces, by ipctk and exact arithmetic. NaN and infinity in a result are wrong, and so is every
    exception that is no `IzoError`.

    Args:
        case: The step.
        known: What is known of it.

    Returns:
        Our outcome.
    """
    try:
        scene, result, seconds = _timed(case)
    except IzoError as error:
        status = type(error).__name__
        return [Outcome(RIGHT if status in known.statuses else SAYS_SO, status, note=str(error))]
    except MemoryError as error:
        return [Outcome(NO_ANSWER, "out of memory", note=str(error))]
    except Exception as error:  # whatever it is, it is no message to a user
        return [Outcome(WRONG, f"exception {type(error).__name__}", note=str(error))]
    status = result.status.name
    error = _error(result, known)
    refuted = _refuted(scene, result)
    if known.check is not None:
        refuted = refuted or known.check(result)
    if refuted:
        verdict = WRONG
    elif status not in known.statuses:
        verdict = SAYS_SO if result.status is not Status.FREE else WRONG
    else:
        verdict = RIGHT if error is None or error <= known.tolerance else WRONG
    violation = max((r.violation for r in result.residuals), default=0.0)
    condition = max(map(condition_number, _small_zones(result)), default=None)
    return [
        Outcome(
            verdict,
            status,
            OWN,
            error,
            violation,
            len(result.history),
            seconds,
            condition,
            refuted or known.note,
        )
    ]


def _timed(case: Case) -> tuple[Scene, Result, float]:
    """Resolve a step, and again if that was fast, so that compiling does not count."""
    scene, result, seconds = _run(case)
    return (scene, result, seconds) if seconds > REPEAT_BELOW_S else _run(case)


def _run(case: Case) -> tuple[Scene, Result, float]:
    begin = time.perf_counter()
    scene = case.scene()
    result = resolve(scene, case.thickness, options=Options(**case.options))
    return scene, result, time.perf_counter() - begin


def _error(result: Result, known: Known) -> float | None:
    scene = result.certificate.scene
    if known.positions is not None:
        off = np.abs(result.positions - known.positions).max(initial=0.0)
        size = np.abs(known.positions - scene.positions_t1).max(initial=0.0)
        return float(off / size) if size > 0.0 else float(off > 0.0)
    if known.objective is not None:
        if known.objective == 0.0:
            return 0.0 if result.objective == 0.0 else float("inf")
        return result.objective / known.objective - 1.0
    return None


def _refuted(scene: Scene, result: Result) -> str:
    """Return what is false of the result, in a sentence; an empty string if nothing is."""
    if not np.isfinite(result.positions).all():
        return "A position is not finite."
    if not (result.positions == scene.positions_t1)[scene.pinned].all():
        return "A pinned vertex does not end at its proposed position."
    if result.status.name not in CERTIFIED:
        return ""
    if len(scene.faces) > BRUTE_FACES:
        facts, _ = judge.path(scene, result.positions, Limits(seconds=30.0))
        failed = [fact.answer for fact in facts if fact.passed is False]
        return f"The path is not free: {failed[0]}." if failed else ""
    found = meeting_pairs(*_without_copies(scene, result))
    n = len(found.vertex_face) + len(found.edge_edge)
    if n and scene.touching is None:  # pairs that touch at the start meet at t = 0 by right
        return f"The path is not free: exact arithmetic finds {n} pairs that meet."
    return ""


def _without_copies(scene: Scene, result: Result) -> tuple[Positions, Positions, Faces]:
    """Return start, end and faces without the copies of welded vertices, which no face names."""
    start, end, faces = scene.positions_t0, result.positions, scene.faces
    if scene.copies is None:
        return start, end, faces
    own = scene.copies == np.arange(len(start))
    return start[own], end[own], (np.cumsum(own) - 1)[faces].astype(np.int32)


def _small_zones(result: Result) -> list[ZoneProblem]:
    """Return the problems of the zones that are small enough for dense algebra."""
    scene, zones = result.certificate.scene, result.zones
    sizes = np.diff(zones.impact_offsets)
    return [
        zone_problem(scene, result.impacts, zones, zone, result.thickness)
        for zone in np.flatnonzero(sizes <= CONDITION_IMPACTS)[:50].tolist()
    ]
