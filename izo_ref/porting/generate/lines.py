"""Zones with a direction for the line searches of stage S8, and what the reference finds there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from izo_ref.porting.cases import DTYPES
from izo_ref.porting.generate.expected import CaseList, between, decided, exact_inputs, values
from izo_ref.porting.generate.s07 import evaluate
from izo_ref.porting.generate.small_zones import Inputs, float32
from izo_ref.porting.reference.line_search import (
    Found,
    Line,
    backtrack,
    change_over,
    exact,
    line_of,
    wolfe_interval,
)
from izo_ref.porting.reference.rounded import ZERO, Decisions, Rounded
from izo_ref.porting.reference.zone import curvatures, vectors, zone_of

BACKTRACKING, EXACT, WOLFE = "backtracking", "exact", "wolfe"
# An exact search may stop where |phi'| is two units of |phi'(0)|; izo_ref's own does.
EXACT_MULTIPLE = 8
PARAMETERS = {
    "first": 1.0,
    "armijo": 2.0**-13,
    "wolfe": 0.125,
    "shrink": 0.5,
    "smallest_step": 2.0**-40,
}


def with_search(
    inputs: Inputs, direction: Sequence[float], search: str, **changes: float
) -> Inputs:
    """Return the inputs of stage S7 with a direction and a search.

    Args:
        inputs: Inputs of stage S7.
        direction: p, flat.
        search: `backtracking`, `exact` or `wolfe`.
        **changes: Parameters of the search that differ from `PARAMETERS`.
    """
    return {**inputs, "direction": list(direction), "search": search, **PARAMETERS, **changes}


def downhill(inputs: Inputs, factors: Sequence[float] = (1.0,)) -> list[float]:
    """Return -factor times the gradient, rounded to float32; factors are repeated for vertices."""
    gradient = evaluate(inputs).gradient
    return [
        0.0 if a.value == 0 else float32(-factors[i % len(factors)] * float(a))
        for i, vector in enumerate(gradient)
        for a in vector
    ]


def case_line_of(inputs: Inputs) -> Line:
    """Return the line of a case."""
    zone, mu = zone_of(inputs), inputs["penalty"]
    return line_of(zone, evaluate(inputs), vectors(inputs["direction"]), mu, curvatures(zone))


def minimum(inputs: Inputs, steps: int) -> Inputs:
    """Return the inputs with positions near the minimum of L, after steps of steepest descent."""
    x = list(inputs["positions"])
    for _ in range(steps):
        here = {**inputs, "positions": x}
        here["direction"] = downhill(here)
        step = float(exact(case_line_of(here)).step)
        x = [float32(a + step * p) for a, p in zip(x, here["direction"], strict=True)]
    return {**inputs, "positions": x}


def add_search(
    result: CaseList,
    flags: str,
    grade: str,
    what: str,
    inputs: Inputs,
    dtypes: tuple[str, ...] = DTYPES,
) -> None:
    """Add a case with what the reference finds; without float32, all inputs are exact."""
    known = inputs if "f4" in dtypes else exact_inputs(inputs)
    with Decisions() as decisions:
        expected = expected_of(known)
    clear = [dtype for dtype in decided(decisions) if dtype in dtypes]
    result.add(flags.split()[0], flags, grade, what, inputs, expected, clear)


def expected_of(inputs: Inputs) -> dict[str, dict[str, Any]]:
    """Return what the judge needs for a search; `Decisions` note how clear each branch was.

    Raises:
        ValueError: No step satisfies the Wolfe conditions.
    """
    line = case_line_of(inputs)
    falls = line.slope < 0.0
    return _expected(line, inputs) if falls else _no_step(line, inputs)


def _expected(line: Line, inputs: Inputs) -> dict[str, dict[str, Any]]:
    if inputs["search"] == BACKTRACKING:
        return _of_found(_backtrack(line, inputs))
    if inputs["search"] == EXACT:
        found = exact(line)
        return {
            "step": values([found.step], EXACT_MULTIPLE),
            "change": values([found.change], EXACT_MULTIPLE),
        }
    interval = wolfe_interval(line, inputs["armijo"], inputs["wolfe"])
    if interval is None:
        raise ValueError("no step satisfies the Wolfe conditions")
    return {"step": between(*interval), "change": between(*change_over(line, *interval))}


def _no_step(line: Line, inputs: Inputs) -> dict[str, dict[str, Any]]:
    if inputs["search"] == BACKTRACKING:
        return _of_found(_backtrack(line, inputs))
    zero = Rounded(ZERO)
    step = values([zero])
    if line.curvature.value == 0:  # p is 0, so every step ends where phi' is 0
        step = between(zero, Rounded.of(inputs["first"]))
    return {"step": step, "change": values([zero])}


def _backtrack(line: Line, inputs: Inputs) -> Found:
    names = "first", "armijo", "shrink", "smallest_step"
    return backtrack(line, *(inputs[name] for name in names))


def _of_found(found: Found) -> dict[str, dict[str, Any]]:
    return {
        "step": values([found.step]),
        "change": values([found.change]),
        "tried": values(found.tried),
    }
