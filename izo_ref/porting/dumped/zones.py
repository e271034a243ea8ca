"""Judge the selection, the zones and their solutions in a dump, each on the port's own input."""

from __future__ import annotations

import math

import numpy as np

from izo_ref.base.arrays import AnyArray, Flags, Floats, Indices, Multipliers, Positions
from izo_ref.base.records import Impacts
from izo_ref.porting.dumped.paths import ROOM, name_of
from izo_ref.porting.dumped.report import Problem
from izo_ref.porting.reference.rounded import EPS
from izo_ref.scene import Scene
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.grouping import build_zones
from izo_ref.zones.objective import objective
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.selection import find_deep_impacts, select_impacts
from izo_ref.zones.serial.selection import hopeful_impacts
from izo_ref.zones.system import zone_problem

RULES = ("independent", "deep", "first-of-any", "all")
# A zone counts as solved up to this fraction of its own correction. A relative duality gap of g
# allows a distance of sqrt(g) times the correction (docs/method section 8). The port and the
# reference may each be so far off: g is 1e-9 by default (`Options.gap_tolerance`), and about 1e-6
# where a solver runs in float32 (`Options.precision`).
SOLVED = {"f8": 1e-4, "f4": 2e-3}
# Multipliers are judged by the forces that they give, up to this fraction of the largest one.
BALANCED = {"f8": 1e-4, "f4": 1e-2}
VIOLATED = 1e-6  # a larger violation, over the thickness, is named as the reason
TINY = 1e-300


def judge_selection(
    scene: Scene,
    found: Impacts,
    end: Positions,
    hopeful: Flags | None,
    deep: Flags | None,
    selected: Flags,
    rule: str | None,
    thickness: float,
) -> tuple[Problem | None, str]:
    """Judge which impacts enter the zones.

    Args:
        scene: The scene.
        found: The impacts of the dump, in the order of the dump.
        end: End of the path on which they were found.
        hopeful: Those that a solver could mend, as the dump says; None if it does not say.
        deep: Those of deep zones, of which `independent` takes others, as the dump says; None if
            it does not say.
        selected: (m,) b1, those that the dump selects.
        rule: The rule of selection; None if the dump does not say, so that any will do.
        thickness: The thickness [m].

    Returns:
        The first difference from the rule that is nearest, and that rule.
    """
    plain = np.zeros(len(found.toi), bool) if deep is None else deep
    tries = _selections(
        scene, found, end, _masks(scene, found, end, hopeful, thickness), plain, rule
    )
    count, name, expected = min(
        ((int((own != selected).sum()), name, own) for name, _, own in tries),
        key=lambda one: one[0],
    )
    if count == 0:
        return None, name
    if any(
        tried == "independent"
        and np.array_equal(own[plain], selected[plain])
        and not selected[~mask].any()
        and _is_some_order(found.take(mask & ~plain), selected[mask & ~plain], scene.pinned)
        for tried, mask, own in tries
    ):
        return None, "independent"
    row = int(np.flatnonzero(expected != selected)[0])
    word = "is not selected, but has to be" if expected[row] else "is selected, but must not be"
    pair = name_of(found.nodes[row], bool(found.is_edge_edge[row]))
    sentence = f"by the rule {name!r}, the impact of {pair} at t = {float(found.toi[row])!r} {word}"
    texts = str(int(expected[row])), str(int(selected[row]))
    return Problem(sentence, row, tuple(found.nodes[row].tolist()), *texts, count), name


def _masks(
    scene: Scene, found: Impacts, end: Positions, hopeful: Flags | None, thickness: float
) -> list[Flags]:
    """Return which impacts may be selected: those that the dump says, or all, or as in our loop."""
    if hopeful is not None:
        return [hopeful]
    mask, stuck = np.empty(len(found.toi), bool), np.zeros(len(scene.pinned), bool)
    hopeful_impacts(end, found.nodes, found.weights, found.normals, stuck, thickness, mask)
    return [np.ones(len(found.toi), bool), mask]


def _selections(
    scene: Scene, found: Impacts, end: Positions, masks: list[Flags], deep: Flags, rule: str | None
) -> list[tuple[str, Flags, Flags]]:
    """Return what each rule selects of each mask: its name, the mask, and the selection.

    The rule `deep` is `independent` with deep zones only. If the dump names no rule, its deep zones
    are those that are deep now.
    """
    deep_of = dict.fromkeys(RULES, deep) | {"deep": np.ones(len(deep), bool)}
    if rule is None:
        known = np.zeros(len(scene.pinned), np.int32)
        deep_of["deep"] = find_deep_impacts(scene, found, end, known)
    selections = []
    for name in RULES if rule is None else (rule,):
        plain = "independent" if name == "deep" else name
        for mask in masks:
            selected = np.zeros(len(deep), bool)
            own = found.take(mask), scene.pinned, plain, deep_of[name][mask]
            selected[mask] = select_impacts(*own)
            selections.append((name, mask, selected))
    return selections


