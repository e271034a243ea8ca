"""Judges of a result that ask no solver for its opinion: the facts of `check`.

Each function looks at one thing, by one or two independent means, and returns facts.
"""

import time
from typing import NamedTuple

import numpy as np

from izo_ref.base.options import Options
from izo_ref.certificate.certify import certify_path
from izo_ref.zones.distance import distance_bound
from izo_ref.zones.grouping import build_zones
from izo_ref.zones.objective import objective
from izo_ref.zones.problem import residuals
from izo_ref.zones.system import zone_problem
from validation.oracles import fcl, ipc, nnls, qp, slsqp
from validation.oracles import path as exact_path
from validation.oracles.answer import mass_norm
from validation.oracles.rational import ExactZone, active_rows

# Impacts of a zone up to which an oracle is asked. A zone of that size then takes each of
# them 0.3 s at most: `reports/zones`, where their times are measured.
LIMITS = {"exact": 64, "NNLS": 256, "SLSQP": 64}
# Zones that are given to each oracle, the largest first.
ZONES_ASKED = 50
PATH_BY_OTHERS = "ipctk Tight Inclusion, hits decided by flint"
# Hits of ipctk that are confirmed exactly, one by one.
HITS = 1000


class Fact(NamedTuple):
    """One line of the verdict."""

    question: str
    by: str  # who was asked
    answer: str
    passed: bool | None  # None: nothing to pass, for information
    seconds: float


def _timed(call, *args):
    begin = time.perf_counter()
    answer = call(*args)
    return answer, time.perf_counter() - begin


def prescribed(scene, positions) -> Fact:
    """Do pinned vertices end where they have to?"""
    off = np.flatnonzero((positions != scene.positions_t1).any(axis=1) & scene.pinned)
    answer = (
        f"all {int(scene.pinned.sum())}"
        if len(off) == 0
        else (f"{len(off)} of {int(scene.pinned.sum())} do not, the first {off[0]}")
    )
    return Fact("pinned vertices end as prescribed", "comparison", answer, len(off) == 0, 0.0)


def path(scene, positions):
    """Is the path free, by the package's certificate and by ipctk with an exact oracle?"""
    certificate, seconds = _timed(certify_path, scene, positions)
    answer = f"{len(certificate.meeting_toi)} pairs meet" if not certificate.free else "free"
    answer += f"; {certificate.candidates} candidate pairs, {certificate.exact} decided exactly"
    if not certificate.free:
        answer += f"; free until t = {certificate.time_free:.6g}"
    facts = [Fact("path is free", "izo_ref.certify_path", answer, certificate.free, seconds)]
    facts.append(_path_by_others(scene, positions))
    return facts, certificate


def _path_by_others(scene, positions):
    if ipc.unusable():
        return Fact("path is free", PATH_BY_OTHERS, f"not asked: {ipc.unusable()}", None, 0.0)
    begin = time.perf_counter()
    nodes, kinds, _, complete = ipc.path_hits(
        scene.positions_t0, positions, scene.edges, scene.faces, HITS
    )
    excluded = _excluded_keys(scene)
    met = alarms = left_out = 0
    for row, is_edge_edge in zip(nodes, kinds, strict=True):
        if _key(row, is_edge_edge) in excluded:
            left_out += 1
        elif exact_path.meets(bool(is_edge_edge), scene.positions_t0[row], positions[row]):
            met += 1
        else:
            alarms += 1
    answer = "free" if met == 0 else f"{'' if complete else 'at least '}{met} pairs meet"
    if alarms:
        answer += f"; {alarms} come closer than 1e-9 of ipctk's tolerance, without meeting"
    if left_out:
        answer += f"; {left_out} that intersect at the start left out"
    # an incomplete list without a true hit would prove nothing
    passed = met == 0 and complete
    seconds = time.perf_counter() - begin
    return Fact("path is free", PATH_BY_OTHERS, answer, passed, seconds)


def _key(nodes, is_edge_edge):
    nodes = [int(v) for v in nodes]
    if is_edge_edge:
        return frozenset((frozenset(nodes[:2]), frozenset(nodes[2:])))
    return nodes[0], frozenset(nodes[1:])


def _excluded_keys(scene):
    if scene.excluded is None:
        return set()
    return {_key(row, kind) for row, kind in zip(*scene.excluded, strict=True)}


def end(scene, positions):
    """Is the end free of intersections? Pairs that cross from the start are not judged."""
    crossing, seconds = _timed(fcl.crossing_faces, positions, scene.faces)
    judged = scene.excluded is None
    answer = "free" if len(crossing) == 0 else f"{len(crossing)} pairs of faces intersect"
    facts = [
        Fact("end is free", "python-fcl", answer, len(crossing) == 0 if judged else None, seconds)
    ]
    if ipc.unusable():
        facts.append(Fact("end is free", "ipctk", f"not asked: {ipc.unusable()}", None, 0.0))
        return facts, crossing
    found, seconds = _timed(ipc.has_intersections, positions, scene.edges, scene.faces)
    answer = "intersects" if found else "free"
    facts.append(Fact("end is free", "ipctk", answer, not found if judged else None, seconds))
    return facts, crossing


