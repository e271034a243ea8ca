"""Right replies, made from what a case expects: the self-test breaks them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

from izo_ref.porting.cases import Case
from izo_ref.porting.judge.geometry import Vector, at_time, combined, dot, minus, vectors
from izo_ref.porting.judge.measure import number_at
from izo_ref.porting.judge.verdict import REFUSED, STATUS, statuses
from izo_ref.porting.stages import STAGE

SWEEPS = 20000  # of the multipliers of a zone, until they are right to rounding


def right_reply(case: Case) -> dict[str, Any] | None:
    """Return a reply that should pass; None if an output needs a whole solver.

    Args:
        case: The case.
    """
    reply: dict[str, Any] = {"id": case.id}
    if STATUS in case.expected and REFUSED in statuses(case):
        reply[STATUS] = REFUSED
    else:
        reply[STATUS] = "ok"
    output: dict[str, Any] = {}
    # what another output needs comes first
    fields = sorted(STAGE[case.stage].outputs, key=lambda f: f.name in ("normal", "multipliers"))
    for field in fields:
        expected = case.expected.get(field.name)
        if expected is None:
            continue
        make = MAKERS.get(expected["judge"])
        if make is None:
            return None
        values = list(make(case, expected, output))
        output[field.name] = values if field.shape else values[0]
    if output or reply[STATUS] == "ok":
        reply["output"] = output
    return reply


def has_multipliers(case: Case) -> bool:
    """Return whether a right reply needs multipliers, which are only approached by sweeps."""
    return any(expected["judge"] == "kkt" for expected in case.expected.values())


Maker = Callable[[Case, Mapping[str, Any], Mapping[str, Any]], Sequence[Any]]


def _values(case: Case, expected: Mapping[str, Any], output: Mapping[str, Any]) -> Sequence[Any]:
    return expected["values"]


def _weights(case: Case, expected: Mapping[str, Any], output: Mapping[str, Any]) -> list[float]:
    """Return the weights of the closest points, found by trying all corners and edges."""
    inputs: Any = case.inputs
    nodes = at_time(vectors(inputs["start"]), vectors(inputs["end"]), inputs["toi"])
    n_first = 2 if inputs["is_edge_edge"] else 1
    best, best_sq = [], None
    for used in product((0, 1), repeat=4):
        first, second = used[:n_first], used[n_first:]
        if sum(first) == 0 or sum(second) == 0:
            continue
        weights = _weights_of(nodes, used, n_first)
        if weights is None:
            continue
        between = combined(weights, nodes)
        if best_sq is None or dot(between, between) < best_sq:
            best, best_sq = weights, dot(between, between)
    return [float(weight) for weight in best]


def _weights_of(nodes: list[Vector], used: Sequence[int], n_first: int) -> list[Fraction] | None:
    """Return the weights that make the sides closest with some nodes alone, or None."""
    one = next(i for i in range(n_first) if used[i])
    other = next(i for i in range(n_first, 4) if used[i])
    free = [i for i in range(4) if used[i] and i not in (one, other)]
    between = minus(nodes[one], nodes[other])
    # moving weight to node i from the first node of its side moves the difference by this
    ways = [
        minus(nodes[i], nodes[one]) if i < n_first else minus(nodes[other], nodes[i]) for i in free
    ]
    shares = _closest(between, ways)
    if shares is None:
        return None
    weights = [Fraction(0)] * 4
    weights[one], weights[other] = Fraction(1), Fraction(-1)
    for i, share in zip(free, shares, strict=True):
        sign = 1 if i < n_first else -1
        weights[i] += sign * share
        weights[one if i < n_first else other] -= sign * share
    right = all((weight if i < n_first else -weight) >= 0 for i, weight in enumerate(weights))
    return weights if right else None


def _closest(between: Vector, ways: list[Vector]) -> list[Fraction] | None:
    """Return the shares s that minimise |between + sum s way| for at most two ways, or None."""
    if not ways:
        return []
    p = [-dot(between, way) for way in ways]
    if len(ways) == 1:
        length_sq = dot(ways[0], ways[0])
        return [p[0] / length_sq] if length_sq else None
    a, b, c = dot(ways[0], ways[0]), dot(ways[0], ways[1]), dot(ways[1], ways[1])
    det = a * c - b * b
    return [(c * p[0] - b * p[1]) / det, (a * p[1] - b * p[0]) / det] if det else None


def _normal(case: Case, expected: Mapping[str, Any], output: Mapping[str, Any]) -> list[float]:
    """Return the direction of the gap at the start, for which the gap is largest."""
    inputs: Any = case.inputs
    gap = [float(x) for x in combined(output["weights"], vectors(inputs["start"]))]
    length = sum(x * x for x in gap) ** 0.5
    return [x / length for x in gap]


def _multipliers(case: Case, expected: Mapping[str, Any], output: Mapping[str, Any]) -> list[float]:
    """Return multipliers l >= 0 with A^T l = M (x - y), by sweeps over one after the other."""
    inputs: Any = case.inputs
    x, y, pinned = output["positions"], inputs["proposed"], inputs["pinned"]
    free = [i for i, is_pinned in enumerate(pinned) if not is_pinned]
    residual = {
        (i, k): inputs["masses"][i] * (x[3 * i + k] - y[3 * i + k]) for i in free for k in range(3)
    }
    rows = []
    for j in range(len(inputs["nodes"]) // 4):
        gap, row = -inputs["thickness"], dict.fromkeys(residual, 0.0)
        for k in range(4):
            vertex, weight = inputs["nodes"][4 * j + k], inputs["weights"][4 * j + k]
            for axis in range(3):
                push = weight * inputs["normals"][3 * j + axis]
                gap += push * x[3 * vertex + axis]
                if not pinned[vertex]:
                    row[vertex, axis] += push
        length_sq = sum(push * push for push in row.values())
        touches = gap <= 1e-6 * inputs["thickness"]
        rows.append({key: p for key, p in row.items() if p} if length_sq and touches else {})
    multipliers = [0.0] * len(rows)
    for _ in range(SWEEPS):
        largest = 0.0
        for j, row in enumerate(rows):
            if row:
                size = sum(push * push for push in row.values())
                step = sum(push * residual[key] for key, push in row.items()) / size
                step = max(step, -multipliers[j])
                multipliers[j] += step
                largest = max(largest, abs(step))
                for key, push in row.items():
                    residual[key] -= step * push
        if largest <= 1e-17 * max(multipliers, default=0.0):
            break
    return multipliers


def _free_path(case: Case, expected: Mapping[str, Any], output: Mapping[str, Any]) -> list[float]:
    """Return the positions that izo_ref finds; this is the only stage that needs compiled code."""
    import numpy as np

    from izo_ref.loop.resolve import resolve
    from izo_ref.scene import Scene

    inputs: Any = case.inputs
    start, end = (
        np.array(inputs[name], float).reshape(-1, 3) for name in ("positions_t0", "positions_t1")
    )
    faces = np.array(inputs["faces"], np.int32).reshape(-1, 3)
    scene = Scene(start, end, faces, np.array(inputs["masses"]), np.array(inputs["pinned"], bool))
    return resolve(scene, inputs["thickness"]).positions.ravel().tolist()


MAKERS: dict[str, Maker] = {
    "values": _values,
    "equal": _values,
    "partition": _values,
    "superset": lambda case, expected, output: expected["pairs"],
    "time": lambda case, expected, output: [number_at(expected["time"], 0)],
    "range": lambda case, expected, output: [number_at(expected["low"], 0)],
    "weights": _weights,
    "side": _normal,
    "kkt": _multipliers,
    "free-path": _free_path,
}
