"""Judge a result: which of its claims are not true.

Each function returns a line for each violation, whose words before the first colon say which rule
it breaks. The rules are those of docs/method/7-statuses.md, docs/certificates.md and
docs/limits.md.
"""

from typing import Any

import numpy as np

from izo_ref import Scene, resolve
from izo_ref.base.records import Impacts, Status
from izo_ref.certificate.certify import certify_path
from izo_ref.loop.resolve import Result
from validation.stability_steps.exact import keys_of

LARGEST = np.finfo(float).max
SUM_ROUNDING = 1e-12  # of an objective, relative: 2^-53 for each of up to some thousand terms


def judge_result(scene: Scene, result: Result) -> list[str]:
    """Judge everything that needs no oracle."""
    wrong = finite(result) + consistent(scene, result) + prescribed(scene, result)
    wrong += objective(scene, result)
    fresh = certify_path(scene, result.positions.copy(), result.options.rules)
    if fresh.free != result.certificate.free or fresh.time_free != result.time_free:
        wrong.append(f"fresh certificate: free {fresh.free}, {result.certificate.free} was said")
    if keys_of(fresh.meeting) != keys_of(result.certificate.meeting):
        wrong.append("fresh certificate: other pairs meet")
    return wrong


def finite(result: Result) -> list[str]:
    """Judge that numbers are numbers; objectives and residuals may be infinite where documented."""
    wrong = []
    arrays: dict[str, Any] = {
        "positions": result.positions,
        "multipliers": result.multipliers,
        "toi": result.impacts.toi,
        "weights": result.impacts.weights,
        "normals": result.impacts.normals,
        "meeting_toi": result.certificate.meeting_toi,
        "time_free": result.time_free,
        "thickness": result.thickness,
        "timings": list(result.timings.values()),
        "scales": [part.scale for part in result.scaled_back],
    }
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            wrong.append(f"not finite: {name}")
    may_be_infinite = {
        "objective": result.objective,
        "residuals": [tuple(r) for r in result.residuals],
        "history": [line.objective for line in result.history],
    }
    for name, array in may_be_infinite.items():
        values = np.asarray(array, float)
        if np.isnan(values).any() or (values < 0.0).any():
            wrong.append(f"not a number >= 0: {name}")
    wrong += _frames(result.impacts)
    return wrong


def _frames(impacts: Impacts) -> list[str]:
    """Judge that normals are unit vectors, weights sum to zero and times are on the path."""
    wrong = []
    lengths = np.linalg.norm(impacts.normals, axis=1)
    if (np.abs(lengths - 1.0) > 1e-12).any():
        wrong.append(f"normals: length {lengths[np.argmax(np.abs(lengths - 1.0))]!r}")
    if (np.abs(impacts.weights.sum(axis=1)) > 1e-14).any():
        wrong.append("weights: do not sum to zero")
    if ((impacts.toi < 0.0) | (impacts.toi > 1.0)).any():
        wrong.append("times of impact: outside of [0, 1]")
    return wrong


def consistent(scene: Scene, result: Result) -> list[str]:
    """Judge that status, flags, zone statuses, times and excluded pairs agree."""
    certificate, status = result.certificate, result.status
    wrong = []
    options = result.options
    solved = [
        r.solved(options.gap_tolerance, options.violation_tolerance) for r in result.residuals
    ]
    meets = len(certificate.meeting_toi) > 0
    if not certificate.free:
        right = Status.BLOCKED
    elif certificate.excluded is not None:
        right = Status.FREE_EXCEPT_EXCLUDED
    else:
        best = all(solved) and not result.scaled_back
        right = Status.FREE if best else Status.FREE_BY_FALLBACK
    if status is not right:
        wrong.append(f"status: {status.name}, expected {right.name}")
    if certificate.free is meets or (result.time_free == 1.0) is not certificate.free:
        first = certificate.meeting_toi.min(initial=2.0)
        if certificate.free or first != 1.0:
            wrong.append(f"time_free: {result.time_free!r} with {meets=}")
    if not 0.0 <= result.time_free <= 1.0:
        wrong.append(f"time_free: {result.time_free!r}")
    if result.converged and not (certificate.free and all(solved)):
        wrong.append("converged: not every zone is solved")
    if len(result.zone_statuses) != len(result.zones):
        wrong.append("zone statuses: not one for each zone")
    if status is Status.FREE and any(zone is not Status.FREE for zone in result.zone_statuses):
        wrong.append("zone statuses: a zone of a FREE result is not FREE")
    if keys_of(scene.excluded) - keys_of(certificate.excluded):
        wrong.append("excluded: pairs of the scene are missing")
    return wrong


def prescribed(scene: Scene, result: Result) -> list[str]:
    """Judge that pinned and untouched vertices end where they are proposed to, bit for bit."""
    moved = (result.positions.view(np.int64) != scene.positions_t1.view(np.int64)).any(axis=1)
    wrong = []
    blocks = scene.prescribed == "block" and result.certificate.meeting_prescribed.any()
    if (moved & scene.pinned).any() and not blocks:
        wrong.append(f"pinned: vertex {np.flatnonzero(moved & scene.pinned)[0]} is elsewhere")
    may_move = np.zeros(len(moved), bool)
    may_move[result.impacts.nodes] = True
    for part in result.scaled_back:
        may_move[part.vertices] = True
    if result.status is Status.BLOCKED:
        may_move[:] = True  # the groups that are blocked stop on their way
    if scene.copies is not None:
        may_move = may_move[scene.copies]
    off = np.flatnonzero(moved & ~may_move)
    if len(off):
        wrong.append(f"untouched: vertex {off[0]} is elsewhere")
    if scene.copies is not None:
        apart = (result.positions != result.positions[scene.copies]).any()
        wrong += ["copies: one is not at its vertex"] if apart else []
    return wrong


def objective(scene: Scene, result: Result) -> list[str]:
    """Judge the objective, in numbers of 80 bits, whose exponents have room for all lengths."""
    own = ~scene.pinned & (scene.masses > 0.0)
    masses = scene.masses[own].astype(np.longdouble)
    away = result.positions[own].astype(np.longdouble) - scene.positions_t1[own]
    if not own.any():
        return [] if result.objective == 0.0 else ["objective: not 0, although all is pinned"]
    right = (masses[:, None] * away**2).sum() / masses.sum()
    if right > LARGEST:
        ok = np.isinf(result.objective)
    else:
        # below the smallest number with all digits, the result is rounded to a multiple of 2^-1074
        ok = abs(result.objective - right) <= SUM_ROUNDING * right + np.longdouble(2.0) ** -1073
    return [] if ok else [f"objective: {result.objective!r}, expected {right!r}"]


def again(scene: Scene, result: Result, thickness: float | None, options: Any) -> list[str]:
    """Judge that the result is its own answer: from the same start, it is proposed and kept."""
    if not result.certificate.free or scene.unwelded:
        return []
    second = Scene(
        scene.positions_t0,
        result.positions,
        scene.faces,
        scene.masses,
        scene.pinned,
        initial_intersections=scene.initial_intersections,
        prescribed=scene.prescribed,
    )
    if keys_of(second.excluded) != keys_of(scene.excluded):
        return []  # after a step with excluded pairs, fewer pairs are left out than in a new scene
    found = resolve(second, thickness, options=options)
    if (found.positions != result.positions).any():
        n = int((found.positions != result.positions).any(axis=1).sum())
        return [f"resolved again: {n} vertices move, {found.status.name}"]
    return []
