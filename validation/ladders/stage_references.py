"""The right answer of each stage in 60 digits or rational numbers, and what floats may be off.

The references are those of the porting kit (`izo_ref/porting/reference/`), which use no compiled
code. Each number comes with a bound of the rounding of floats, derived there; it is 0 where a
number has to be exact, and infinite where several numbers are right.
"""

import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.porting.generate.expected import MULTIPLE, scale_of
from izo_ref.porting.generate.s02 import MULTIPLE as MULTIPLE_OF_TIMES
from izo_ref.porting.generate.s03 import MULTIPLE as MULTIPLE_OF_FRAMES
from izo_ref.porting.generate.s03 import USELESS as USELESS_OF_FRAMES
from izo_ref.porting.reference import closest, contact, groups, zone
from izo_ref.porting.reference.rounded import EPS, Decisions, Rounded
from validation.ladders.stage_calls import Inputs
from validation.ladders.zone_arrays import problem_of
from validation.oracles.rational import ExactZone

# Gap at the start, over the size of the pair, below which the plane of the normal may count as that
# of the motion: ten times `FLAT` of `izo_ref/detection/formulas/frame.py`.
SIDE = 1e-9
ZONE_TOLERANCE = 1e-9  # of the largest move; the project promises that of zones
# Rounding of a gap, over the largest coordinate (`izo_ref/zones/serial/residuals.py`). A move that
# is no longer than that closes a gap that no float tells.
GAP_ROUNDING = 32.0 * 2.0**-53


class Right(NamedTuple):
    """The right answer of a stage.

    Attributes:
        numbers: Arrays of the outputs, flat.
        bounds: Largest error of floats, for each of the numbers.
        decision: The right decision; None if the stage has none, or if floats cannot tell.
    """

    numbers: dict[str, Floats]
    bounds: dict[str, Floats]
    decision: Any = None


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
    "S2 time of impact": time_of_impact,
    "S3 normal and weights": frame,
    "S4 selection": selection,
    "S6 objective, gradient, constraints": objective,
    "S7 augmented Lagrangian": lagrangian,
    "S9 multiplier update": multipliers,
    "S11 optimum of a zone": optimum,
}
