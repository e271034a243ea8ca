"""The right answer of each stage in 60 digits or rational numbers, and what floats may be off.

The references are those of the porting kit (`izo_ref/porting/reference/`), which use no compiled
code. Each number comes with a bound of the rounding of floats, derived there; it is 0 where a
number has to be exact, and infinite where several numbers are right.
"""

import math
from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.porting.generate import iterations as generated_iterations
from izo_ref.porting.generate import lines
from izo_ref.porting.generate.expected import MULTIPLE, decided, scale_of
from izo_ref.porting.generate.meshes import Mesh
from izo_ref.porting.generate.s01 import meeting_pairs
from izo_ref.porting.generate.s02 import MULTIPLE as MULTIPLE_OF_TIMES
from izo_ref.porting.generate.s03 import MULTIPLE as MULTIPLE_OF_FRAMES
from izo_ref.porting.generate.s03 import USELESS as USELESS_OF_FRAMES
from izo_ref.porting.reference import closest, contact, groups, zone
from izo_ref.porting.reference.rounded import EPS, Decisions, Rounded
from validation.ladders.stage_answer import Inputs
from validation.ladders.stage_descent import outcome_of_search
from validation.ladders.stage_pairs import pair_keys
from validation.ladders.zone_arrays import problem_of
from validation.oracles.rational import ExactZone

# Gap at the start, over the size of the pair, below which the plane of the normal may count as that
# of the motion: ten times `FLAT` of `izo_ref/detection/formulas/frame.py`.
SIDE = 1e-9
ZONE_TOLERANCE = 1e-9  # of the largest move; the project promises that of zones
# Rounding of a gap, over the largest coordinate (`izo_ref/zones/serial/residuals.py`). A move that
# is no longer than that closes a gap that no float tells.
GAP_ROUNDING = 32.0 * 2.0**-53
ABOUT = 2.0  # a search may pass by a step that is shorter than so many times the smallest one


class Right(NamedTuple):
    """The right answer of a stage.

    Attributes:
        numbers: Arrays of the outputs, flat.
        bounds: Largest error of floats, for each of the numbers.
        decision: The right decision; None if the stage has none, or if floats cannot tell. A set
            holds what has to be in the answer, which may have more.
        ranges: The least and the largest right number, for outputs that may be any in between.
    """

    numbers: dict[str, Floats]
    bounds: dict[str, Floats]
    decision: Any = None
    ranges: Mapping[str, tuple[float, float]] = MappingProxyType({})


def candidate_pairs(inputs: Inputs, dtype: str = "f8") -> Right:
    """Stage S1: the pairs that meet, by trying all of them in exact arithmetic."""
    rows = {
        name: [tuple(inputs[name][i : i + 3]) for i in range(0, len(inputs[name]), 3)]
        for name in ("positions_t0", "positions_t1", "faces")
    }
    found = meeting_pairs(Mesh(*rows.values()))
    flat = ([i for pair in pairs for i in pair] for pairs in found)
    return Right({}, {}, pair_keys(*flat))


def time_of_impact(inputs: Inputs, dtype: str = "f8") -> Right:
    """Stage S2: whether a pair meets, and when first; ours may be early, and never late."""
    found = contact.meeting(_pair(inputs), MULTIPLE_OF_TIMES)
    if found is None:
        return Right({}, {}, None)  # detection may call a pair an impact that comes very close
    bound = MULTIPLE_OF_TIMES * EPS[dtype] * found.scale
    return Right({"toi": np.array([float(found.time)])}, {"toi": np.array([bound])}, True)


