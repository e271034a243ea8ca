"""`python -m validation check`: the verdict on a result of a step, whichever program made it.

A result passes if its path is free, its end is free, its pinned vertices end as prescribed and, if
the file says which zones it has, each zone is optimal. The verdict also reports how far the result
is from the best free result that is known.
"""

import dataclasses
import os
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np

from izo_ref.app.files import SavedResult, load_result, load_scene
from izo_ref.app.summary import excluded_line, excluded_summary, pairs_summary
from izo_ref.base import checks
from izo_ref.base.arrays import AnyInts, Positions, Times
from izo_ref.base.errors import FileFormatError
from izo_ref.base.options import Options
from izo_ref.base.records import Impacts, Pairs
from izo_ref.base.sizes import positions_back, scene_in_range, thickness_in_range
from izo_ref.base.units import Units, times_power
from izo_ref.certificate.certify import certify_path
from izo_ref.loop.resolve import Result, resolve
from izo_ref.scene import Scene
from validation import judge, judge_zones
from validation.in_range import result_in_range
from validation.judge import Fact
from validation.limits import DEFAULT, Limits

FilePath: TypeAlias = str | os.PathLike[str]
SayFact: TypeAlias = Callable[[Fact], object]


@dataclasses.dataclass(frozen=True)
class Verdict:
    """What `check` found.

    Attributes:
        passed: Nothing that was judged is wrong. Judges that did not decide say nothing.
        facts: The answers, in the order in which they were found.
        meeting: Pairs that meet on the path.
        meeting_toi: (k,) f8, from 0 to 1, when these pairs meet.
        crossing: (k, 2) int, pairs of faces that intersect at the end.
        positions: (n, 3) f8 [m], the end positions that were judged.
        objectives: `{name: objective}` [m^2] of the results that it was compared with.
        thickness: [m], of our own result.
        excluded: Summary of the pairs that were left out, as `excluded_summary` returns it.
    """

    passed: bool
    facts: list[Fact]
    meeting: Pairs
    meeting_toi: Times
    crossing: AnyInts
    positions: Positions
    objectives: dict[str, float]
    thickness: float | None
    excluded: dict[str, Any]

    @property
    def n_not_decided(self) -> int:
        """Number of judges that needed more time or memory than they may use."""
        return sum(fact.answer.startswith(judge.NOT_DECIDED) for fact in self.facts)


def check(
    scene: Scene,
    result: SavedResult | None,
    thickness: float | None = None,
    options: Options | None = None,
    *,
    say: SayFact | None = None,
    known: Mapping[str, Positions] | None = None,
    own: Result | None = None,
    limits: Limits = DEFAULT,
) -> Verdict:
    """Judge a result of a step.

    Args:
        scene: The step.
        result: The result to judge; None judges the result of `izo_ref.resolve`.
        thickness: [m], used for our own result. None takes the thickness of `result`, or the
            default if that has none.
        options: Options of our own result and tolerances of the zones; defaults if None.
        say: Is called with each `Fact` as soon as it is found.
        known: `{name: positions}` of other results; the free ones are compared with the result.
        own: The result of `izo_ref.resolve`, if the caller already has it.
        limits: Time and memory of each judge that is not of this package.

    Returns:
        The verdict.

    Raises:
        ShapeError: The positions of the result do not fit the scene.
        NonFiniteError: A position of the result is not finite.
        SizeError: A position, or a weight or normal of an impact, is too large or too small to
            compute with.
    """
    options = options or Options()
    if thickness is None and result is not None:
        thickness = result.thickness
    twin, units = scene_in_range(scene)
    if twin is not scene:
        if thickness is not None:
            thickness = thickness_in_range(checks.thickness(thickness), twin, units)
        result, known = result_in_range(scene, twin, units, result, known)
        verdict = check(twin, result, thickness, options, say=say, known=known, limits=limits)
        return _in_units(verdict, scene, twin, units)
    begin = time.perf_counter()
    own = own or resolve(scene, thickness, options=options)
    seconds = time.perf_counter() - begin
    facts: list[Fact] = []

    def add(*new: Fact) -> None:
        facts.extend(new)
        if say is not None:
            for fact in new:
                say(fact)

    add(Fact("own result", "izo_ref.resolve", _own_answer(own), None, seconds))
    if result is None:
        result = SavedResult(own.positions, own.thickness, own.impacts, own.multipliers)
    positions = checks.floats("positions", result.positions, scene.positions_t0.shape)
    add(judge.prescribed(scene, positions, result.positions))
    path_facts, certificate = judge.path(scene, positions, limits)
    add(*path_facts)
    end_facts, crossing = judge.end(certificate, limits)
    add(*end_facts)
    if result.impacts is None:
        answer = "not judged: the file holds no impacts and multipliers"
        add(Fact("each zone is optimal", "izo_ref.residuals", answer, None, 0.0))
    else:
        add(*judge_zones.zones(scene, result, options, limits))
    nearness, objectives = judge.nearness(scene, positions, _free_results(scene, own, known))
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
        excluded=excluded_summary(certificate),
    )


