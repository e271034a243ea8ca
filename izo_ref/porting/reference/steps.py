"""The first iterations of the augmented-Lagrangian methods: stage S10.

    evaluate L and its gradient at x = 0 with l = 0
    repeat:
        choose a direction p
        search a step along p, and move:  x <- x + step p
        chebyshev:  x <- omega (x - x_before) + x_before
        evaluate with the old multipliers: the change of the gradient is q for cg and lbfgs
        with updates after each step, or if the inner solve is done:
            l <- max(l + mu c, 0), evaluate again, and after an inner solve begin anew

The penalty is fixed. The names of the parameters are those of `stages.py`.

Source: docs/method sections 3 and 4; XRTailor documentation, figure `algorithm_cpu`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from izo_ref.porting.reference import directions, searches
from izo_ref.porting.reference.line_search import Line
from izo_ref.porting.reference.rounded import ZERO, Rounded, clamped, largest, total
from izo_ref.porting.reference.tracked import Tape, norm, smaller
from izo_ref.porting.reference.variables import (
    Flat,
    Variables,
    choose_variables,
    displaced,
    objective,
    products,
    pull,
    tracked,
    violation,
)
from izo_ref.porting.reference.zone import dot, updated, zone_of

ONE, NOTHING = Rounded.of(1.0), Rounded(ZERO)


@dataclass
class State:
    """What the loop keeps.

    Attributes:
        x: The unknowns.
        c: The constraints at x.
        multipliers: l.
        step: The last step, which a search with begin = last begins with.
        moved: s, what the last step added to x before the acceleration.
        before: x before that step.
        change: q, the change of the gradient over the last step.
        pairs: The last pairs s, q.
        omega: That of the last step.
        age: Steps since the directions began anew.
        inner: Steps since the multipliers changed.
        restart: Whether the next direction forgets the steps before.
        gradient: Of L.
        pushed: c + l / mu.
        active: Where that is positive; only these constraints count in the generalised Hessian.
        value: L.
    """

    x: Flat
    c: Flat
    multipliers: Flat
    step: Rounded
    before: Flat
    moved: Flat = field(default_factory=list)
    change: Flat = field(default_factory=list)
    pairs: list[tuple[Flat, Flat]] = field(default_factory=list)
    omega: Rounded = ONE
    age: int = 0
    inner: int = 0
    restart: bool = True
    gradient: Flat = field(default_factory=list)
    pushed: Flat = field(default_factory=list)
    active: list[bool] = field(default_factory=list)
    value: Rounded = NOTHING


@dataclass
class Iterations:
    """The outputs of stage S10, and the state after the last step.

    Attributes:
        objectives: 1/2 sum m |x - y|^2 after each step [kg m^2].
        violations: Largest violation after each step [m].
        step_sizes: The step of each line search.
        positions: x of all vertices after the last step [m].
        restarts: Numbers of the steps, from 0, that began anew.
    """

    objectives: Flat = field(default_factory=list)
    violations: Flat = field(default_factory=list)
    step_sizes: Flat = field(default_factory=list)
    positions: Flat = field(default_factory=list)
    restarts: list[int] = field(default_factory=list)


def first_iterations(inputs: Mapping[str, Any]) -> Iterations:
    """Return what the first steps do, with errors; `Decisions` note how clear each branch was.

    Args:
        inputs: The fields of `stages.py`, as flat lists.
    """
    tape = Tape()
    result = iterate(inputs, tape)
    tape.note_decisions()
    return Iterations(
        [tape.rounded(number) for number in result.objectives],
        [tape.rounded(number) for number in result.violations],
        [tape.rounded(number) for number in result.step_sizes],
        [tape.rounded(number) for number in result.positions],
        result.restarts,
    )


def iterate(inputs: Mapping[str, Any], tape: Tape) -> Iterations:
    """Return what the first steps do, in numbers on a tape."""
    result = Iterations()
    zone = tracked(choose_variables(zone_of(inputs), inputs["scaling"]), tape)
    zero = [NOTHING] * len(zone.curvatures)
    no_multipliers = [NOTHING] * len(zone.starts)
    first = tape.leaf(inputs["first_step"])
    state = State(zero, zone.starts, no_multipliers, first, zero)
    evaluate(zone, inputs, state)
    for number in range(inputs["steps"]):
        if inputs["faithful"] and state.inner == 0 and norm(state.gradient) <= inputs["eps_g"]:
            break
        line = choose_direction(zone, inputs, state)
        if state.age == 0:
            result.restarts.append(number)
        found = searches.search(line, inputs, state.active, state.step, not state.pairs)
        if found.step.value == 0 and inputs["faithful"]:
            break  # a search that has failed ends a preset
        if found.step.value == 0:
            raise ValueError("a case that is not of a preset must have no failed search")
        state.step = found.step
        move(zone, inputs, state, found.step)
        result.objectives.append(objective(zone, state.x))
        result.violations.append(violation(zone, state.c))
        result.step_sizes.append(found.step)
        look_back(zone, inputs, state)
        update(zone, inputs, state, found.change)
    result.positions = displaced(zone, inputs, state.x)
    return result


def evaluate(zone: Variables, inputs: Mapping[str, Any], state: State) -> None:
    """Compute L, its gradient, and c + l / mu."""
    mu = Rounded.of(inputs["penalty"])
    rest = [multiplier / mu for multiplier in state.multipliers]
    state.pushed = [c + r for c, r in zip(state.c, rest, strict=True)]
    state.active = [t > 0.0 for t in state.pushed]
    terms = [clamped(t) for t in state.pushed]
    own = [w * x for w, x in zip(zone.curvatures, state.x, strict=True)]
    pulled = pull(zone, [mu * t for t in terms])
    state.gradient = [a - b for a, b in zip(own, pulled, strict=True)]
    squares = total(t * t - r * r for t, r in zip(terms, rest, strict=True))
    state.value = 0.5 * dot(own, state.x) + 0.5 * mu * squares


def choose_direction(zone: Variables, inputs: Mapping[str, Any], state: State) -> Line:
    """Compute the direction p, keep it in `state.moved`, and return the line x + step p."""
    name, mu, g = inputs["direction_name"], Rounded.of(inputs["penalty"]), state.gradient
    if name == "chebyshev":
        rises = dot(g, [a - b for a, b in zip(state.x, state.before, strict=True)])
        state.restart = state.restart or rises > 0.0
    if name == "cg" and not state.restart and state.age + 1 >= len(state.x):
        raise ValueError("a case must end before conjugate gradients begin anew by themselves")
    state.age = 0 if state.restart else state.age + 1
    if name == "cg" and not state.restart:
        p = directions.conjugate(g, state.moved, state.change)
    elif name == "lbfgs":
        p = directions.quasi_newton(g, state.pairs)
    elif name == "newton":
        p = directions.newton(zone, g, state.active, mu, inputs["linear_tolerance"])
    elif inputs["preconditioned"]:
        diagonal = directions.hessian_diagonal(zone, state.active, mu)
        p = [-a / b for a, b in zip(g, diagonal, strict=True)]
    else:
        p = directions.negative(g)
    state.moved, state.restart = p, False
    slope = dot(g, p)
    if not slope < 0.0:
        raise ValueError("a case must have directions of descent")
    curvature = total(w * (v * v) for w, v in zip(zone.curvatures, p, strict=True))
    return Line(slope, curvature, state.pushed, products(zone, p), mu)


def move(zone: Variables, inputs: Mapping[str, Any], state: State, step: Rounded) -> None:
    """Move x, accelerate if the method does, and compute the constraints anew."""
    state.moved = [step * v for v in state.moved]
    here = [x + s for x, s in zip(state.x, state.moved, strict=True)]
    if inputs["direction_name"] == "chebyshev":
        omega = directions.next_omega(state.omega, state.age, inputs["delay"], inputs["rho"])
        if state.age >= inputs["delay"]:
            here = directions.accelerate(here, state.before, omega)
        state.omega = omega
    state.before, state.x = state.x, here
    along = products(zone, state.x)
    state.c = [s - q for s, q in zip(zone.starts, along, strict=True)]


def look_back(zone: Variables, inputs: Mapping[str, Any], state: State) -> None:
    """Evaluate at the new x with the old multipliers, and keep what cg and lbfgs need."""
    old = state.gradient
    evaluate(zone, inputs, state)
    state.change = [a - b for a, b in zip(state.gradient, old, strict=True)]
    if inputs["direction_name"] == "lbfgs":
        if not dot(state.moved, state.change) > 0.0:
            raise ValueError("a case must have pairs of positive curvature")
        state.pairs = [*state.pairs, (state.moved, state.change)][-inputs["pairs"] :]


def update(zone: Variables, inputs: Mapping[str, Any], state: State, change: Rounded) -> None:
    """Update the multipliers after each step, or when an inner solve is done."""
    state.inner += 1
    if not inputs["every_step"] and not inner_solve_is_done(zone, inputs, state, change):
        return
    state.multipliers = updated(state.multipliers, state.c, Rounded.of(inputs["penalty"]))
    state.inner, state.restart = 0, not inputs["every_step"]
    evaluate(zone, inputs, state)


def inner_solve_is_done(
    zone: Variables, inputs: Mapping[str, Any], state: State, change: Rounded
) -> bool:
    """Return whether an inner solve is done, after a step that changed L by `change`."""
    if state.inner >= inputs["inner_steps"]:
        return True
    if inputs["faithful"]:
        if norm(state.gradient) <= inputs["eps_g"] or norm(state.moved) <= inputs["eps_x"]:
            return True
        size = largest([abs(state.value), abs(state.value - change), ONE])
        return -change <= inputs["eps_f"] * size
    error = norm([g / w.sqrt() for g, w in zip(state.gradient, zone.curvatures, strict=True)])
    mu = Rounded.of(inputs["penalty"])
    pairs = zip(state.c, state.multipliers, strict=True)
    shift = norm([smaller(-c, multiplier / mu) for c, multiplier in pairs])
    return error <= inputs["inner_accuracy"] * mu.sqrt() * shift
