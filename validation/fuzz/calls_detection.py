"""Inputs of `find_impacts` and `plan`, and judges of what they return."""

import re
from collections.abc import Callable
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np

import izo_ref
from izo_ref import errors
from izo_ref.base.options import RULES
from validation.fuzz import contract
from validation.fuzz.arrays import Rng, strange_value
from validation.fuzz.calls import hanging_step, is_finite, options_of, shown, step_arrays
from validation.fuzz.trial import Trial, Wrong
from validation.oracles.pairs import meeting_pairs

TRIES = 8  # draws of a scene, of which many are refused
UNIT = 2.0**-44  # relative rounding of weights and normals: a hundred operations, and no slack
LATER = 1e-9  # by which a time of impact may be after that of exact arithmetic


def drawn_scene(rng: Rng) -> izo_ref.Scene:
    """Return a small scene of any size, mode and start that is accepted."""
    for _ in range(TRIES):
        try:
            return izo_ref.Scene(**step_arrays(rng))
        except errors.IzoError:
            continue
    return hanging_step(rng)


def no_scene(rng: Rng, scene: izo_ref.Scene) -> Any:
    """Return something in the place of a scene, such as its arrays in another container."""
    arrays = (scene.positions_t0, scene.positions_t1, scene.faces)
    others = (arrays, vars(scene), SimpleNamespace(positions_t0=arrays[0]), izo_ref.Scene, "a.npz")
    i = int(rng.integers(2 * len(others)))
    return others[i] if i < len(others) else strange_value(rng)


def find_trial(rng: Rng) -> Trial:
    """Return a call of `find_impacts`."""
    scene = drawn_scene(rng)
    arguments: dict[str, Any] = {"scene": scene}
    wrongs, is_open = [], False
    if rng.random() < 0.15:
        arguments["scene"] = no_scene(rng, scene)
        wrongs.append(Wrong("scene"))
    if rng.random() < 0.3:
        devices = ("cpu", "auto", "cuda", "CPU", "gpu", strange_value(rng))
        device = arguments["device"] = devices[rng.integers(len(devices))]
        is_open = isinstance(device, str) and device == "cuda"  # whether there is a GPU
        known = isinstance(device, str) and device in ("cpu", "auto", "cuda")
        wrongs += [] if known else [Wrong("device")]
    what = f"find_impacts({shown(arguments)}) of {shown(vars(scene))}"
    return Trial(
        lambda: izo_ref.find_impacts(**arguments),
        None if is_open and not wrongs else wrongs,
        lambda impacts: impacts_problem(impacts, scene),
        what,
    )


def impacts_problem(impacts: izo_ref.Impacts, scene: izo_ref.Scene) -> str:
    """Return what is wrong with impacts: a number, their order, or a pair that is missing."""
    k = len(impacts.toi)
    shapes = [array.shape for array in impacts]
    if shapes != [(k, 4), (k,), (k,), (k, 4), (k, 3)]:
        return f"the shapes are {shapes}"
    if not all(map(is_finite, impacts)) or not ((impacts.toi >= 0) & (impacts.toi <= 1)).all():
        return "a number is not finite, or a time is not from 0 to 1"
    if (np.abs(np.linalg.norm(impacts.normals, axis=1) - 1.0) > UNIT).any():
        return "a normal is no unit vector"
    if (np.abs(impacts.weights.sum(axis=1)) > UNIT).any():
        return "weights do not sum to zero"
    n_first = np.where(impacts.is_edge_edge, 2, 1)[:, None] > np.arange(4)
    if ((impacts.weights < 0.0) & n_first).any() or ((impacts.weights > 0.0) & ~n_first).any():
        return "a weight has the sign of the other side"
    touching = [] if scene.touching is None else scene.touching.nodes.tolist()
    n_found = next((i for i, row in enumerate(impacts.nodes.tolist()) if row in touching), k)
    if any(row not in touching for row in impacts.nodes[n_found:].tolist()):
        return "a pair that touches at the start is not among the last ones"
    return (
        _order_problem(impacts, n_found, len(np.unique(scene.faces, axis=0)) == len(scene.faces))
        or _gap_problem(impacts, n_found, scene)
        or _missed(impacts, scene)
    )


def _order_problem(impacts: izo_ref.Impacts, n_found: int, has_unlike_faces: bool) -> str:
    """Return whether impacts are not sorted; those that touch at the start come last."""
    kinds = impacts.is_edge_edge[:n_found].tolist()
    if kinds != sorted(kinds):
        return "an edge-edge pair is before a vertex-face pair"
    nodes = impacts.nodes[:n_found].tolist()
    vertices = [row[0] for row, is_edge in zip(nodes, kinds, strict=True) if not is_edge]
    edges = [row for row, is_edge in zip(nodes, kinds, strict=True) if is_edge]
    if vertices != sorted(vertices) or edges != sorted(edges):
        return "the pairs are not sorted"
    pairs = {(is_edge, *row) for row, is_edge in zip(nodes, kinds, strict=True)}
    return "a pair is there twice" if has_unlike_faces and len(pairs) < len(nodes) else ""