def _in_units(verdict: Verdict, scene: Scene, twin: Scene, units: Units) -> Verdict:
    """Return the verdict on a scene of ordinary size in the units of the caller.

    The facts stay: their numbers are those of the scene of ordinary size, and one fact says so.
    """
    told = Fact(
        "size",
        "powers of two",
        f"every fact is about lengths times 2^{units.length} and masses times 2^{units.mass}",
        None,
        0.0,
    )
    thickness = verdict.thickness
    return dataclasses.replace(
        verdict,
        facts=[told, *verdict.facts],
        positions=positions_back(scene, twin, verdict.positions, units),
        objectives={
            name: times_power(value, -2 * units.length)
            for name, value in verdict.objectives.items()
        },
        thickness=None if thickness is None else times_power(thickness, -units.length),
    )


def _free_results(
    scene: Scene, own: Result, known: Mapping[str, Positions] | None
) -> dict[str, Positions]:
    """Return our own result and the known ones, without those whose path is not free."""
    free = {"izo_ref.resolve": own.positions} if own.certificate.free else {}
    known = known or {}
    return free | {name: end for name, end in known.items() if certify_path(scene, end).free}


def _own_answer(own: Result) -> str:
    return (
        f"{own.status.name}, the objective is {own.objective:.6e} m^2 at a thickness of "
        f"{own.thickness:g} m, with {len(own.impacts.toi)} impacts in {len(own.zones)} zones"
    )


def check_files(
    step: FilePath,
    result: FilePath | None = None,
    thickness: float | None = None,
    modes: Mapping[str, Any] | None = None,
    say: SayFact | None = None,
    known: Iterable[FilePath] = (),
    limits: Limits = DEFAULT,
) -> tuple[Scene, Verdict]:
    """Judge a result that is in a file, by `check`.

    Args:
        step: File of the step.
        result: File of the result; None judges the result of `izo_ref.resolve`.
        thickness: [m], as for `check`.
        modes: Keyword arguments of `Scene`, such as `prescribed`; its defaults if None.
        say: As for `check`.
        known: Files of other results.
        limits: As for `check`.

    Returns:
        The scene and the verdict.

    Raises:
        FileFormatError: A file cannot be read, or lacks an array.
        IzoError: The step or the result is not valid.
    """
    scene = load_scene(step, **(modes or {}))
    loaded = None if result is None else load_result(result)
    if loaded is not None and loaded.impacts is not None:
        loaded = loaded._replace(impacts=_checked(loaded, loaded.impacts, scene, result))
    shape = scene.positions_t0.shape
    others = {
        str(path): checks.floats(f"{path}: positions", load_result(path).positions, shape)
        for path in known
    }
    return scene, check(scene, loaded, thickness, say=say, known=others, limits=limits)


def _checked(result: SavedResult, impacts: Impacts, scene: Scene, path: FilePath | None) -> Impacts:
    """Return the impacts of a file, with their types and shapes checked."""
    n = len(impacts.toi)
    if result.thickness is None:
        raise FileFormatError(f"{path}: holds impacts, but no thickness")
    checks.floats("multipliers", result.multipliers, (n,))
    nodes = checks.indices("impact_nodes", impacts.nodes, 4, len(scene.pinned))
    off = np.flatnonzero((np.diff(np.sort(nodes, axis=1), axis=1) == 0).any(axis=1))
    if len(off):
        raise FileFormatError(
            f"{path}: impact_nodes: expected four different vertices for each impact, found "
            f"{len(off)} impacts with others, the first is row {off[0]}: {nodes[off[0]].tolist()}"
        )
    return impacts._replace(
        nodes=nodes,
        is_edge_edge=checks.flags("impact_is_edge_edge", impacts.is_edge_edge, n),
        toi=checks.floats("impact_toi", impacts.toi, (n,)),
        weights=checks.floats("impact_weights", impacts.weights, (n, 4)),
        normals=checks.floats("impact_normals", impacts.normals, (n, 3)),
    )


def verdict_line(verdict: Verdict) -> str:
    """Return the verdict in a line: passed or failed, what was left out, and who did not decide."""
    line, n = "passed" if verdict.passed else "failed", verdict.n_not_decided
    if verdict.excluded["count"]:
        line += f", except for pairs about which nothing is said; {excluded_line(verdict.excluded)}"
    if n:
        line += f"; {n} {'judge' if n == 1 else 'judges'} did not decide within the limits"
    return line


def verdict_summary(verdict: Verdict) -> dict[str, Any]:
    """Return everything of a verdict but the arrays, ready for JSON."""
    return {
        "passed": verdict.passed,
        "not_decided": verdict.n_not_decided,
        "excluded": verdict.excluded,
        "thickness_m": verdict.thickness,
        "facts": [fact._asdict() for fact in verdict.facts],
        "meeting": pairs_summary(verdict.meeting, verdict.meeting_toi),
        "crossing_faces": {
            "count": len(verdict.crossing),
            "first": verdict.crossing[:20].tolist(),
        },
        "objectives_m2": verdict.objectives,
    }
