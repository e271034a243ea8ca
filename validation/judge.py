"""Judges of a result: the facts of `check`. No judge asks the solver that made the result.

Each function answers one question by one or two independent means and returns facts. The judges of
zones are in `judge_zones.py`.
"""

import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, ParamSpec, TypeAlias, TypeVar

import numpy as np

from izo_ref.app.summary import excluded_line, excluded_summary
from izo_ref.base.arrays import AnyInts, Positions
from izo_ref.base.records import ExcludedPairs, SceneArrays
from izo_ref.certificate.certify import PathCertificate, certify_path
from izo_ref.scene import Scene
from izo_ref.zones.objective import objective
from validation.limits import DEFAULT, Limits, NotDecidedError, limited
from validation.oracles import fcl, ipc
from validation.oracles import path as path_oracle
from validation.oracles.answer import mass_norm

Call = ParamSpec("Call")
Returned = TypeVar("Returned")
PairKey: TypeAlias = tuple[bool, frozenset[frozenset[int]]]  # a pair, whatever its order

NOT_DECIDED = "not decided"  # how the answer of a judge begins that needs more than its limits
PATH_BY_OTHERS = "ipctk Tight Inclusion, hits decided by flint"
# Hits of ipctk that are confirmed exactly, one by one.
HITS = 1000


class Fact(NamedTuple):
    """One line of the verdict."""

    question: str
    by: str  # who answers
    answer: str
    passed: bool | None  # None: the answer is for information, and cannot fail
    seconds: float


def _timed(
    call: Callable[Call, Returned], *args: Call.args, **kwargs: Call.kwargs
) -> tuple[Returned, float]:
    """Call a function and return its result and the seconds it took."""
    begin = time.perf_counter()
    answer = call(*args, **kwargs)
    return answer, time.perf_counter() - begin


def prescribed(scene: Scene, positions: Positions, saved: Any) -> Fact:
    """Judge whether pinned vertices end exactly at their proposed positions.

    Args:
        scene: The scene.
        positions: (n, 3) f8 [m], end of the path.
        saved: (n, 3), the same positions in the type that they were saved in. In float32 they are
            compared with the proposed positions that are rounded to it.
    """
    is_single = np.asarray(saved).dtype == np.float32
    proposed = scene.positions_t1.astype(np.float32) if is_single else scene.positions_t1
    off = np.flatnonzero((positions != proposed).any(axis=1) & scene.pinned)
    n_pinned = int(scene.pinned.sum())
    answer = f"all {n_pinned} do" + (", rounded to float32" if is_single and n_pinned else "")
    if len(off):
        answer = f"{len(off)} of {n_pinned} do not, the first is vertex {off[0]}"
    return Fact("pinned vertices end as prescribed", "comparison", answer, len(off) == 0, 0.0)


def asked(
    question: str, by: str, limits: Limits, judge: Callable[..., tuple[Any, ...]], *args: Any
) -> tuple[Fact, tuple[Any, ...] | None]:
    """Ask a judge within its limits.

    Args:
        question: What the judge is asked, for the fact.
        by: Who the judge is, for the fact.
        limits: Its limits.
        judge: Function of `args` that returns an answer in words, whether it accepts, and perhaps
            more.
        args: Its arguments.

    Returns:
        The fact, and what the judge returned; None if it did not decide.
    """
    begin = time.perf_counter()
    try:
        returned = limited(limits, judge, *args)
    except NotDecidedError as error:
        fact = Fact(question, by, f"{NOT_DECIDED}: {error}", None, time.perf_counter() - begin)
        return fact, None
    answer, passed = returned[:2]
    return Fact(question, by, answer, passed, time.perf_counter() - begin), returned


def path(
    scene: Scene, positions: Positions, limits: Limits = DEFAULT
) -> tuple[list[Fact], PathCertificate]:
    """Judge whether the path is free, by the package's certificate and by ipctk.

    Args:
        scene: The scene.
        positions: (n, 3) f8 [m], end of the path.
        limits: The limits of ipctk and of the exact oracle.

    Returns:
        Two facts, and the certificate.
    """
    certificate, seconds = _timed(certify_path, scene, positions)
    answer = "free" if certificate.free else f"{len(certificate.meeting_toi)} pairs meet"
    answer += (
        f"; {certificate.candidates} candidate pairs, {certificate.exact} of them decided by exact "
        "arithmetic"
    )
    if not certificate.free:
        answer += f"; the path is free until t = {certificate.time_free:.6g}"
    if certificate.excluded is not None:
        answer += f"; {excluded_line(excluded_summary(certificate))}"
    facts = [Fact("path is free", "izo_ref.certify_path", answer, certificate.free, seconds)]
    if ipc.unusable():
        answer = f"not asked: {ipc.unusable()}"
        facts.append(Fact("path is free", PATH_BY_OTHERS, answer, None, 0.0))
    else:
        ask = "path is free", PATH_BY_OTHERS, limits, _path_by_others, certificate
        facts.append(asked(*ask)[0])
    return facts, certificate