def _gap_problem(impacts: izo_ref.Impacts, n_found: int, scene: izo_ref.Scene) -> str:
    """Return whether a frozen gap is negative at the start, by more than its rounding."""
    for nodes, weights, normal in zip(
        impacts.nodes[:n_found], impacts.weights, impacts.normals, strict=False
    ):
        points = scene.positions_t0[nodes] - scene.positions_t0[nodes[0]]
        gap = sum(
            Fraction(float(w)) * Fraction(float(n)) * Fraction(float(x))
            for w, point in zip(weights, points, strict=True)
            for n, x in zip(normal, point, strict=True)
        )
        if gap < -Fraction(UNIT) * Fraction(float(np.abs(points).max())):
            return f"the gap of {nodes.tolist()} is {float(gap)} at the start"
    return ""


def _missed(impacts: izo_ref.Impacts, scene: izo_ref.Scene) -> str:
    """Return a pair that meets and is missing, or is found too late, by all pairs.

    Pairs of pinned vertices, and steps with pairs that are left out, have rules of their own.
    """
    if scene.copies is not None or scene.excluded is not None or scene.touching is not None:
        return ""
    rows = zip(impacts.is_edge_edge.tolist(), impacts.nodes.tolist(), strict=True)
    pairs = [(is_edge, *row) for is_edge, row in rows]
    found = dict(zip(pairs, impacts.toi.tolist(), strict=True))
    meeting = meeting_pairs(scene.positions_t0, scene.positions_t1, scene.faces)
    for is_edge, nodes, times in (
        (False, meeting.vertex_face, meeting.vertex_face_time),
        (True, meeting.edge_edge, meeting.edge_edge_time),
    ):
        for row, time in zip(nodes.tolist(), times.tolist(), strict=True):
            if scene.pinned[row].any():
                continue
            toi = found.get((is_edge, *row))
            if toi is None:
                return f"the pair {row} meets at {time}, and is missing"
            if toi > time + LATER:
                return f"the pair {row} meets at {time}, and is found at {toi}"
    return ""


def plan_trial(rng: Rng) -> Trial:
    """Return a call of `plan`."""
    scene, given = drawn_scene(rng), options_of(rng)
    arguments: dict[str, Any] = {"scene": scene}
    other: list[Any] = []
    if rng.random() < 0.2:
        other.append((strange_value(rng), given, izo_ref.Options, None)[rng.integers(4)])
        wrongs = [] if other[0] is None else [Wrong("options")]
    else:
        wrongs = contract.options_wrongs(given)
    if rng.random() < 0.15:
        arguments["scene"] = no_scene(rng, scene)
        wrongs.append(Wrong("scene"))

    def call() -> Any:
        options = other[0] if other else izo_ref.Options(**given)
        return izo_ref.plan(**arguments, options=options), options

    what = f"plan({shown(arguments)}, {shown(given)}, {shown({'options': other})}) of "
    what += shown(vars(scene))
    judge: Callable[[Any], str] = lambda found: plan_problem(found[0], found[1], scene)  # noqa: E731
    return Trial(call, wrongs, judge, what)


def plan_problem(plan: izo_ref.Plan, options: izo_ref.Options | None, scene: izo_ref.Scene) -> str:
    """Return what is wrong with a plan: its words, a rule that is switched off, or a reason."""
    rules = (options or izo_ref.Options()).rules
    for line in plan.lines:
        words = (line.stage, line.reason)
        if any(not word or word != " ".join(word.split()) for word in words):
            return f"the words of {line}"
        if line.needed not in ("all", "some", "none") or line.rule not in ("", *RULES):
            return f"needed or rule: {line}"
        if line.rule and line.rule not in rules and line.needed != "all":
            return f"{line.stage} is left out by {line.rule!r}, which is switched off"
        if not _is_true(line.reason, scene):
            return f"the reason is not true: {line}"
    text = str(plan)
    if len(text.splitlines()) != 1 + len(plan.lines):
        return "printed, it is no table with a line for each stage"
    everything = izo_ref.plan(scene, izo_ref.Options(plan="everything"))
    stages = [[line.stage for line in one.lines] for one in (plan, everything)]
    return "" if stages[0] == stages[1] else f"the stages are {stages}"


def _is_true(reason: str, scene: izo_ref.Scene) -> bool:
    """Return whether what a reason says of the scene is true, as far as it is counted here."""
    n = len(scene.pinned)
    own = np.arange(n) if scene.copies is None else np.flatnonzero(scene.copies == np.arange(n))
    moving = (scene.positions_t0[own] != scene.positions_t1[own]).any(axis=1)
    is_free = scene.touching is None and scene.excluded is None
    n_pinned, n_moving = int(scene.pinned[own].sum()), int(moving.sum())
    facts = {
        "the start is free of contact": is_free,
        "no vertex moves": n_moving == 0,
        "every vertex moves": n_moving == len(own),
        "no vertex is pinned": n_pinned == 0,
        "there are no triangles": len(scene.faces) == 0,
    }
    counts = {
        r"(\d+) of \d+ vertices move": n_moving,
        r"\d+ of (\d+) vertices move": len(own),
        r"(\d+) vertices are at rest": len(own) - n_moving,
        r"(\d+) vertices are pinned": n_pinned,
        r"there are (\d+) vertices": len(own),
        r"there are (\d+) edges": len(scene.edges),
        r"(?:scene has|and) (\d+) triangles": len(scene.faces),
        r"(\d+) of \d+ vertices are copies": n - len(own),
    }
    if any(text in reason and not is_true for text, is_true in facts.items()):
        return False
    if "finds nothing" in reason and len(izo_ref.find_impacts(scene).toi):
        return False
    found = [(re.search(pattern, reason), count) for pattern, count in counts.items()]
    return all(match is None or int(match[1]) == count for match, count in found)