def _is_some_order(found: Impacts, selected: Flags, pinned: Flags) -> bool:
    """Return whether `independent` selects these impacts if equal times come in some order.

    Rows of a dump may come in the order of its threads, so any order of equal times is right.
    """
    first = np.full(len(pinned), np.inf)  # time of the selected impact at each vertex
    for nodes, time in zip(found.nodes[selected].tolist(), found.toi[selected], strict=True):
        own = [node for node in nodes if not pinned[node]]
        if np.isfinite(first[own]).any():
            return False
        first[own] = time
    earlier = np.where(pinned[found.nodes], np.inf, first[found.nodes]).min(axis=1, initial=np.inf)
    return bool((earlier <= found.toi)[~selected].all())


def judge_partition(scene: Scene, impacts: Impacts, numbers: AnyArray) -> Problem | None:
    """Judge zones: the same groups of impacts, whatever their numbers."""
    zones = build_zones(scene, impacts)
    expected = np.full(len(numbers), -1)
    for zone in range(len(zones)):
        expected[zones.impacts_of(zone)] = zone
    mates: dict[int, int] = {}  # the first impact with each expected number, and with each own one
    own_mates: dict[int, int] = {}
    for i, (number, own) in enumerate(zip(expected.tolist(), numbers.tolist(), strict=True)):
        pair = name_of(impacts.nodes[i], bool(impacts.is_edge_edge[i]))
        vertices = tuple(impacts.nodes[i].tolist())
        if (number == -1) != (own == -1):
            word = "has pinned vertices only, so it is in no zone" if number == -1 else "is in none"
            texts = ("-1" if number == -1 else "a zone"), str(own)
            return Problem(f"the impact of {pair} {word}", i, vertices, *texts)
        if number == -1:
            continue
        mate, own_mate = mates.setdefault(number, i), own_mates.setdefault(own, i)
        if mate == own_mate:
            continue
        other = mate if mate != i else own_mate
        joins = "share an unpinned vertex, or a chain of impacts connects them"
        if mate == i:
            joins = "share no unpinned vertex, and no chain of impacts connects them"
        texts = ("one zone" if mate != i else "two zones"), f"zones {numbers[other]} and {own}"
        return Problem(f"impacts {other} and {i} {joins}", i, vertices, *texts)
    return None


def judge_unmoved(scene: Scene, in_zone: Flags, positions: AnyArray, eps: float) -> Problem | None:
    """Judge the vertices in no zone, which end where they are proposed to end.

    Args:
        scene: The scene.
        in_zone: (n,) b1, vertices that may end elsewhere.
        positions: (n, 3), the positions of the dump.
        eps: Machine epsilon of the dump.
    """
    ends = positions.astype(np.float64)
    off = np.flatnonzero(~np.isfinite(ends).all(axis=1))
    if len(off):
        vertex = int(off[0])
        text = str(ends[vertex].tolist())
        return Problem("a position is no number", vertex, (vertex,), "", text, len(off))
    proposed = scene.positions_t1.astype(positions.dtype).astype(np.float64)
    room = np.where(scene.pinned[:, None], 0.0, ROOM * eps * np.abs(proposed))
    off_place = np.asarray(np.abs(ends - proposed) > room).any(axis=1)
    leaders = np.arange(len(ends)) if scene.copies is None else scene.copies
    wrong = off_place & ~in_zone[leaders]
    if not wrong.any():
        return None
    vertex = int(np.flatnonzero(wrong)[0])
    kind = "pinned" if scene.pinned[vertex] else "in no zone"
    sentence = f"vertex {vertex} is {kind}, so it has to end at its proposed position"
    texts = str(proposed[vertex].tolist()), str(ends[vertex].tolist())
    return Problem(sentence, vertex, (vertex,), *texts, int(wrong.sum()))


