"""Wrong loops of stage S10: each fails at a case that has the flag of its mistake."""

import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.reference import directions, line_search, searches, steps
from izo_ref.porting.reference.rounded import Rounded, clamped, largest
from izo_ref.porting.reference.tracked import Tape, norm
from izo_ref.porting.reference.zone import dot, updated
from tests.helpers.zone_vectors import passes

CASES = load_cases(stages=["S10"])
OUTPUTS = ("objectives", "violations", "positions", "step_sizes")


def reply_of(case, **changes):
    """Return what the reference makes of changed inputs; nothing if it refuses them."""
    try:
        found = steps.iterate({**case.inputs, **changes}, Tape())
    except ValueError:
        return {}
    return {name: [float(x) for x in getattr(found, name)] for name in OUTPUTS}


def caught(flag, change=lambda inputs: {}):
    """Return whether a wrong loop gives a wrong answer at a case of a flag."""
    chosen = [case for case in CASES if flag in case.flags]
    return any(not passes(case, reply_of(case, **change(case.inputs)), "f8") for case in chosen)


def test_the_reference_passes():
    assert all(passes(case, reply_of(case), "f8") for case in CASES)


def swapped(inputs):
    other = {"total-mass": "mean-inverse-mass", "mean-inverse-mass": "total-mass"}
    return {"scaling": other.get(inputs["scaling"], "scaled")}


def counts_pinned(inputs):
    count = len(inputs["pinned"])
    return {"first_step": inputs["first_step"] * count / (count - sum(inputs["pinned"]))}


INPUT_MISTAKES = (
    ("preset-scaling", swapped),
    ("preset-scaling", counts_pinned),
    ("chebyshev-omega", lambda inputs: {"delay": inputs["delay"] + 1}),
    ("chebyshev-omega", lambda inputs: {"delay": max(inputs["delay"] - 1, 0)}),
    ("lbfgs-order", lambda inputs: {"pairs": 100}),
    ("lbfgs-order", lambda inputs: {"pairs": 1}),
    ("inner-solve", lambda inputs: {"every_step": 1}),
    ("inner-solve", lambda inputs: {"inner_steps": inputs["inner_steps"] + 1}),
    ("inner-solve", lambda inputs: {"eps_x": 0.0, "eps_g": 0.0, "eps_f": 0.0}),
    ("inner-solve", lambda inputs: {"inner_accuracy": inputs["inner_accuracy"] ** 2}),
    ("penalty-scaling", lambda inputs: {"penalty": 2.0 * inputs["penalty"]}),
    ("mass-weighting", lambda inputs: {"masses": [1.0] * len(inputs["masses"])}),
    ("armijo", lambda inputs: {"armijo": 0.0}),
    ("armijo", lambda inputs: {"shrink": 0.5 if inputs["shrink"] == 0.7 else 0.7}),
    ("armijo", lambda inputs: {"grow": 1.0 if inputs["grow"] == 2.0 else 2.0}),
    ("newton-active-set", lambda inputs: {"linear_tolerance": 1e-9}),
)


@pytest.mark.parametrize(("flag", "change"), INPUT_MISTAKES)
def test_a_loop_with_another_parameter_fails(flag, change):
    assert caught(flag, change)


def update_before_the_move(monkeypatch):
    def move(zone, inputs, state, step):
        if inputs["every_step"]:
            state.multipliers = updated(state.multipliers, state.c, inputs["penalty"])
        original(zone, inputs, state, step)

    original = steps.move
    monkeypatch.setattr(steps, "move", move)
    monkeypatch.setattr(steps, "updated", lambda multipliers, c, mu: multipliers)


def change_after_the_update(monkeypatch):
    """Take q between gradients with different multipliers."""

    def update(zone, inputs, state, change):
        before = [a - b for a, b in zip(state.gradient, state.change, strict=True)]
        original(zone, inputs, state, change)
        state.change = [a - b for a, b in zip(state.gradient, before, strict=True)]
        if state.pairs:
            state.pairs[-1] = (state.pairs[-1][0], state.change)

    original = steps.update
    monkeypatch.setattr(steps, "update", update)


