"""`python -m validation check`: the verdict on a result, anybody's.

A result is free if its path and its end are, optimal if its zones are. What it costs to be
told apart is said too: how far it is from the closest free result known.
"""

import dataclasses
import time

import numpy as np

from izo_ref.app.files import SavedResult, load_result, load_scene
from izo_ref.app.summary import pairs_summary
from izo_ref.base import checks
from izo_ref.base.errors import FileFormatError
from izo_ref.base.options import Options
from izo_ref.base.records import Pairs
from izo_ref.certificate.certify import certify_path
from izo_ref.loop.resolve import resolve
from validation import judge


@dataclasses.dataclass(frozen=True)
class Verdict:
    """What `check` found.

    Attributes:
        passed: nothing that was judged is wrong.
        facts: list of `judge.Fact`.
        meeting, meeting_toi: `Pairs` that meet on the path, and when.
        crossing: (k, 2) pairs of faces that intersect at the end.
        positions: (n, 3) [m], what was judged.
        objectives: {name: [m^2]}, of the results it was compared with.
        thickness: [m].
    """

    passed: bool
    facts: list
    meeting: Pairs
    meeting_toi: np.ndarray
    crossing: np.ndarray
    positions: np.ndarray
    objectives: dict
    thickness: float | None


def check(
    scene,
    result: SavedResult | None,
    thickness=None,
    options=None,
    *,
    say=None,
    known=None,
    own=None,
):
    """Judge a result of a step.

    Args:
        scene: `Scene`.
        result: `SavedResult`; None takes that of `izo_ref.resolve`.
        thickness: [m], of our own result; None takes that of `result`, or the default.
        options: `Options`.
        say: called with each `Fact` as it is found.
        known: {name: positions} of other results to compare with, if they are free.
        own: `Result` of `izo_ref.resolve`, if it is there already.

    Returns:
        `Verdict`.

    Raises:
        ShapeError, NonFiniteError: of the result's positions.
    """
    options = options or Options()
    if thickness is None and result is not None:
        thickness = result.thickness
    begin = time.perf_counter()
    own = own or resolve(scene, thickness, options=options)
    seconds = time.perf_counter() - begin
    facts = []

    def add(*new):
        facts.extend(new)
        for fact in new if say else ():
            say(fact)

    add(judge.Fact("own result", "izo_ref.resolve", _own_answer(own), None, seconds))
    if result is None:
        result = SavedResult(own.positions, own.thickness, own.impacts, own.multipliers)
    positions = checks.floats("positions", result.positions, scene.positions_t0.shape)
    add(judge.prescribed(scene, positions))
    path_facts, certificate = judge.path(scene, positions)
    add(*path_facts)
    end_facts, crossing = judge.end(scene, positions)
    add(*end_facts)
    if result.impacts is None:
        answer = "not judged: the file holds no impacts and multipliers"
        add(judge.Fact("each zone is optimal", "izo_ref.residuals", answer, None, 0.0))
    else:
        add(*judge.zones(scene, result, options)[0])
    free = {"izo_ref.resolve": own.positions} if own.certificate.free else {}
    free |= {
        name: other for name, other in (known or {}).items() if certify_path(scene, other).free
    }
    nearness, objectives = judge.nearness(scene, positions, free)
    add(nearness)
    return Verdict(
        passed=all(fact.passed is not False for fact in facts),
        facts=facts,
        meeting=certificate.meeting,
        meeting_toi=certificate.meeting_toi,
        crossing=crossing,
        positions=positions,
        objectives=objectives,
        thickness=own.thickness,
    )


def _own_answer(own):
    return (
        f"{own.status.name}, objective {own.objective:.6e} m^2 at thickness {own.thickness:g} m, "
        f"{len(own.impacts.toi)} impacts in {len(own.zones)} zones"
    )


def check_files(
    step, result=None, thickness=None, initial_intersections="raise", say=None, known=()
):
    """`check` on files.

    Args:
        step: path of a step.
        result: path of a result, or None.
        known: paths of other results.

    Returns:
        `Scene`, `Verdict`.
    """
    scene = load_scene(step, initial_intersections)
    loaded = None if result is None else load_result(result)
    if loaded is not None and loaded.impacts is not None:
        loaded = loaded._replace(impacts=_checked(loaded, scene, result))
    others = {str(path): load_result(path).positions for path in known}
    return scene, check(scene, loaded, thickness, say=say, known=others)


def _checked(result, scene, path):
    """The impacts of a file in the types and shapes they have to have."""
    impacts, n = result.impacts, len(result.impacts.toi)
    if result.thickness is None:
        raise FileFormatError(f"{path}: holds impacts, but no thickness")
    checks.floats("multipliers", result.multipliers, (n,))
    return impacts._replace(
        nodes=checks.indices("impact_nodes", impacts.nodes, 4, len(scene.pinned)),
        is_edge_edge=checks.flags("impact_is_edge_edge", impacts.is_edge_edge, n),
        toi=checks.floats("impact_toi", impacts.toi, (n,)),
        weights=checks.floats("impact_weights", impacts.weights, (n, 4)),
        normals=checks.floats("impact_normals", impacts.normals, (n, 3)),
    )


def verdict_summary(verdict: Verdict) -> dict:
    """Everything but the arrays, ready for JSON."""
    return {
        "passed": verdict.passed,
        "thickness_m": verdict.thickness,
        "facts": [fact._asdict() for fact in verdict.facts],
        "meeting": pairs_summary(verdict.meeting, verdict.meeting_toi),
        "crossing_faces": {
            "count": len(verdict.crossing),
            "first": verdict.crossing[:20].tolist(),
        },
        "objectives_m2": verdict.objectives,
    }