def frame(inputs: Inputs, dtype: str = "f8") -> Right:
    """Stage S3: weights and normal at a time; bounds are infinite where nothing is known.

    That is so where weights or the normal are not unique, where rounding cannot tell on which side
    of the plane the start is, and where a bound is so large that it says nothing.
    """
    try:
        found = closest.frame(_pair(inputs), float(inputs["toi"]))
    except AssertionError:  # a sliver whose squared area is below 60 digits: nothing is known
        return Right({}, {}, None)
    unit = MULTIPLE_OF_FRAMES * EPS[dtype]
    weights = unit * found.weights_scale if found.weights_are_unique else math.inf
    told = found.normal is not None and dtype in found.dtypes
    if (
        found.normal is not None and told
    ):  # the start may be so near the plane of the normal that no float is sure of the side
        start = np.reshape(inputs["start"], (4, 3)) - np.array(inputs["start"][:3])
        told = abs(np.dot(np.dot(found.weights, start), found.normal)) > SIDE * np.abs(start).max()
    normal = unit * found.normal_scale if told else math.inf
    if USELESS_OF_FRAMES < max(weights, normal) < math.inf:
        weights = normal = math.inf
    return Right(
        {"weights": np.array(found.weights), "normal": np.array(found.normal or (0.0, 0.0, 0.0))},
        {"weights": np.full(4, weights), "normal": np.full(3, normal)},
    )


def selection(inputs: Inputs, dtype: str = "f8") -> Right:
    """Stage S4, in plain Python: decisions on given numbers, which have to be equal."""
    rows = [inputs["nodes"][j : j + 4] for j in range(0, len(inputs["nodes"]), 4)]
    weights = inputs.get("weights", [])
    found = groups.select(
        inputs["toi"],
        rows,
        inputs["pinned"],
        inputs["selection"],
        [weights[j : j + 4] for j in range(0, len(weights), 4)],
        inputs.get("edge_edge_impacts", ()),
    )
    return Right({}, {}, tuple(found))


def objective(inputs: Inputs, dtype: str = "f8") -> Right:
    """Stage S6."""
    own, moved, c, w = _zone(inputs, dtype)
    gradient = zone.objective_gradient(w, moved)
    return _rounded(
        dtype,
        objective=[zone.objective(own, moved)],
        gradient=[a for vector in gradient for a in vector],
        constraints=c,
    )


def lagrangian(inputs: Inputs, dtype: str = "f8") -> Right:
    """Stage S7; the active impacts are no decision where rounding cannot tell them."""
    own, moved, _, w = _zone(inputs, dtype)
    # our constraints are c(y) - A (x - y), which is the same number, rounded more often
    pairs = zip(zone.constraints(own, own.proposed), zone.products(own, moved), strict=True)
    c = [at_start - product for at_start, product in pairs]
    known = _known(inputs, dtype)
    with Decisions() as decisions:
        found = zone.lagrangian(own, moved, c, known["multipliers"], known["penalty"], w)
        active = tuple(number.value > 0 for number in found.pushed)
        for number in found.pushed:
            Decisions.note(number, Rounded(Decimal(0)))
    gradient = [a for vector in found.gradient for a in vector]
    right = _rounded(dtype, value=[found.value], gradient=gradient)
    return right._replace(decision=active if dtype in decisions.dtypes() else None)


def line_search(inputs: Inputs, dtype: str = "f8") -> Right:
    """Stage S8; Wolfe's conditions accept any step of an interval.

    Searches of Newton's method may fail if the right step is about the smallest one. Then any step
    that is not too long is right, and so is none.
    """
    right = _expected(lines.expected_of, inputs, dtype, ("step", "change"))
    if not right.numbers:
        return right
    step, change = (right.ranges.get(n, 2 * (right.numbers[n][0],)) for n in ("step", "change"))
    if inputs["search"] != lines.BACKTRACKING and 0.0 < step[1] < ABOUT * inputs["smallest_step"]:
        return right._replace(ranges={"step": (0.0, step[1]), "change": (change[0], 0.0)})
    if step[0] == 0.0 < step[1]:
        return right  # along p = 0 any step will do
    return right._replace(decision=outcome_of_search(inputs, step[0]))


def iterations(inputs: Inputs, dtype: str = "f8") -> Right:
    """Stage S10; the decision is how many steps the method takes."""
    outputs = ("objectives", "violations", "positions")
    right = _expected(generated_iterations.expected_of, inputs, dtype, outputs)
    return right._replace(decision=len(right.numbers["objectives"])) if right.numbers else right


