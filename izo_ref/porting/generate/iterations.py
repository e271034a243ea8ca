"""Zones and parameters for the cases of stage S10, and the case that follows from both."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import Any

from izo_ref.porting.generate.expected import CaseList, decided, values
from izo_ref.porting.generate.small_zones import Inputs, random_zone, zone_above_face
from izo_ref.porting.reference.rounded import Decisions
from izo_ref.porting.reference.steps import first_iterations
from izo_ref.porting.reference.zone import constraints, zone_of
from izo_ref.porting.stages import STAGE

SIZE = 2.0**-4  # [m], of a zone
PAIRS = 8  # what izo_ref keeps for lbfgs
# Vectors of integers whose length is an integer: as floats, they are unit vectors to rounding
QUADRUPLES = (
    (3, 4, 0, 5),
    (1, 2, 2, 3),
    (2, 3, 6, 7),
    (1, 4, 8, 9),
    (4, 4, 7, 9),
    (2, 6, 9, 11),
    (6, 6, 7, 11),
)

OWN: Inputs = {
    "direction_name": "gradient",
    "pairs": PAIRS,
    "scaling": "scaled",
    "every_step": 1,
    "preconditioned": 0,
    "penalty": 2.0,
    "begin": "model",
    "first_step": 1.0,
    "grow": 2.0,
    "search": "backtracking",
    "armijo": 1e-4,
    "wolfe": 0.1,
    "shrink": 0.5,
    "smallest_step": 1e-12,
    "faithful": 0,
    "inner_steps": 100_000,
    "inner_accuracy": 0.5,
    "eps_x": -1.0,
    "eps_f": -1.0,
    "eps_g": 0.0,
    "delay": 1,
    "rho": 0.9,
    "linear_tolerance": 1e-4,
}
_PRESET: Inputs = {**OWN, "faithful": 1, "penalty": 1e3}
ARCSIM: Inputs = {
    **_PRESET,
    "direction_name": "cg",
    "scaling": "mean-inverse-mass",
    "every_step": 0,
    "search": "wolfe",
    "inner_steps": 10,
    "eps_x": 1e-6,
    "eps_f": 1e-12,
    "eps_g": 1e-6,
}
_LAST: Inputs = {**_PRESET, "begin": "last", "armijo": 0.5, "shrink": 0.7, "grow": 1.0}
ICLOTH: Inputs = {
    **_LAST,
    "direction_name": "chebyshev",
    "preconditioned": 1,
    "scaling": "total-mass",
    "delay": 10,
    "rho": 0.9992,
}
XRTAILOR: Inputs = {**_LAST, "scaling": "mean-inverse-mass"}


def xrtailor(zone: Inputs) -> Inputs:
    """Return the parameters of XRTailor, whose first step depends on the number of vertices."""
    return {**XRTAILOR, "first_step": 1e-3 * zone["pinned"].count(0)}


def method(name: str, **changes: Any) -> Inputs:
    """Return the parameters of a direction of izo_ref, with some of them changed."""
    quasi_newton = name in ("lbfgs", "newton")
    return {
        **OWN,
        "direction_name": name,
        "preconditioned": int(name in ("jacobi", "chebyshev")),
        "begin": "unit" if quasi_newton else "model",
        "wolfe": 0.9 if quasi_newton else 0.1,
        **changes,
    }


def plain_zone(impacts: int = 1, **settings: Any) -> Inputs:
    """Return vertices that were pushed through one face, by 1/16 m, in short numbers."""
    wanted = [0.0625 + 0.015625 * j for j in range(impacts)]
    return _without_positions(zone_above_face(wanted, fall=0.0, **settings))


def zone(
    seed: int,
    impacts: int,
    vertices: int,
    *,
    apart: Sequence[int] = (),
    masses: Sequence[float] = (1.0,),
    pinned: Sequence[int] = (),
) -> Inputs:
    """Return a random zone; all its constraints are violated at first, except those `apart`."""
    random = Random(seed)
    found = random_zone(random, impacts, vertices, masses=masses, pinned=pinned, size=SIZE)
    found["normals"] = [a for _ in range(impacts) for a in _unit_vector(random)]
    for j, c in enumerate(constraints(zone_of(found), zone_of(found).proposed)):
        if (c.value > 0) == (j in apart):
            normal = slice(3 * j, 3 * j + 3)
            found["normals"][normal] = [0.0 - a for a in found["normals"][normal]]
    return _without_positions(found)


def _unit_vector(random: Random) -> list[float]:
    """Return a vector whose float64 has length 1 to rounding."""
    *parts, length = QUADRUPLES[int(random.random() * len(QUADRUPLES))]
    first = int(3 * random.random())
    signed = [a if random.random() < 0.5 else -a for a in parts]
    return [a / length for a in (signed + signed)[first : first + 3]]


def _without_positions(inputs: Inputs) -> Inputs:
    """Return a zone without a point to evaluate it at: S10 begins at the proposed positions."""
    return {name: value for name, value in inputs.items() if name != "positions"}


def add(
    cases: CaseList,
    word: str,
    flags: str,
    grade: str,
    what: str,
    steps: int,
    zone_inputs: Inputs,
    parameters: Inputs,
) -> None:
    """Append a case: the reference takes the steps.

    Args:
        cases: The cases so far.
        word: The word in its id.
        flags: Names of the mistakes that it catches, with spaces between them.
        grade: `easy`, `medium` or `hard`.
        what: A sentence that says what is special about it.
        steps: How many steps to take.
        zone_inputs: The zone.
        parameters: All other inputs.
    """
    given = {**zone_inputs, **parameters, "steps": steps}
    inputs = {field.name: given[field.name] for field in STAGE["S10"].inputs}
    with Decisions() as decisions:
        expected = expected_of(inputs)
    cases.add(word, flags, grade, what, inputs, expected, decided(decisions))


def expected_of(inputs: Inputs) -> dict[str, dict[str, Any]]:
    """Return what the judge needs for the first steps; `Decisions` note how clear each branch was.

    Raises:
        ValueError: A step has no direction of descent, or another thing that no case may have.
    """
    found = first_iterations(inputs)
    return {
        "objectives": values(found.objectives),
        "violations": values(found.violations),
        "positions": values(found.positions),
        "step_sizes": values(found.step_sizes),
    }