def judge_positions(
    scene: Scene, impacts: Impacts, positions: AnyArray, thickness: float, dtype: str
) -> tuple[Problem | None, int, int]:
    """Judge positions against the optimum of each zone.

    Args:
        scene: The scene.
        impacts: The impacts in zones.
        positions: (n, 3), the positions of the dump.
        thickness: The thickness [m].
        dtype: `f8` or `f4`, the floats of the dump.

    Returns:
        The first difference; the number of zones; the number of zones that no positions satisfy,
        which are not judged.
    """
    zones = build_zones(scene, impacts)
    in_zone = np.zeros(len(scene.pinned), bool)
    in_zone[zones.vertices] = True
    unmoved = judge_unmoved(scene, in_zone, positions, EPS[dtype])
    if unmoved is not None:
        return unmoved, len(zones), 0
    ends, infeasible, problems = positions.astype(np.float64), 0, []
    for zone in range(len(zones)):
        own = zone_problem(scene, impacts, zones, zone, thickness)
        solution = solve_zone(own)
        if not solution.feasible:
            infeasible += 1
            continue
        vertices = np.unique(impacts.nodes[zones.impacts_of(zone)]).astype(np.int64)
        problem = _judge_zone(own, solution.positions, ends[vertices], vertices, dtype)
        problems += [problem] if problem else []
    first = problems[0]._replace(n_wrong=len(problems)) if problems else None
    return first, len(zones), infeasible


def _judge_zone(
    own: ZoneProblem, optimum: Positions, ends: Positions, vertices: Indices, dtype: str
) -> Problem | None:
    """Return what is wrong if positions of a zone are not at its optimum."""
    masses = np.where(np.isinf(own.masses), 0.0, own.masses)
    off = ends - optimum
    distance, least = _norm(masses, off), _norm(masses, optimum - own.proposed)
    rounding = ROOM * EPS[dtype] * float(np.abs(own.proposed).max())
    allowed = SOLVED[dtype] * least + rounding * math.sqrt(float(masses.sum()))
    if distance <= allowed:
        return None
    worst = int(np.argmax(masses * (off**2).sum(axis=1)))
    violation = -float(own.gaps(ends).min())
    far = _norm(masses, ends - own.proposed)
    why = f"it is {far / max(least, TINY):.6g} times as far from the proposed positions"
    if violation > VIOLATED * own.thickness:
        why = f"a constraint is violated by {violation:.3g} m"
    sentence = (
        f"the zone of {len(own.nodes)} impacts around vertex {vertices[worst]} is not at its "
        f"optimum, by {distance / allowed:.3g} times the tolerance: {why}"
    )
    texts = str(optimum[worst].tolist()), str(ends[worst].tolist())
    return Problem(sentence, int(vertices[worst]), tuple(vertices.tolist()), *texts)


def _norm(masses: Floats, moved: Floats) -> float:
    return math.sqrt(float((masses * (moved**2).sum(axis=1)).sum()))


def judge_multipliers(
    scene: Scene,
    impacts: Impacts,
    positions: Positions,
    multipliers: Multipliers,
    dtype: str,
) -> Problem | None:
    """Judge multipliers by the forces that they give at the port's positions."""
    moved = np.where(scene.pinned[:, None], 0.0, positions - scene.positions_t1)
    wanted, force = scene.masses[:, None] * moved, np.zeros_like(moved)
    pushes = multipliers[:, None] * impacts.normals
    for k in range(4):
        np.add.at(force, impacts.nodes[:, k], impacts.weights[:, k, None] * pushes)
    force[scene.pinned] = 0.0
    negative = np.flatnonzero(
        ~(multipliers >= -BALANCED[dtype] * np.abs(multipliers).max(initial=0))
    )
    if len(negative):
        row = int(negative[0])
        vertices, text = tuple(impacts.nodes[row].tolist()), repr(float(multipliers[row]))
        return Problem("a multiplier is negative", row, vertices, "at least 0", text, len(negative))
    rounding = ROOM * EPS[dtype] * np.abs(positions).max(axis=1, initial=0.0) * scene.masses
    off = np.abs(force - wanted).max(axis=1, initial=0.0)
    wrong = off > BALANCED[dtype] * np.abs(wanted).max(initial=0.0) + rounding
    if not wrong.any():
        return None
    vertex = int(np.argmax(np.where(wrong, off, 0.0)))
    sentence = f"the multipliers do not balance vertex {vertex}: M (x - y) and A^T l differ"
    texts = str(wanted[vertex].tolist()), str(force[vertex].tolist())
    return Problem(sentence, vertex, (vertex,), *texts, int(wrong.sum()))


def judge_objective(scene: Scene, positions: Positions, value: float, eps: float) -> Problem | None:
    """Judge the objective of positions of the port."""
    expected = objective(scene, positions)
    extent = float(np.abs(scene.positions_t1).max(initial=0.0))
    tolerance = ROOM * eps * (expected + extent * math.sqrt(expected)) + (ROOM * eps * extent) ** 2
    if abs(value - expected) <= tolerance:
        return None
    sentence = f"the objective is {value / expected:.6g} times" if expected else "it is not 0"
    return Problem(sentence, expected=f"{float(expected)!r} +- {tolerance:.1e}", got=repr(value))