def multipliers(inputs: Inputs, dtype: str = "f8") -> Right:
    """Stage S9."""
    known = _known(inputs, dtype)
    found = zone.updated(known["multipliers"], known["constraints"], known["penalty"])
    return _rounded(dtype, multipliers=found)


def optimum(inputs: Inputs, dtype: str = "f8") -> Right:
    """Stage S11, in rational numbers; the bound is what the project promises, ZONE_TOLERANCE."""
    problem = problem_of(inputs)
    exact = ExactZone(problem)
    found = exact.solve()
    if found is None:
        return Right({}, {}, None)
    moves = [[float(Fraction(int(x.p), int(x.q))) for x in row] for row in found.moves]
    numbers = np.array(moves).ravel()
    bound = ZONE_TOLERANCE * np.abs(numbers).max(initial=0.0)
    bound += GAP_ROUNDING * np.abs(problem.proposed).max(initial=0.0)
    return Right({"displacements": numbers}, {"displacements": np.full(len(numbers), bound)})


def _pair(inputs: Inputs) -> contact.Pair:
    start, end = ([tuple(inputs[n][i : i + 3]) for i in (0, 3, 6, 9)] for n in ("start", "end"))
    return contact.Pair(bool(inputs["is_edge_edge"]), start, end)


def _known(inputs: Inputs, dtype: str) -> dict[str, Any]:
    """Return inputs as a port reads them: float64 as they are, float32 perhaps rounded."""

    def known(value: Any) -> Any:
        if isinstance(value, list):
            return [known(item) for item in value]
        exact = isinstance(value, float) and dtype == "f8" and math.isfinite(value)
        return Rounded(Decimal(value)) if exact else value

    return {name: known(value) for name, value in inputs.items()}


def _zone(inputs: Inputs, dtype: str) -> tuple[Any, ...]:
    known = _known(inputs, dtype)
    own, x = zone.zone_of(known), zone.vectors(known["positions"])
    return own, zone.displacements(own, x), zone.constraints(own, x), zone.curvatures(own)


def _expected(
    reference: Callable[..., Mapping[str, Mapping[str, Any]]],
    inputs: Inputs,
    dtype: str,
    outputs: tuple[str, ...],
) -> Right:
    """Return what the judge of the vectors expects; nothing is known where a branch is not clear.

    Args:
        reference: `expected_of` of the generator of the vectors.
        inputs: The inputs of the stage.
        dtype: `f8` or `f4`.
        outputs: Names of the outputs to compare.
    """
    try:
        with Decisions() as decisions:
            found = reference(_known(inputs, dtype))
    except ValueError:  # noise has made an input for which the reference has no rule
        return Right({}, {}, None)
    if dtype not in decided(decisions):
        return Right({}, {}, None)
    ranges: dict[str, tuple[float, float]] = {}
    right = Right({}, {}, None, ranges)
    for name in outputs:
        wanted = found[name]
        unit = wanted["multiple"] * EPS[dtype]
        if wanted["judge"] == "range":
            ranges[name] = wanted["low"], wanted["high"]
            right.numbers[name] = np.array([0.5 * (wanted["low"] + wanted["high"])])
            right.bounds[name] = np.array([unit * wanted["scale"]])
        else:
            right.numbers[name] = np.array(wanted["values"])
            right.bounds[name] = unit * np.array(wanted["scale"])
    return right


def _rounded(dtype: str, **outputs: list[Rounded]) -> Right:
    """Return numbers with the running error bounds that they carry."""
    unit = MULTIPLE * EPS[dtype]
    return Right(
        {name: np.array([float(n) for n in numbers]) for name, numbers in outputs.items()},
        {
            name: np.array([unit * scale_of(n) for n in numbers])
            for name, numbers in outputs.items()
        },
    )


REFERENCES: dict[str, Callable[..., Right]] = {
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