def omega_without_square(monkeypatch):
    def next_omega(omega, k, delay, rho):
        rho = Rounded.of(rho)
        return Rounded.of(1.0) if k < delay else 4.0 / (4.0 - rho * omega)

    monkeypatch.setattr(directions, "next_omega", next_omega)


def omega_of_the_start_alone(monkeypatch):
    def next_omega(omega, k, delay, rho):
        return original(omega, min(k, delay), delay, rho)

    original = directions.next_omega
    monkeypatch.setattr(directions, "next_omega", next_omega)


def no_restart(monkeypatch):
    def choose_direction(zone, inputs, state):
        state.before = state.x if inputs["direction_name"] == "chebyshev" else state.before
        return original(zone, inputs, state)

    original = steps.choose_direction
    monkeypatch.setattr(steps, "choose_direction", choose_direction)


def acceleration_of_the_step_alone(monkeypatch):
    """Extrapolate from x instead of the point before it."""

    def accelerate(x, before, omega):
        return original(x, [0.5 * (a + b) for a, b in zip(x, before, strict=True)], omega)

    original = directions.accelerate
    monkeypatch.setattr(directions, "accelerate", accelerate)


def fletcher_reeves(monkeypatch):
    def conjugate(gradient, moved, change):
        before = [g - q for g, q in zip(gradient, change, strict=True)]
        beta = dot(gradient, gradient) / dot(before, before)
        return directions.scaled_sum(beta, moved, directions.negative(gradient))

    monkeypatch.setattr(directions, "conjugate", conjugate)


def hestenes_stiefel(monkeypatch):
    def conjugate(gradient, moved, change):
        beta = dot(gradient, change) / dot(moved, change)
        return directions.scaled_sum(beta, moved, directions.negative(gradient))

    monkeypatch.setattr(directions, "conjugate", conjugate)


def oldest_pair_first(monkeypatch):
    original = directions.quasi_newton
    monkeypatch.setattr(directions, "quasi_newton", lambda g, pairs: original(g, pairs[::-1]))


def pairs_forgotten(monkeypatch):
    def update(zone, inputs, state, change):
        original(zone, inputs, state, change)
        state.pairs = [] if state.restart else state.pairs

    original = steps.update
    monkeypatch.setattr(steps, "update", update)


def all_rows_in_the_hessian(monkeypatch):
    for name in ("times_hessian", "hessian_diagonal"):
        original = getattr(directions, name)

        def all_rows(zone, active, mu, *rest, original=original):
            return original(zone, [True] * len(active), mu, *rest)

        monkeypatch.setattr(directions, name, all_rows)


def rows_of_violated_constraints(monkeypatch):
    """Take a constraint for active where c > 0, without its multiplier."""

    def evaluate(zone, inputs, state):
        original(zone, inputs, state)
        state.active = [c.value > 0 for c in state.c]

    original = steps.evaluate
    monkeypatch.setattr(steps, "evaluate", evaluate)


def conjugate_over_inner_solves(monkeypatch):
    """Keep the last direction when the multipliers change."""

    def update(zone, inputs, state, change):
        original(zone, inputs, state, change)
        state.restart = False

    original = steps.update
    monkeypatch.setattr(steps, "update", update)


def multipliers_undivided(monkeypatch):
    """Add l instead of l / mu to c."""

    def evaluate(zone, inputs, state):
        mu, own_multipliers = Rounded.of(inputs["penalty"]), state.multipliers
        state.multipliers = [mu * number for number in own_multipliers]
        original(zone, inputs, state)
        state.multipliers = own_multipliers

    original = steps.evaluate
    monkeypatch.setattr(steps, "evaluate", evaluate)