def zones(scene, result, options: Options):
    """Is each zone optimal? For results that come with their impacts and multipliers."""
    begin = time.perf_counter()
    grouped = build_zones(scene, result.impacts)
    rows = []
    for zone in range(len(grouped)):
        own = grouped.impacts_of(zone)
        vertices = np.unique(result.impacts.nodes[own])
        problem = zone_problem(scene, result.impacts, grouped, zone, result.thickness)
        positions, multipliers = result.positions[vertices], result.multipliers[own]
        judged = residuals(problem, positions, multipliers)
        length = mass_norm(problem.masses, positions - problem.proposed)
        bound = distance_bound(problem, positions, multipliers)
        rows.append(
            {
                "problem": problem,
                "positions": positions,
                "multipliers": multipliers,
                "impacts": len(own),
                "gap": judged.gap,
                "violation": judged.violation,
                "solved": judged.solved(options.gap_tolerance, options.violation_tolerance),
                "distance": bound / length if length > 0.0 else (0.0 if bound == 0.0 else np.inf),
            }
        )
    seconds = time.perf_counter() - begin
    if not rows:
        return [Fact("each zone is optimal", "izo_ref.residuals", "no zones", True, seconds)], rows
    worst = {name: max(row[name] for row in rows) for name in ("gap", "violation", "distance")}
    unsolved = sum(not row["solved"] for row in rows)
    answer = (
        f"{len(rows)} zones, {unsolved} not to tolerance; largest relative gap "
        f"{worst['gap']:.1e}, violation over thickness {worst['violation']:.1e}, proved relative "
        f"distance to the optimum {worst['distance']:.1e}"
    )
    facts = [Fact("each zone is optimal", "izo_ref.residuals", answer, unsolved == 0, seconds)]
    facts += [_zones_by(name, rows) for name in ("exact", "NNLS", "SLSQP", "PIQP")]
    return facts, rows


def _zones_by(oracle, rows):
    """The zones' answers against an oracle's; the relative distance is told, not judged
    where the oracle is not exact: it may be the oracle's."""
    chosen = sorted(rows, key=lambda row: -row["impacts"])
    chosen = [row for row in chosen if row["impacts"] <= LIMITS.get(oracle, np.inf)][:ZONES_ASKED]
    begin = time.perf_counter()
    errors = [_relative_error(oracle, row) for row in chosen]
    seconds = time.perf_counter() - begin
    failed = sum(error is None for error in errors)
    worst = max((error for error in errors if error is not None), default=0.0)
    answer = f"largest relative distance {worst:.1e}, over {len(chosen)} of {len(rows)} zones"
    if failed:
        answer += f"; no answer for {failed}"
    # a relative gap of 1e-9 is a relative distance of sqrt(1e-9) = 3.2e-5 at most, if the
    # rows hold; what they may be violated by comes on top
    passed = failed == 0 and worst <= 1e-4 if oracle == "exact" and chosen else None
    names = {"exact": "exact rational arithmetic", "SLSQP": "SLSQP, scaled"}
    return Fact("zones agree with an oracle", names.get(oracle, oracle), answer, passed, seconds)


def _relative_error(oracle, row):
    problem = row["problem"]
    if oracle == "exact":
        return _exact_error(problem, row)
    solvers = {
        "NNLS": nnls.solve,
        "SLSQP": slsqp.solve_scaled,
        "PIQP": lambda problem: qp.solve(problem, "piqp"),
    }
    answer = solvers[oracle](problem)
    if not np.isfinite(answer.displacements).all():
        return None
    offsets = row["positions"] - problem.proposed - answer.displacements
    size = mass_norm(problem.masses, answer.displacements)
    error = mass_norm(problem.masses, offsets)
    return error / size if size > 0.0 else float(error > 0.0)


def _exact_error(problem, row):
    zone = ExactZone(problem)
    optimum = zone.solve(active_rows(row["multipliers"]))
    return None if optimum is None else zone.relative_error(zone.moves(row["positions"]), optimum)


def nearness(scene, positions, known):
    """How far is it from the best known? `known`: {name: positions}, certified free.

    Returns:
        Fact, and {name: objective}.
    """
    values = {name: objective(scene, other) for name, other in known.items()}
    own = objective(scene, positions)
    if not values:
        return Fact("close to the proposal", "objective", f"{own:.6e} m^2", None, 0.0), values
    best = min(values, key=values.get)
    masses = np.where(scene.pinned, np.inf, scene.masses)
    size = mass_norm(masses, known[best] - scene.positions_t1)
    apart = mass_norm(masses, positions - known[best]) / size if size > 0.0 else 0.0
    ratio = own / values[best] if values[best] > 0.0 else float(own == 0.0)
    answer = (
        f"objective {own:.6e} m^2, {ratio:.6f} of the best known free one ({best}); mass-weighted "
        f"distance to it {apart:.2e} of its distance to the proposal"
    )
    return Fact("close to the proposal", "objective", answer, None, 0.0), values
