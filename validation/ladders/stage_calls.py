"""Each stage of the method by our own functions, from the inputs of the porting kit.

An answer has numbers, which noise changes a little, and decisions, which noise may turn. Our own
port (`tests/ports/own`) answers the vectors with the same functions.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from izo_ref.base.arrays import Vec3
from izo_ref.base.records import Impacts
from izo_ref.detection.formulas.advance import APART, advance
from izo_ref.detection.formulas.frame import impact_frame
from izo_ref.solvers.serial.lagrangian import evaluate, update_multipliers
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.selection import select_impacts
from validation.ladders.stage_answer import Answer, Inputs
from validation.ladders.stage_descent import iterations, line_search
from validation.ladders.stage_pairs import candidate_pairs
from validation.ladders.zone_arrays import problem_of, rounded, zone_arrays


def time_of_impact(inputs: Inputs) -> Answer:
    """Stage S2."""
    found = _advanced(inputs)
    if found[0] == APART:
        return Answer({}, False)
    return Answer({"toi": np.array([found[1]])}, True)


def frame(inputs: Inputs) -> Answer:
    """Stage S3; the decision is which weights are zero: on which features the points lie."""
    arguments: tuple[Any, ...] = (
        bool(inputs["is_edge_edge"]),
        *_relative(inputs),
        np.float64(inputs["toi"]),
        _advanced(inputs)[2],
    )
    with np.errstate(all="ignore"):  # compiled code does not warn, either
        weights, normal = impact_frame(*arguments)
    return Answer(
        {"weights": np.array(weights), "normal": np.array(normal)},
        tuple(weight == 0.0 for weight in weights),
    )


def selection(inputs: Inputs) -> Answer:
    """Stage S4, which only decides."""
    n = len(inputs["toi"])
    impacts = Impacts(
        np.array(inputs["nodes"], np.int32).reshape(n, 4),
        np.array(inputs.get("edge_edge_impacts", [0] * n), bool),
        np.array(inputs["toi"], np.float64),
        np.array(inputs.get("weights", [0.0] * 4 * n), np.float64).reshape(n, 4),
        np.zeros((n, 3)),
    )
    deep = np.full(n, inputs["selection"] == "deep")
    name = "independent" if inputs["selection"] == "deep" else inputs["selection"]
    selected = select_impacts(impacts, np.array(inputs["pinned"], bool), name, deep)
    return Answer({}, tuple(selected.astype(int).tolist()))


def objective(inputs: Inputs, kind: type[Any] = np.float64) -> Answer:
    """Stage S6, with arrays of a type of floats."""
    problem = problem_of(inputs, kind)
    arrays = zone_arrays(problem, inputs, kind)
    constraints = arrays.zone.constraints.astype(np.float64)
    if kind is np.float64:
        constraints = -problem.gaps(rounded(inputs["positions"], kind).reshape(-1, 3))
    arrays.zone.constraints[:] = -np.inf  # no impact is active, so L is g
    found = evaluate(arrays.zone, 1.0)
    return Answer(
        {
            "objective": np.array([found.objective]),
            "gradient": arrays.by_vertex(arrays.zone.gradient),
            "constraints": constraints,
        }
    )


def lagrangian(inputs: Inputs, kind: type[Any] = np.float64) -> Answer:
    """Stage S7, with arrays of a type of floats; the decision is which impacts are active."""
    arrays = zone_arrays(problem_of(inputs, kind), inputs, kind)
    found = evaluate(arrays.zone, float(kind(inputs["penalty"])))
    return Answer(
        {"value": np.array([found.value]), "gradient": arrays.by_vertex(arrays.zone.gradient)},
        tuple((arrays.zone.pushed > 0.0).tolist()),
    )


def multipliers(inputs: Inputs, kind: type[Any] = np.float64) -> Answer:
    """Stage S9, with arrays of a type of floats; the decision is which multipliers are zero."""
    n = len(inputs["multipliers"])
    nodes, points = np.tile(np.arange(4), (n, 1)), np.zeros((4, 3))
    problem = ZoneProblem(nodes, np.zeros((n, 4)), np.zeros((n, 3)), points, np.ones(4), 1.0)
    zone = zone_arrays(problem, {**inputs, "positions": points}, kind).zone
    zone.constraints[:] = inputs["constraints"]
    update_multipliers(zone, float(kind(inputs["penalty"])))
    found = zone.multipliers.astype(np.float64)
    return Answer({"multipliers": found}, tuple((found == 0.0).tolist()))


def optimum(inputs: Inputs, **settings: Any) -> Answer:
    """Stage S11; the decision is whether it is feasible, and which impacts push."""
    found = solve_zone(problem_of(inputs), **settings)
    if not found.feasible:
        return Answer({}, False)
    claims = found.residuals.solved(1e-9, 1e-9)
    return Answer(
        {"displacements": found.displacements.ravel()},
        (claims, tuple((found.multipliers > 0.0).tolist())),
    )


def relative_nodes(points: Any) -> list[Vec3]:
    """Return nodes 1 to 3 relative to node 0, from flat coordinates."""
    p = np.array(points, np.float64).reshape(4, 3)
    return [tuple(row) for row in p[1:] - p[0]]


def _relative(inputs: Inputs) -> list[Vec3]:
    return relative_nodes(inputs["start"]) + relative_nodes(inputs["end"])


def _advanced(inputs: Inputs) -> Any:
    with np.errstate(all="ignore"):  # compiled code does not warn, either
        return advance(bool(inputs["is_edge_edge"]), *_relative(inputs))


CALLS: dict[str, Callable[..., Answer]] = {
    "S1 candidate pairs": candidate_pairs,
    "S2 time of impact": time_of_impact,
    "S3 normal and weights": frame,
    "S4 selection": selection,
    "S6 objective, gradient, constraints": objective,
    "S7 augmented Lagrangian": lagrangian,
    "S8 line search": line_search,
    "S9 multiplier update": multipliers,
    "S10 first iterations": iterations,
    "S11 optimum of a zone": optimum,
}
IN_FLOAT32 = (
    "S1 candidate pairs",
    "S6 objective, gradient, constraints",
    "S7 augmented Lagrangian",
    "S8 line search",
    "S9 multiplier update",
    "S10 first iterations",
)
