"""What is known of a scene: the pairs that meet, exactly, and the recorded answer.

The pairs come from `validation/oracles/pairs.py`, which does not use izo_ref. The answer is that
of izo_ref: the loop is not convex, so there is no independent optimum of a whole step. Around
it are facts that izo_ref did not decide: whether the exact oracle finds the path to the answer
free, and what two other solvers take for the optimum of the zone of all impacts.
"""

from itertools import pairwise
from typing import Any

import numpy as np

from validation.oracles.pairs import MeetingPairs, meeting_pairs

SOLVERS = ("piqp", "clarabel")
AGREEMENT = 1e-8  # relative; optima of the two solvers that differ by more are not recorded
DIGITS = 9  # of recorded numbers; renumbering the vertices changes the sixteenth


def pairs_of(arrays) -> tuple[dict[str, np.ndarray], list[MeetingPairs]]:
    """Find the pairs that meet in a scene.

    Args:
        arrays: those of a step or of a sequence.

    Returns:
        The arrays to store, and the pairs of each step. A sequence of f frames has f - 1 steps:
        from each frame straight to the next. The arrays then say in which step a pair meets.
    """
    if "positions" not in arrays:
        found = meeting_pairs(arrays["positions_t0"], arrays["positions_t1"], arrays["faces"])
        return _columns(found), [found]
    frames = arrays["positions"]
    each = [meeting_pairs(start, end, arrays["faces"]) for start, end in pairwise(frames)]
    columns = [_columns(found) for found in each]
    joined = {key: np.concatenate([column[key] for column in columns]) for key in columns[0]}
    for kind in ("vf", "ee"):
        counts = [len(column[f"true_{kind}"]) for column in columns]
        joined[f"true_{kind}_step"] = np.repeat(np.arange(len(each), dtype=np.int32), counts)
    return joined, each


def pair_facts(found: MeetingPairs) -> dict[str, Any]:
    """Summarise the pairs of one step for the index."""
    times = np.concatenate((found.vertex_face_time, found.edge_edge_time))
    return {
        "vertex_face": len(found.vertex_face),
        "edge_edge": len(found.edge_edge),
        "first_time": digits(times.min(initial=1.0)),
        "decided_in_exact_arithmetic": found.decided,
    }


def pinned_facts(found: MeetingPairs, pinned) -> dict[str, Any] | None:
    """Say which pairs of pinned vertices meet and when: they block the step."""
    vf = pinned[found.vertex_face].all(axis=1)
    ee = pinned[found.edge_edge].all(axis=1)
    if not vf.any() and not ee.any():
        return None
    nodes = np.concatenate((found.vertex_face[vf], found.edge_edge[ee]))
    times = np.concatenate((found.vertex_face_time[vf], found.edge_edge_time[ee]))
    first = int(np.argmin(times))
    return {
        "vertex_face": int(vf.sum()),
        "edge_edge": int(ee.sum()),
        "first_time": digits(times[first]),
        "first_nodes": nodes[first].tolist(),
        "first_is_edge_edge": first >= int(vf.sum()),
    }


def answers_of(arrays, thickness) -> list[dict[str, Any]]:
    """Resolve each step of a scene with izo_ref and judge the path to the answer exactly.

    The steps of a sequence start where the one before was resolved to.
    """
    frames = arrays.get("positions")
    if frames is None:
        frames = [arrays["positions_t0"], arrays["positions_t1"]]
    start, facts = frames[0], []
    for end in frames[1:]:
        fact, start = _answer(start, end, arrays, thickness)
        facts.append(fact)
    return facts


def _answer(start, end, arrays, thickness):
    import izo_ref

    scene = izo_ref.Scene(start, end, arrays["faces"], arrays["masses"], arrays["pinned"])
    result = izo_ref.resolve(scene, thickness)
    met = meeting_pairs(start, result.positions, scene.faces)
    sizes = np.diff(result.zones.impact_offsets)
    fact = {
        "status": result.status.name,
        "objective_m2": digits(result.objective),
        "impacts": len(result.impacts.toi),
        "zones": len(result.zones),
        "impacts_of_largest_zone": int(sizes.max(initial=0)),
        "time_free": digits(result.time_free),
        "pairs_that_meet_on_the_way_there": len(met.vertex_face) + len(met.edge_edge),
    }
    return fact, result.positions


def all_impacts_zone(arrays, thickness) -> dict[str, Any] | None:
    """The optimum of the largest zone of all impacts found, by two solvers that agree.

    These zones hold many nearly dependent constraints. None if a solver finds no answer: where
    plates pinch, the constraints contradict each other.
    """
    from validation.oracles import qp

    problem = largest_zone(arrays, thickness)
    found = [qp.solve(problem, solver) for solver in SOLVERS]
    mass = np.where(np.isfinite(problem.masses), problem.masses, 0.0)[:, None]
    optima = [float(np.sum(mass * answer.displacements**2)) for answer in found]
    agree = max(optima) - min(optima) <= AGREEMENT * max(optima)
    if not (agree and all(answer.claims for answer in found)):
        return None
    return {
        "impacts": len(problem.nodes),
        "sum_m_dx2_kg_m2": digits(optima[0]),
        "by": list(SOLVERS),
    }


def largest_zone(arrays, thickness):
    """The zone problem of the largest zone of all impacts of the proposed path."""
    import izo_ref

    names = ("positions_t0", "positions_t1", "faces", "masses", "pinned")
    scene = izo_ref.Scene(**{name: arrays[name] for name in names})
    impacts = izo_ref.find_impacts(scene)
    zones = izo_ref.build_zones(scene, impacts)
    largest = int(np.argmax(np.diff(zones.impact_offsets)))
    return izo_ref.zone_problem(scene, impacts, zones, largest, thickness)


def digits(value) -> float:
    """Round to the digits that are recorded."""
    return float(f"{value:.{DIGITS - 1}e}")


def _columns(found: MeetingPairs):
    return {
        "true_vf": found.vertex_face,
        "true_vf_time": found.vertex_face_time,
        "true_ee": found.edge_edge,
        "true_ee_time": found.edge_edge_time,
    }