def _path_by_others(certificate: PathCertificate) -> tuple[str, bool]:
    """Judge the path by ipctk; the exact oracle decides each of its hits.

    Of the pairs that touch at the start, those that are not left out have to be apart afterwards,
    and the edges and faces that touch by them must not go through each other.
    """
    scene, positions = certificate.scene, certificate.positions
    start = scene.positions_t0
    own, edges, faces = _without_copies(scene)
    nodes, kinds, _, complete = ipc.path_hits(start[own], positions[own], edges, faces, HITS)
    nodes = own[nodes]
    excluded = _keys(certificate.excluded)
    met = alarms = left_out = 0
    for row, kind in zip(nodes, map(bool, kinds), strict=True):
        touches = path_oracle.meets(kind, start[row], start[row])
        meets = path_oracle.meets_after_start if touches else path_oracle.meets
        if _key(row, kind) in excluded:
            left_out += 1
        elif meets(kind, start[row], positions[row]):
            met += 1
        else:
            alarms += 1
    answer = "free" if met == 0 else f"{'' if complete else 'at least '}{met} pairs meet"
    if scene.touching is not None:
        through = sum(
            path_oracle.goes_through_after_start(start[row], positions[row])
            for row in scene.touching.edge_faces
        )
        n = len(scene.touching.nodes)
        answer += f"; {n} pairs touch at the start, {through} edges go through faces"
        met += through
    if alarms:
        answer += f"; {alarms} pairs come within the tolerance of ipctk, 1e-9, but do not meet"
    if left_out:
        answer += f"; {left_out} hits are pairs that were left out"
    # if the list is incomplete, the absence of a true hit proves nothing
    return answer, met == 0 and complete


def _without_copies(scene: SceneArrays) -> tuple[AnyInts, AnyInts, AnyInts]:
    """Return the vertices that are no copies, ascending, and edges and faces of their places.

    For ipctk, every vertex of a mesh takes part, so a copy would touch the faces at its place.
    """
    n = len(scene.pinned)
    if scene.copies is None:
        return np.arange(n), scene.edges, scene.faces
    own = np.unique(scene.copies)
    place = np.zeros(n, np.int32)
    place[own] = np.arange(len(own))
    return own, place[scene.edges], place[scene.faces]


def _key(nodes: AnyInts, is_edge_edge: bool) -> PairKey:
    """Return a key that does not depend on the order of edges, ends and corners."""
    vertices = [int(v) for v in nodes]
    split = 2 if is_edge_edge else 1
    sides = frozenset(vertices[:split]), frozenset(vertices[split:])
    return bool(is_edge_edge), frozenset(sides)


def _keys(pairs: ExcludedPairs | None) -> set[PairKey]:
    if pairs is None:
        return set()
    return {_key(row, kind) for row, kind in zip(pairs.nodes, pairs.is_edge_edge, strict=True)}


def end(certificate: PathCertificate, limits: Limits = DEFAULT) -> tuple[list[Fact], AnyInts]:
    """Judge whether the mesh is free of intersections at the end, by python-fcl and by ipctk.

    If pairs were left out, the answers are for information.

    Args:
        certificate: The certificate of the path, with its scene and its end.
        limits: The limits of each of the two.

    Returns:
        Two facts, and (k, 2) int, the pairs of faces that intersect; none if python-fcl did not
        decide.
    """
    by_fcl, found = asked("end is free", "python-fcl", limits, _end_by_fcl, certificate)
    crossing = np.empty((0, 2), np.int64) if found is None else found[2]
    if ipc.unusable():
        by_ipctk = Fact("end is free", "ipctk", f"not asked: {ipc.unusable()}", None, 0.0)
    else:
        by_ipctk, _ = asked("end is free", "ipctk", limits, _end_by_ipctk, certificate)
    return [by_fcl, by_ipctk], crossing


def _end_by_fcl(certificate: PathCertificate) -> tuple[str, bool | None, AnyInts]:
    crossing = fcl.crossing_faces(certificate.positions, certificate.scene.faces)
    free, judged = len(crossing) == 0, certificate.excluded is None
    answer = "free" if free else f"{len(crossing)} pairs of faces intersect"
    return answer, free if judged else None, crossing


def _end_by_ipctk(certificate: PathCertificate) -> tuple[str, bool | None]:
    scene = certificate.scene
    found = ipc.has_intersections(certificate.positions, scene.edges, scene.faces)
    answer = "the mesh intersects itself" if found else "free"
    return answer, not found if certificate.excluded is None else None


def nearness(
    scene: Scene, positions: Positions, known: Mapping[str, Positions]
) -> tuple[Fact, dict[str, float]]:
    """Compare the objective of a result with the best one known.

    Args:
        scene: The scene.
        positions: (n, 3) f8 [m], end of the path.
        known: `{name: positions}` of results that are certified free.

    Returns:
        A fact for information, and `{name: objective}` [m^2] of the known results.
    """
    values = {name: objective(scene, other) for name, other in known.items()}
    own = objective(scene, positions)
    if not values:
        return Fact("close to the proposal", "objective", f"{own:.6e} m^2", None, 0.0), values
    best = min(values, key=lambda name: values[name])
    masses = np.where(scene.pinned, np.inf, scene.masses)
    # half of each difference, because the whole may overflow
    size = mass_norm(masses, 0.5 * known[best] - 0.5 * scene.positions_t1)
    away = mass_norm(masses, 0.5 * positions - 0.5 * known[best])
    apart = away / size if size > 0.0 else 0.0
    ratio = own / values[best] if values[best] > 0.0 else float(own == 0.0)
    answer = (
        f"the objective is {own:.6e} m^2, {ratio:.6f} of that of the best known free result "
        f"({best}); the mass-weighted distance to that result is {apart:.2e} of its distance to "
        "the proposed positions"
    )
    return Fact("close to the proposal", "objective", answer, None, 0.0), values