def multipliers_in_metres(monkeypatch):
    """Add c instead of mu c to l."""
    monkeypatch.setattr(steps, "updated", lambda multipliers, c, mu: updated(multipliers, c, 1.0))


def searches_begin_anew(monkeypatch):
    def search(line, inputs, active, last, alone):
        return original(line, inputs, active, Rounded.of(inputs["first_step"]), alone)

    original = searches.search
    monkeypatch.setattr(searches, "search", search)


def frozen_active_set(monkeypatch):
    """Take L for a parabola along the line: the constraints that are active at x stay so."""

    def at(line, step):
        pairs = zip(line.pushed, line.along, strict=True)
        squares = [q * q for t, q in pairs if t.value > 0]
        second = line.curvature + line.mu * sum(squares, Rounded.of(0.0))
        change = step * (line.slope + 0.5 * second * step)
        return line_search.Point(change, line.slope + second * step, second)

    monkeypatch.setattr(searches, "at", at)
    monkeypatch.setattr(line_search, "at", at)


MISTAKES = (
    ("multiplier-order", update_before_the_move),
    ("multiplier-order", change_after_the_update),
    ("chebyshev-omega", omega_without_square),
    ("chebyshev-omega", omega_of_the_start_alone),
    ("chebyshev-omega", no_restart),
    ("chebyshev-omega", acceleration_of_the_step_alone),
    ("cg-beta", fletcher_reeves),
    ("cg-beta", hestenes_stiefel),
    ("cg-beta", change_after_the_update),
    ("lbfgs-order", oldest_pair_first),
    ("lbfgs-order", pairs_forgotten),
    ("newton-active-set", all_rows_in_the_hessian),
    ("newton-active-set", rows_of_violated_constraints),
    ("inner-solve", conjugate_over_inner_solves),
    ("penalty-scaling", multipliers_undivided),
    ("penalty-scaling", multipliers_in_metres),
    ("armijo", searches_begin_anew),
    ("kink", frozen_active_set),
)


@pytest.mark.parametrize(("flag", "mistake"), MISTAKES)
def test_a_wrong_loop_fails(monkeypatch, flag, mistake):
    mistake(monkeypatch)
    assert caught(flag)


def change_compared_with_l_alone(monkeypatch):
    """Compare the decrease of L with |L|, however small it is."""
    monkeypatch.setattr(steps, "ONE", Rounded.of(0.0))


def largest_entry_for_length(monkeypatch):
    monkeypatch.setattr(steps, "norm", lambda v: largest(abs(a) for a in v))


def uphill_without_momentum(monkeypatch):
    """Ask whether L rises along the step before the acceleration."""

    def choose_direction(zone, inputs, state):
        before = state.before
        if state.moved:
            state.before = [x - s for x, s in zip(state.x, state.moved, strict=True)]
        line = original(zone, inputs, state)
        state.before = before
        return line

    original = steps.choose_direction
    monkeypatch.setattr(steps, "choose_direction", choose_direction)


def residual_in_its_own_norm(monkeypatch):
    monkeypatch.setattr(directions, "_residual", lambda r, w: norm(r))


def shift_of_violations_alone(monkeypatch):
    """Take max(c, 0) for the change of l / mu."""
    monkeypatch.setattr(steps, "smaller", lambda a, b: clamped(-a))


ONLY_THERE = (
    ("S10-arcsim-09", change_compared_with_l_alone),
    ("S10-arcsim-10", largest_entry_for_length),
    ("S10-chebyshev-05", uphill_without_momentum),
    ("S10-newton-07", residual_in_its_own_norm),
    ("S10-gradient-06", shift_of_violations_alone),
)


@pytest.mark.parametrize(("name", "mistake"), ONLY_THERE)
def test_a_wrong_detail_fails_at_the_case_that_is_about_it(monkeypatch, name, mistake):
    (case,) = (case for case in CASES if case.id == name)
    mistake(monkeypatch)
    assert not passes(case, reply_of(case), "f8")
