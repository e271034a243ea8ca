"""The vectors of stage S8: the line searches."""

from fractions import Fraction

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.generate.lines import case_line_of
from izo_ref.porting.reference.line_search import at, exact, wolfe_interval
from tests.helpers.zone_port import Port, answer
from tests.helpers.zone_vectors import (
    check_cases,
    exact_change,
    exact_rise,
    failures,
    kept_in_float32,
)
from tests.ports.own import s08 as own

FLAGS = (
    "armijo",
    "wolfe-gradient",
    "exact-search",
    "no-step",
    "change-by-difference",
    "absolute-tolerance",
)
CASES = load_cases(stages=["S8"])
DOWNHILL = [case for case in CASES if "no-step" not in case.flags]
ONE_PART = Fraction(1, 10**12)


def test_the_cases_are_complete():
    check_cases(CASES, "S8", FLAGS)


def test_our_own_functions_pass():
    assert failures(CASES, own.answer) == []


def test_a_port_that_is_written_from_the_formulas_passes():
    assert failures(CASES, answer("S8")) == []


@pytest.mark.parametrize("name", ["weights", "normals", "masses", "direction", "multipliers"])
def test_inputs_that_are_kept_in_float32_are_caught(name):
    assert failures(CASES, kept_in_float32(answer("S8"), name), "float32-coordinates")


@pytest.mark.parametrize("case", DOWNHILL[::3], ids=lambda case: case.id)
def test_the_reference_agrees_with_fractions(case):
    line, best = case_line_of(case.inputs), exact(case_line_of(case.inputs)).step
    for factor in (0.25, 1.0, 1.875):
        step = factor * float(best)
        there = at(line, step)
        assert float(there.change) == float(exact_change(case.inputs, Fraction(step)))
        assert float(there.rise) == pytest.approx(float(exact_rise(case.inputs, Fraction(step))))
    step = Fraction(best.value)
    assert exact_rise(case.inputs, step * (1 - ONE_PART)) < 0
    assert exact_rise(case.inputs, step * (1 + ONE_PART)) > 0


@pytest.mark.parametrize("case", DOWNHILL[::3], ids=lambda case: case.id)
def test_the_interval_of_wolfe_ends_where_its_conditions_end(case):
    inputs, line = case.inputs, case_line_of(case.inputs)
    slope = exact_rise(inputs, Fraction(0))
    for c_1, c_2 in ((2.0**-13, 0.125), (0.4375, 0.9375), (0.25, 2.0**-10)):

        def holds(step, c_1=c_1, c_2=c_2):
            is_low = exact_change(inputs, step) < Fraction(c_1) * step * slope
            return is_low and abs(exact_rise(inputs, step)) <= Fraction(c_2) * abs(slope)

        interval = wolfe_interval(line, c_1, c_2)
        assert interval is not None
        low, high = (Fraction(end.value) for end in interval)
        assert holds(low * (1 + ONE_PART))
        assert holds(high * (1 - ONE_PART))
        assert not holds(low * (1 - ONE_PART))
        assert not holds(high * (1 + ONE_PART))


class Decreases(Port):
    def is_low_enough(self, line, step):
        return self.phi(line, step)[0] < 0


class OtherConstant(Port):
    """Takes c_1 from the text of the page, 1e-4, whatever it is."""

    def is_low_enough(self, line, step):
        return self.phi(line, step)[0] < 1e-4 * step * line[0]


class SquareOfDirection(Port):
    def is_low_enough(self, line, step):
        p = self.read("direction", 3)
        return self.phi(line, step)[0] < -self.real(self.inputs["armijo"]) * step * (p * p).sum()


class Halves(Port):
    def shrinks(self):
        return self.real(0.5)


class FrozenActiveSet(Port):
    """Takes phi for a parabola: the impacts that are active at x stay so."""

    def phi(self, line, step):
        slope, curvature, t, q = line
        second = curvature + self.mu() * (q[t > 0] ** 2).sum()
        return step * (slope + second * step / 2), slope + second * step, second


class AtMostOne(Port):
    def best(self, line, step):
        return min(super().best(line, step), self.real(1))


class ArmijoAlone(Port):
    def is_flat_enough(self, line, step):
        return True


class Weak(Port):
    """Takes Wolfe's condition without the absolute value."""

    def is_flat_enough(self, line, step):
        return self.phi(line, step)[1] >= self.real(self.inputs["wolfe"]) * line[0]


class MeanValue(Port):
    """Takes the gradient in the middle of the step, as the page's equations 17 and 20 do."""

    def is_flat_enough(self, line, step):
        return super().is_flat_enough(line, step / 2)


class LastTried(Port):
    def failed(self, step):
        return step


class NotStrict(Port):
    """Accepts a step that does not make phi rise by more than rounding."""

    def is_low_enough(self, line, step):
        limit = self.real(self.inputs["armijo"]) * step * line[0]
        return line[0] >= 0 or self.phi(line, step)[0] <= limit


class DividesByZero(Port):
    def between(self, line, step, is_long, is_right):
        if line[0] < 0:
            return super().between(line, step, is_long, is_right)
        return max(step - self.phi(line, step)[1] / self.phi(line, step)[2], self.real(0))


class AtMostAsLow(Port):
    """Accepts a step that changes nothing, as that along p = 0 does."""

    def is_low_enough(self, line, step):
        return self.phi(line, step)[0] <= self.real(self.inputs["armijo"]) * step * line[0]


class OtherWolfe(Port):
    """Takes c_2 from a textbook, 0.1, whatever it is."""

    def is_flat_enough(self, line, step):
        return abs(self.phi(line, step)[1]) <= self.real(0.1) * abs(line[0])


class Tolerant(Port):
    limit = 1e-7

    def phi(self, line, step):
        slope, curvature, t, q = line
        return super().phi((slope, curvature, np.where(abs(t) < self.limit, 0, t), q), step)


class LessTolerant(Tolerant):
    limit = 1e-10


class Difference(Port):
    """Takes the change as a difference of two values of L."""

    def phi(self, line, step):
        before, x = self.value(), self.x
        self.x = x + step * self.read("direction", 3)
        change = self.value() - before
        self.x = x
        return change, *super().phi(line, step)[1:]


MISTAKES = {
    "armijo": (Decreases, OtherConstant, SquareOfDirection, Halves, FrozenActiveSet),
    "exact-search": (FrozenActiveSet, AtMostOne),
    "wolfe-gradient": (ArmijoAlone, Weak, MeanValue, OtherWolfe),
    "no-step": (LastTried, NotStrict, AtMostAsLow, DividesByZero),
    "change-by-difference": (Difference,),
    "absolute-tolerance": (Tolerant, LessTolerant),
}


@pytest.mark.parametrize("flag", FLAGS)
def test_cases_of_a_flag_catch_its_mistakes(flag):
    for mistake in MISTAKES[flag]:
        found = failures(CASES, answer("S8", mistake), flag)
        assert {dtype for _, dtype in found} == {"f8", "f4"}, mistake
